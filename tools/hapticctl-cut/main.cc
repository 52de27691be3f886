/** @file
 * hapticctl cut MESH: takes a piece out of a closed mesh along a rough cut; both parts become meshes that fit together.
 */
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <filesystem>

#include "rt/base/standard_streams.h"
#include "tools/hapticctl-cut/cut.h"
#include "tools/hapticctl-import/hand_over.h"
#include "tools/hapticctl/failure.h"
#include "tools/hapticctl/file/read_mesh.h"
#include "tools/hapticctl/option.h"
#include "tools/hapticctl/output/output.h"
#include "tools/options/help.h"

namespace hapticctl_cut {
namespace {

using hapticctl::number;
using hapticctl::parseVec3;
using hapticctl_import::Surface;

struct Options {
  std::string file, plane, shell, pull, body, fragment;
  CutOptions cut;
};

Vec3 vec3(const std::string& option, const std::string& text) {
  const auto x = parseVec3(option, text);
  return {x[0], x[1], x[2]};
}

std::string besides(const std::string& file, const char* part) {
  const std::filesystem::path path(file);
  return (path.parent_path() / (path.stem().string() + part)).string();
}

void tell(const char* what, const std::string& path, const Surface& surface, double whole) {
  std::array<float, 3> lower = surface.vertices.front(), upper = lower;
  for (const auto& v : surface.vertices) {
    for (std::size_t k = 0; k < 3; ++k) {
      lower[k] = std::min(lower[k], v[k]);
      upper[k] = std::max(upper[k], v[k]);
    }
  }
  const double volume = hapticctl_import::volumeOf(surface);
  fmt::print(
      "{:<9} {}: {} triangles, {:.4g} cubic units ({:.2f} % of the whole), from ({:.4g}, {:.4g}, {:.4g}) to ({:.4g}, "
      "{:.4g}, {:.4g})\n",
      what, hapticctl::printable(path), surface.triangles.size(), volume, 100 * volume / whole, lower[0], lower[1],
      lower[2], upper[0], upper[1], upper[2]);
}

/** What is written must not be what is read, nor each other. */
void requireThreeFiles(const Options& o) {
  using hapticctl_import::areOneFile;
  if (areOneFile(o.file, o.body))
    hapticctl::failUsage("--body", o.body + " is the mesh that is cut", "name another file");
  if (areOneFile(o.file, o.fragment))
    hapticctl::failUsage("--fragment", o.fragment + " is the mesh that is cut", "name another file");
  if (o.body != "/dev/null" && areOneFile(o.body, o.fragment))
    hapticctl::failUsage("--fragment", o.fragment + " is the body's file", "name another file");
}

int run(Options& o) {
  if (o.body.empty()) o.body = besides(o.file, "-body.ply");
  if (o.fragment.empty()) o.fragment = besides(o.file, "-fragment.ply");
  requireThreeFiles(o);
  for (const std::string& path : {o.body, o.fragment}) {
    hapticctl_import::requireWritable(path);
    hapticctl_import::requireEnding(path, ".ply");
  }
  CutShape& shape = o.cut.shape;
  shape.shell = !o.shell.empty();
  shape.at = shape.shell ? vec3("--shell", o.shell) : vec3("--plane", o.plane);
  shape.pull = vec3("--pull", o.pull);
  if (shape.pull.isZero(0)) hapticctl::failUsage("--pull", "has no direction", "for example 0,0,1");
  hapticctl::MeshFile file = hapticctl::readMesh(o.file);
  Surface mesh{std::move(file.vertices), std::move(file.triangles)};
  const double whole = hapticctl_import::volumeOf(mesh);
  const CutParts parts = cut(mesh, o.cut);
  hapticctl_import::PreparedFile body(o.body, hapticctl_import::toPly(parts.body));
  hapticctl_import::PreparedFile fragment(o.fragment, hapticctl_import::toPly(parts.fragment));
  body.keep();  // Those of one cut, or none: they fit no others.
  fragment.keep();
  fmt::print("whole     {}: {} triangles, {:.4g} cubic units; {} lattice points\n", hapticctl::printable(o.file),
             mesh.triangles.size(), whole, parts.points);
  tell("body", o.body, parts.body, whole);
  tell("fragment", o.fragment, parts.fragment, whole);
  if (parts.crumbs > 0) {
    fmt::print("crumbs    {} loose pieces on the fragment's side are in neither, {:.3g} cubic units\n", parts.crumbs,
               parts.crumbs_volume);
  }
  hapticctl_import::requireSaid();
  return hapticctl::kExitOk;
}

}  // namespace
}  // namespace hapticctl_cut

