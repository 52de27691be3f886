// hapticctl load FILE --scale S: a mesh file becomes something to touch.
#include <CLI/CLI.hpp>
#include <cstring>
#include <iostream>
#include <memory>

#include "tools/hapticctl/command/command.h"
#include "tools/hapticctl/command/placement.h"
#include "tools/hapticctl/daemon.h"
#include "tools/hapticctl/failure.h"
#include "tools/hapticctl/file/mesh_scale.h"
#include "tools/hapticctl/file/read_mesh.h"
#include "tools/hapticctl/lengths.h"
#include "tools/hapticctl/numbers.h"
#include "tools/hapticctl/option.h"
#include "tools/hapticctl/output/output.h"
#include "tools/hapticctl/output/terminal.h"
#include "tools/hapticctl/output/to_json.h"

namespace hapticctl {
namespace {

struct LoadOptions {
  std::string file, scale, size;
  double size_m = 0, weld_mm = 0, voxel_mm = 0, point_spacing_mm = 0;
  bool centre = false, deformable = false, fill_holes = false;
  Placement placement;
};

/** The scale is the user's to give: few files know their unit, and a guess would be felt. */
double chooseScale(const LoadOptions& options, const MeshFile& mesh) {
  double longest = 0;
  for (std::size_t i = 0; i < 3; ++i) longest = std::max(longest, mesh.upper[i] - mesh.lower[i]);
  if (longest == 0)
    throw Failure{kExitFile, mesh.path, "all its vertices are in one place", "export it again", "BAD_MESH"};
  if (!options.scale.empty()) return parseScale(options.scale);
  if (options.size_m > 0) return options.size_m / longest;
  if (!stdinIsTerminal() || !stdoutIsTerminal()) {
    failUsage(mesh.path, "a scale is needed: " + whyScale(mesh), scaleAdvice(mesh));
  }
  print("{}: {}\n{}\nUnit, or metres per file unit: ", printable(mesh.path), whyScale(mesh), scaleAdvice(mesh));
  flush();
  std::string answer;
  if (!std::getline(std::cin, answer) || answer.empty()) failUsage(mesh.path, "no scale given, nothing loaded");
  return parseScale(answer);
}

/** Draws the bar; a signal cancels the build. */
int onProgress(float fraction, const char* stage, void* live) {
  static_cast<LiveLine*>(live)->show(progressBar(static_cast<double>(fraction), stage));
  return Interrupt::asked() ? 1 : 0;
}

std::string describe(const std::string& name, const MeshFile& mesh, const haptic_mesh_report& r) {
  std::string out = fmt::format("{}: {} triangles, {} vertices, {} x {} x {}, {}", name, grouped(r.triangles),
                                grouped(r.vertices), length(r.upper[0] - r.lower[0]), length(r.upper[1] - r.lower[1]),
                                length(r.upper[2] - r.lower[2]), r.closed != 0 ? "closed" : "open");
  if (mesh.meshes > 1) out += fmt::format(", {} meshes merged", mesh.meshes);
  if (mesh.skipped > 0) out += fmt::format(", {} points or lines left out", mesh.skipped);
  out += fmt::format("; {} in the daemon, built in {}\n", bytes(r.bytes), duration(static_cast<double>(r.build_ns)));
  for (std::uint32_t i = 0; i < r.note_count; ++i) out += fmt::format("  note: {}\n", r.notes[i]);
  return out;
}

/** Sends the mesh and waits for the builder. */
int upload(haptic_client* client, const MeshFile& mesh, const LoadOptions& options, LiveLine& live,
           haptic_mesh_report** built, haptic_error& error) {
  const auto vertices = static_cast<std::uint32_t>(mesh.vertices.size());
  const auto triangles = static_cast<std::uint32_t>(mesh.triangles.size());
  std::uint32_t flags = options.deformable ? HAPTIC_MESH_DEFORMABLE : 0;
  if (options.voxel_mm > 0) flags |= HAPTIC_MESH_VOLUME;
  if (options.fill_holes) flags |= HAPTIC_MESH_FILL_HOLES;
  haptic_upload* raw = nullptr;
  if (const int code = haptic_upload_begin(client, vertices, triangles, flags, &raw, &error); code != 0) return code;
  const std::unique_ptr<haptic_upload, decltype(&haptic_upload_close)> upload(raw, haptic_upload_close);
  std::memcpy(haptic_upload_vertices(raw), mesh.vertices.data(), vertices * sizeof mesh.vertices[0]);
  std::memcpy(haptic_upload_triangles(raw), mesh.triangles.data(), triangles * sizeof mesh.triangles[0]);
  if (const int code = haptic_upload_weld(raw, options.weld_mm * 1e-3, &error); code != 0) return code;
  if (options.voxel_mm > 0) {
    const int code = haptic_upload_volume(raw, options.voxel_mm * 1e-3, options.point_spacing_mm * 1e-3, &error);
    if (code != 0) return code;
  }
  return haptic_upload_commit(raw, onProgress, &live, 0, built, &error);
}

int load(LoadOptions& options, const Globals& globals) {
  const Interrupt interrupt;
  LiveLine live;
  // A wrong one is told before the long work.
  if (!options.scale.empty()) (void)parseScale(options.scale);
  if (!options.size.empty()) options.size_m = parseLength("--size", options.size);
  live.show("reading " + printable(options.file));
  MeshFile mesh = readMesh(options.file);
  live.clear();
  const double metres_per_unit = chooseScale(options, mesh);
  if (options.centre) centre(mesh);
  scale(mesh, metres_per_unit, options.size_m > 0 ? "--size" : "--scale");
  const std::string odd = options.size_m > 0 ? std::string() : sizeNote(mesh);
  if (!odd.empty()) note("hapticctl: " + odd);
  Placement& placement = options.placement;
  if (placement.name.empty()) placement.name = nameOf(options.file);
  haptic_object object = makeObject(placement);

  const Daemon daemon(globals);
  if (mesh.vertices.size() > UINT32_MAX || mesh.triangles.size() > UINT32_MAX) {
    throw Failure{kExitFile, mesh.path, "has more than 2^32 vertices or triangles", "make it coarser", "BAD_MESH"};
  }
  requirePlace(daemon, placement);
  live.show(progressBar(0, "uploading"));
  haptic_mesh_report* built = nullptr;
  haptic_error error = HAPTIC_ERROR_INIT;
  const int code = upload(daemon.client(), mesh, options, live, &built, error);
  const Owned<haptic_mesh_report> report(built);
  live.clear();
  if (code == HAPTIC_CANCELLED)
    throw Failure{kExitRefused, mesh.path, "cancelled; nothing was loaded", {}, "CANCELLED"};
  try {
    check(code, error);
  } catch (Failure& failure) {  // "vertex 3" alone is no place.
    if (failure.exit == kExitRefused)
      failure.where = failure.where.empty() ? mesh.path : mesh.path + ": " + failure.where;
    throw;
  }

  object.shape.kind = HAPTIC_SHAPE_MESH;
  object.shape.mesh = report->id;
  std::uint32_t id = 0;
  try {
    id = place(daemon, placement, object);
  } catch (...) {
    haptic_mesh_drop(daemon.client(), report->id, nullptr);  // All or nothing.
    throw;
  }
  if (globals.json) {
    Json json = toJson(*report);
    json["name"] = placement.name;
    json["object"] = id;
    json["scale"] = metres_per_unit;
    json["merged"] = mesh.meshes;
    json["skipped"] = mesh.skipped;
    putJson(json);
  } else {
    put(describe(placement.name, mesh, *report));
  }
  return kExitOk;
}

}  // namespace

void addLoad(CLI::App& app, Action& chosen) {
  CLI::App* command = app.add_subcommand("load", "Load a mesh file (STL, OBJ, PLY, 3DS, glTF, ...) into the scene");
  auto o = std::make_shared<LoadOptions>();
  command->add_option("FILE", o->file, "The mesh file")->required();
  auto* scale =
      command->add_option("--scale", o->scale, "The file's unit (mm, cm, m, inch, um, ft) or metres per unit; needed")
          ->type_name("UNIT|NUMBER");
  command->add_option("--size", o->size, "Instead of a scale: how long the longest side shall be (0.1, 100mm)")
      ->type_name("LENGTH")
      ->excludes(scale);
  command->add_flag("--center,--centre", o->centre, "Move the middle of its box to the object's origin");
  command->add_flag("--deformable", o->deformable, "Its vertices may be moved by clients");
  command->add_option("--weld", o->weld_mm, "Join vertices no farther apart than this, for scans; else only equal ones")
      ->type_name("MM")
      ->transform(hapticd_options::millimetres)
      ->check(number(0.001, 10));
  auto* voxel = command->add_option("--voxel", o->voxel_mm, "Build its volume too, of voxels of this side: for 6 DOF")
                    ->type_name("MM")
                    ->transform(hapticd_options::millimetres)
                    ->check(number(0.001, 1000));
  command
      ->add_option("--points", o->point_spacing_mm, "How far apart the volume's surface points shall be; else a voxel")
      ->type_name("MM")
      ->transform(hapticd_options::millimetres)
      ->check(number(0, 1000))
      ->needs(voxel);
  command->add_flag("--fill-holes", o->fill_holes, "Close the holes of an open mesh for its volume; else it is refused")
      ->needs(voxel);
  addPlacement(*command, o->placement);
  whenNamed(command, chosen, [o](const Globals& globals) { return load(*o, globals); });
}

}  // namespace hapticctl
