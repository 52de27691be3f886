// hapticctl load-texture FILE OBJECT: a picture becomes a relief, a model of the Haptic Texture Toolkit a vibration.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <nlohmann/json.hpp>
#include <string_view>

#include "tools/hapticctl/command/command.h"
#include "tools/hapticctl/daemon.h"
#include "tools/hapticctl/failure.h"
#include "tools/hapticctl/file/grey_picture.h"
#include "tools/hapticctl/file/hatt_file.h"
#include "tools/hapticctl/lengths.h"
#include "tools/hapticctl/numbers.h"
#include "tools/hapticctl/option.h"
#include "tools/hapticctl/output/output.h"

namespace hapticctl {
namespace {

struct TextureOptions {
  std::string file, object;
  std::string depth, size;  ///< Empty: as the surface has it.
  double mass_kg = 0;       ///< 0: as the surface has it.
};

/** In capitals, too. */
bool isXml(const std::string& path) {
  constexpr std::string_view kEnd = ".xml";
  const auto alike = [](char a, char b) { return (a >= 'A' && a <= 'Z' ? a - 'A' + 'a' : a) == b; };
  return path.size() > kEnd.size() && std::equal(path.end() - kEnd.size(), path.end(), kEnd.begin(), alike);
}

constexpr FieldOption kSurfaceFields[] = {{"surface.reliefDepth", "--depth"},
                                          {"surface.reliefWidth", "--size"},
                                          {"surface.reliefHeight", "--size"},
                                          {"surface.vibrationMass", "--mass"}};

/** `size`: width and height [m]; empty, or a depth of 0: as the surface has it. */
Owned<haptic_texture_report> uploadRelief(const Daemon& daemon, const TextureOptions& o, double depth_m,
                                          const std::vector<double>& size, haptic_surface& surface) {
  const GreyPicture picture = readPng(o.file);
  if (depth_m > 0) surface.relief_depth = depth_m;
  if (!size.empty()) {
    surface.relief_width = size[0];
    surface.relief_height = size[1];
  }
  auto report =
      daemon.ask<haptic_texture_report>(haptic_upload_relief, picture.grey.data(), picture.width, picture.height);
  surface.relief = report->id;
  return report;
}

/** Tells the friction of the recording, too. */
Owned<haptic_texture_report> uploadVibration(const Daemon& daemon, const TextureOptions& o, haptic_surface& surface,
                                             double& friction) {
  const HattFile file = readHatt(o.file);
  std::vector<haptic_vibration_model> models;
  for (const HattModel& m : file.models) models.push_back({m.speed, m.force, m.variance, m.a.data()});
  const haptic_vibration vibration{sizeof vibration,
                                   static_cast<std::uint32_t>(file.models.front().a.size()),
                                   kHattRateHz,
                                   static_cast<std::uint32_t>(models.size()),
                                   static_cast<std::uint32_t>(file.triangles.size()),
                                   models.data(),
                                   file.triangles.front().data()};
  if (o.mass_kg > 0) surface.vibration_mass = o.mass_kg;
  auto report = daemon.ask<haptic_texture_report>(haptic_upload_vibration, &vibration);
  surface.vibration = report->id;
  friction = file.friction;
  return report;
}

int loadTexture(const TextureOptions& o, const Globals& globals) {
  const bool vibration = isXml(o.file);
  if (vibration && !(o.depth.empty() && o.size.empty()))
    failUsage(!o.depth.empty() ? "--depth" : "--size", "is of a relief; " + o.file + " is a vibration");
  if (!vibration && o.mass_kg > 0) failUsage("--mass", "is of a vibration; " + o.file + " is a relief");
  const double depth_m = o.depth.empty() ? 0 : parseLength("--depth", o.depth);
  const std::vector<double> size = o.size.empty() ? std::vector<double>() : parseLengths("--size", o.size, 2);
  const Daemon daemon(globals);
  const auto state = daemon.ask<haptic_object_state>(haptic_object_find, o.object.c_str());
  haptic_surface surface = *state->surface;
  const std::uint64_t before = vibration ? surface.vibration : surface.relief;
  double friction = 0;
  const auto report =
      vibration ? uploadVibration(daemon, o, surface, friction) : uploadRelief(daemon, o, depth_m, size, surface);
  haptic_error error = HAPTIC_ERROR_INIT;
  const int code = haptic_object_set_surface(daemon.client(), o.object.c_str(), &surface, &error);
  // All or nothing; and what nothing shows any more need not stay.
  if (code != HAPTIC_OK) haptic_texture_drop(daemon.client(), report->id, nullptr);
  try {
    check(code, error);
  } catch (Failure& failure) {
    failure.where = optionOf(failure.where, kSurfaceFields);
    throw;
  }
  if (before != 0) haptic_texture_drop(daemon.client(), before, nullptr);
  if (globals.json) {
    nlohmann::json json{{"object", o.object}, {"texture", report->id}, {"kind", vibration ? "vibration" : "relief"}};
    if (friction > 0) json["friction"] = friction;
    putJson(json);
  } else if (vibration) {
    print("{}: vibration of {} models{}, texture {}\n", o.object, report->models,
          friction > 0 ? fmt::format(", recorded at friction {}", friction) : std::string(), report->id);
  } else {
    print("{}: relief of {} x {} pixels, {} x {}, {} deep, texture {}\n", o.object, report->width, report->height,
          length(surface.relief_width), length(surface.relief_height), length(surface.relief_depth), report->id);
  }
  return kExitOk;
}

}  // namespace

void addLoadTexture(CLI::App& app, Action& chosen) {
  CLI::App* command = app.add_subcommand("load-texture",
                                         "Lay a picture (PNG) or a model of recorded vibration "
                                         "(XML of the Haptic Texture Toolkit) on an object");
  auto o = std::make_shared<TextureOptions>();
  command->add_option("FILE", o->file, "FILE.png: heights by grey; FILE.xml: a texture model")->required();
  command->add_option("OBJECT", o->object, "Name of the object")->required();
  command->add_option("--depth", o->depth, "How deep black lies below white (0.0005, 0.5mm)")->type_name("LENGTH");
  command->add_option("--size", o->size, "Width and height of the picture on the object, about its origin")
      ->type_name("WIDTH,HEIGHT");
  command->add_option("--mass", o->mass_kg, "Force per recorded acceleration")->type_name("KG")->check(positive());
  whenNamed(command, chosen, [o](const Globals& globals) { return loadTexture(*o, globals); });
}

}  // namespace hapticctl
