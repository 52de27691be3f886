/** @file
 * hapticctl import FILE: what is dense in a scan becomes something to touch. Draws the surface and has hapticctl load
 * it; options of `hapticctl load` are handed on.
 */
#include <fmt/core.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <filesystem>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "rt/base/standard_streams.h"
#include "tools/hapticctl-import/child.h"
#include "tools/hapticctl-import/format/image_file.h"
#include "tools/hapticctl-import/hand_over.h"
#include "tools/hapticctl-import/input.h"
#include "tools/hapticctl-import/isosurface.h"
#include "tools/hapticctl-import/model.h"
#include "tools/options/help.h"
#include "tools/options/load_values.h"
#include "tools/options/number.h"
#include "tools/options/units.h"

namespace hapticctl_import {
namespace {

enum Exit { kDone = 0, kRefused = 1, kUsage = 2, kFile = 5 };

struct Options {
  InputOptions input;
  std::string crop, output, vdb, voxel_mm;
  std::optional<double> iso, label;
  double smooth_mm = 0, resample_mm = 0;
  unsigned shrink = 1;
  bool largest = false;
};

using hapticd_options::isNumber;

/** As a variable that is not set leaves it. */
std::string isThere(const std::string& text) { return text.empty() ? "is empty" : std::string(); }

/** Where the surface is. Turns distances about, so that what is solid is high. */
float levelOf(const Options& o, Image& image) {
  if (o.label) return 0.5f;
  if (!o.iso && !image.usual_iso)
    throw ImportError("--iso or --label", "is needed: what of this is solid?", "bone in CT is --iso 226");
  constexpr double kMost =
      std::numeric_limits<float>::max();  // Beyond it nothing would stand out from what is outside.
  const float iso = o.iso ? static_cast<float>(std::clamp(*o.iso, -kMost, kMost)) : *image.usual_iso;
  if (!image.distances) return iso;
  for (float& v : image.values) v = -v;
  return -iso;
}

/** The surface as files: all that deals with bytes of others. Says what it found. */
int draw(const Options& o, const std::string& output) {
  for (const std::string& path : {output, o.vdb}) {
    if (path.empty()) continue;
    requireWritable(path);
    if (areOneFile(path, o.input.file))
      throw ImportError(path, "is the file that is imported", "name another one to write");
  }
  if (!output.empty() && !o.vdb.empty() && areOneFile(output, o.vdb) && output != "/dev/null")
    throw ImportError("--vdb", o.vdb + " is the surface's file", "name another one to write");
  if (!o.output.empty()) requireEnding(o.output, ".ply");
  if (!o.vdb.empty()) requireEnding(o.vdb, ".vdb");
  Image image = readInput(o.input);
  fmt::print("{}\n", describe(image));
  const float level = levelOf(o, image);
  if (o.label) chooseLabel(image, *o.label);
  if (!o.crop.empty()) image = cropped(image, o.crop);
  if (o.smooth_mm > 0) smooth(image, o.smooth_mm);
  if (o.shrink > 1) image = shrink(image, o.shrink);
  if (o.resample_mm > 0) image = resample(std::move(image), o.resample_mm);
  Surface surface = isosurface(image, level);
  if (surface.triangles.empty()) {
    throw ImportError(o.label ? "--label" : "--iso",
                      o.label ? "no value is that: there is no surface" : "no value reaches it: there is no surface",
                      "choose one within the values above");
  }
  const std::size_t all = surface.triangles.size();
  std::string parts;
  if (o.largest) parts = fmt::format(", the largest of {} parts", keepLargest(surface));
  fmt::print("{} triangles{} of {}, {:.4g} cm3 within\n", surface.triangles.size(), parts, all,
             volumeOf(surface) * 1e-3);
  std::optional<PreparedFile> ply;
  if (!o.output.empty()) ply.emplace(output, toPly(surface));
  if (!output.empty() && !ply) writeInPlace(output, toPly(surface));
  if (!o.vdb.empty()) fmt::print("{}\n", writeModel(surface, numbersIn(o.voxel_mm, "--voxel", 1).front(), o.vdb));
  if (ply) ply->keep();
  requireSaid();
  return kDone;
}

int report(const std::string& file, const std::function<int()>& work) {
  try {
    return work();
  } catch (const ImportError& error) {
    const std::string at = error.where.empty() || error.where == file ? file : file + ": " + error.where;
    hapticd::tellError(fmt::format("hapticctl import: {}: {}{}\n", at, error.what(),
                                   error.remedy.empty() ? "" : " (" + error.remedy + ")"));
    return kFile;
  } catch (const std::bad_alloc&) {
    hapticd::tellError(fmt::format(
        "hapticctl import: {}: is too large for this machine's memory, or damaged (see --crop, --shrink)\n", file));
    return kFile;
  } catch (const std::exception& error) {
    hapticd::tellError(fmt::format("hapticctl import: {}: {}\n", file, error.what()));
    return kRefused;
  }
}

int run(const Options& o, const std::vector<std::string>& rest) {
  const std::string& file = o.input.file;
  const auto given = [&rest](const std::string& option) {
    return std::any_of(rest.begin(), rest.end(),
                       [&](const std::string& word) { return word == option || word.rfind(option + "=", 0) == 0; });
  };
  // A reader that dies of a damaged file takes nothing with it.
  const auto drawInChild = [&](const std::string& output) {
    return inChild([&] {
      if (given("--json")) ::dup2(STDERR_FILENO, STDOUT_FILENO);  // What load answers stands alone.
      return report(file, [&] { return draw(o, output); });
    });
  };
  if (!o.output.empty() || !o.vdb.empty()) return drawInChild(o.output);
  const TemporaryFile ply;
  if (const int code = drawInChild(ply.path()); code != kDone) return code;
  std::vector<std::string> words = {"hapticctl", "load", ply.path()};
  if (!given("--size")) words.insert(words.end(), {"--scale", "mm"});
  if (!given("--name")) {
    const std::filesystem::path path = std::filesystem::path(file).lexically_normal();
    std::string name = (path.has_filename() ? path : path.parent_path()).stem().string().substr(0, 63);
    for (char& c : name)
      if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
    words.insert(words.end(), {"--name", name});
  }
  if (!o.voxel_mm.empty()) words.insert(words.end(), {"--voxel", o.voxel_mm});
  words.insert(words.end(), rest.begin(), rest.end());
  return runHapticctl(words);
}

void addOptions(CLI::App& app, Options& o) {
  app.add_option("FILE", o.input.file, "The image, or a folder of DICOM slices")->required()->check(isThere);
  app.add_option("--series", o.input.series, "Which of several DICOM series: its number in the list, or its identifier")
      ->check(isThere);
  app.add_option("--grid", o.input.grid, "Which of several grids of a .vdb: its number in the list, or its name")
      ->check(isThere);
  app.add_option("--scale", o.input.scale, "The unit of a .vdb that does not say it")
      ->type_name("UNIT|NUMBER")
      ->check(isThere);
  auto* iso = app.add_option("--iso", o.iso,
                             "Solid is what has at least this value (bone in CT: 226), of distances at most (.vdb: 0)")
                  ->check(isNumber);
  app.add_option("--label", o.label, "Solid is what has exactly this value")->check(isNumber)->excludes(iso);
  app.add_option("--crop", o.crop, "Only this part, in values of the file")
      ->type_name("X0:X1,Y0:Y1,Z0:Z1")
      ->check(isThere);
  app.add_option("--smooth", o.smooth_mm, "Smooth by a Gaussian of this deviation")
      ->type_name("MM")
      ->check(CLI::Range(0.0, 100.0))
      ->check(isNumber)
      ->transform(hapticd_options::millimetres);
  app.add_option("--shrink", o.shrink, "Replace each block of N x N x N values by its mean")
      ->type_name("N")
      ->check(CLI::Range(1u, 64u))
      ->transform(hapticd_options::decimal);
  app.add_option("--resample", o.resample_mm, "Interpolate to values that are as far apart along each axis")
      ->type_name("MM")
      ->check(CLI::Range(0.001, 1000.0))
      ->check(isNumber)
      ->transform(hapticd_options::millimetres);
  app.add_flag("--largest", o.largest, "Only the connected part with the most triangles");
  auto* raw =
      app.add_option("--raw", o.input.raw, "The file is raw numbers of this kind")->type_name("int16|uint8|float|...");
  auto* raw_size =
      app.add_option("--raw-size", o.input.raw_size, "How many along each axis")->type_name("X,Y,Z")->needs(raw);
  raw->needs(raw_size);
  app.add_option("--raw-spacing", o.input.raw_spacing, "How far apart [mm]; else 1")
      ->type_name("X,Y,Z")
      ->check(isThere)
      ->needs(raw);
  app.add_flag("--raw-big-endian", o.input.big_endian, "Most significant byte first")->needs(raw);
  app.add_option("--output", o.output, "Write the surface in millimetres and load nothing")
      ->type_name("FILE.ply")
      ->check(isThere);
  auto* voxel = app.add_option("--voxel", o.voxel_mm, "Build its volume too, of voxels of this side")
                    ->type_name("MM")
                    ->check(CLI::Range(0.001, 1000.0))
                    ->check(isNumber)
                    ->transform(hapticd_options::millimetres);
  app.add_option("--vdb", o.vdb, "Write the volume's distances as an OpenVDB level set and load nothing")
      ->type_name("FILE.vdb")
      ->check(isThere)
      ->needs(voxel);
}

}  // namespace
}  // namespace hapticctl_import