int main(int argc, char** argv) {  // NOLINT(bugprone-exception-escape): ends the program, as it should
  hapticd::holdStandardStreams();
  std::signal(SIGXFSZ, SIG_IGN);  // A file that may not grow is told as one that could not be written.
  std::signal(SIGPIPE, SIG_IGN);  // A reader that leaves is no fault.
  using namespace hapticctl_cut;  // NOLINT(google-build-using-namespace)
  Options o;
  CLI::App app{"Cut a piece out of a closed mesh: two closed meshes that fit together, as PLY.", "hapticctl cut"};
  app.footer("Lengths are in the file's unit, millimetres for what hapticctl import --output writes.");
  app.add_option("MESH", o.file, "The mesh file (STL, OBJ, PLY, ...), closed")->required();
  auto* plane = app.add_option("--plane", o.plane, "Cut along a plane through this point")->type_name("X,Y,Z");
  auto* shell = app.add_option("--shell", o.shell, "Cut along a ball about this point; the fragment is inside")
                    ->type_name("X,Y,Z")
                    ->excludes(plane);
  auto* radius =
      app.add_option("--radius", o.cut.shape.radius, "Radius of the ball")->check(hapticctl::positive())->needs(shell);
  shell->needs(radius);
  app.add_option("--pull", o.pull, "The way the fragment comes out; a plane's normal")->type_name("X,Y,Z")->required();
  app.add_option("--noise", o.cut.shape.noise, "Roughness of the cut, root mean square")->check(number(0));
  app.add_option("--wavelength", o.cut.shape.wavelength, "Its shortest wave; the longest is twice that")
      ->check(hapticctl::positive())
      ->default_val(8);
  app.add_option("--seed", o.cut.shape.seed, "Another number, another roughness")
      ->check(number(0, 9e18))  // Else -1, and what has too many digits, are the largest number that there is.
      ->transform(hapticctl::decimal)
      ->default_val(1);
  app.add_option("--kerf", o.cut.kerf, "Width of what the saw takes away")->check(number(0));
  app.add_option("--voxel", o.cut.voxel, "How finely the parts are drawn about the cut")
      ->check(hapticctl::positive())
      ->default_val(0.5);
  app.add_option("--coarse", o.cut.coarse, "How coarsely away from it; without it as finely")
      ->check(hapticctl::positive());
  app.add_option("--body", o.body, "Where the body goes; else MESH-body.ply")->type_name("FILE.ply");
  app.add_option("--fragment", o.fragment, "Where the fragment goes; else MESH-fragment.ply")->type_name("FILE.ply");
  app.failure_message([](const CLI::App*, const CLI::Error& error) {
    return fmt::format("hapticctl cut: {} (hapticctl cut --help tells how)\n", error.what());
  });
  std::string help;
  try {
    app.parse(argc, argv);
    if (plane->count() + shell->count() == 0) throw CLI::RequiredError("--plane or --shell");
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() != 0) return app.exit(error), hapticctl::kExitUsage;
    help = hapticd_options::helpOf(app, error);
  }
  const auto fail = [](int code, const std::string& where, const std::string& what, const std::string& remedy) {
    hapticd::tellError(
        fmt::format("hapticctl cut: {}: {}{}\n", where, what, remedy.empty() ? "" : " (" + remedy + ")"));
    return code;
  };
  try {
    if (help.empty()) return run(o);
    fmt::print("{}", help);
    hapticctl_import::requireSaid();
    return hapticctl::kExitOk;
  } catch (const hapticctl::Failure& failure) {
    return fail(failure.exit, failure.where.empty() ? o.file : failure.where, failure.what, failure.remedy);
  } catch (const hapticctl_import::ImportError& error) {
    return fail(hapticctl::kExitFile, error.where.empty() ? o.file : error.where, error.what(), error.remedy);
  } catch (const std::exception& error) {
    return fail(hapticctl::kExitRefused, o.file, error.what(), {});
  }
}