int main(int argc, char** argv) {  // NOLINT(bugprone-exception-escape): ends the program, as it should
  hapticd::holdStandardStreams();
  std::signal(SIGXFSZ, SIG_IGN);     // A file that may not grow is told as one that could not be written.
  std::signal(SIGPIPE, SIG_IGN);     // Who does not want to read on wants it loaded all the same.
  using namespace hapticctl_import;  // NOLINT(google-build-using-namespace)
  Options o;
  CLI::App app{"Draw the surface of what is dense in a scan, and load it as something to touch.", "hapticctl import"};
  app.footer(
      "Reads DICOM series (a folder, or one of its files), NIfTI, NRRD, MetaImage, OpenVDB, InVesalius projects and\n"
      "raw numbers. Further options go to hapticctl load: --points, --center, --name, --at, --friction, ...");
  app.allow_extras();
  addOptions(app, o);
  app.failure_message([](const CLI::App*, const CLI::Error& error) {
    return fmt::format("hapticctl import: {} (hapticctl import --help tells how)\n", error.what());
  });
  // What is not known here would give its value away: the file were the name of the object, and the other way about.
  std::vector<std::string> words(argv + std::min(argc, 1), argv + argc);
  std::vector<std::string> rest = hapticd_options::takeLoadValues(words);
  std::reverse(words.begin(), words.end());
  try {
    app.parse(std::move(words));
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() != 0) return app.exit(error), kUsage;
    return report("--help",
                  [&] { return fmt::print("{}", hapticd_options::helpOf(app, error)), requireSaid(), kDone; });
  }
  const std::vector<std::string> others = app.remaining();
  rest.insert(rest.end(), others.begin(), others.end());
  if (!rest.empty() && !(o.output.empty() && o.vdb.empty())) {
    hapticd::tellError(fmt::format(
        "hapticctl import: {}: is no option of it, and nothing is loaded that others could be for\n", rest[0]));
    return kUsage;
  }
  return report(o.input.file, [&] { return run(o, rest); });
}
