/** @file
 * hapticctl import FILE: what is dense in a scan becomes something to touch. Draws the surface and has hapticctl load
 * it; options of `hapticctl load` are handed on.
 */
#include <fmt/core.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <climits>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "tools/hapticctl-import/image_file.h"
#include "tools/hapticctl-import/isosurface.h"

namespace hapticctl_import {
namespace {

enum Exit { kDone = 0, kRefused = 1, kUsage = 2, kFile = 5 };

struct Options {
  std::string file, crop, raw, raw_size, raw_spacing = "1,1,1", output;
  double iso = 0, label = 0, smooth_mm = 0;
  unsigned shrink = 1;
  bool largest = false, big_endian = false;
};

Image readImage(const Options& o) {
  const std::string bytes = readFile(o.file);
  if (o.raw.empty()) {
    const std::filesystem::path folder = std::filesystem::path(o.file).parent_path();
    return parseImage(bytes, [&](const std::string& name) { return readFile((folder / name).string()); });
  }
  RawLayout layout;
  const auto sample = sampleOf(o.raw);
  if (!sample) throw ImportError("--raw", fmt::format("'{}' is no kind of number", o.raw), "int16, uint8, float, ...");
  layout.sample = *sample;
  layout.size = sizesIn(o.raw_size, "--raw-size");
  const auto steps = numbersIn(o.raw_spacing, "--raw-spacing", 3);
  std::copy(steps.begin(), steps.end(), layout.spacing.begin());
  layout.big_endian = o.big_endian;
  return parseRaw(bytes, layout);
}

/** "0:100,20:80,0:50" */
Image cropped(const Image& image, const std::string& text) {
  std::string plain = text;
  std::replace(plain.begin(), plain.end(), ':', ' ');
  const auto n = numbersIn(plain, "--crop", 6);
  std::array<std::uint32_t, 3> first{}, end{};
  for (std::size_t k = 0; k < 3; ++k) {
    if (!(n[2 * k] >= 0 && n[2 * k + 1] > n[2 * k] && n[2 * k + 1] < 1e6))
      throw ImportError("--crop", "is not FIRST:END for each axis", "for example 0:100,20:80,0:50");
    first[k] = static_cast<std::uint32_t>(n[2 * k]);
    end[k] = static_cast<std::uint32_t>(n[2 * k + 1]);
  }
  return crop(image, first, end);
}

std::string describe(const Image& image) {
  const auto [low, high] = std::minmax_element(image.values.begin(), image.values.end());
  return fmt::format("{}: {} x {} x {} values, {:.4g} x {:.4g} x {:.4g} mm apart, from {:g} to {:g}", image.format,
                     image.size[0], image.size[1], image.size[2], spacing(image, 0), spacing(image, 1),
                     spacing(image, 2), *low, *high);
}

/** A file that goes when it is no longer needed. */
class TemporaryFile {
 public:
  TemporaryFile() {
    path_ = (std::filesystem::temp_directory_path() / "hapticctl-import-XXXXXX.ply").string();
    const int fd = ::mkstemps(path_.data(), 4);
    if (fd < 0) throw ImportError(path_, std::strerror(errno));
    ::close(fd);
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile() { ::unlink(path_.c_str()); }
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

void writeFile(const std::string& path, const std::string& bytes) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (!file) throw ImportError(path, "cannot be written", "is the disk full?");
}

/** hapticctl beside this program or on PATH. */
int runLoad(const std::vector<std::string>& words) {
  char self[PATH_MAX];
  const ssize_t size = ::readlink("/proc/self/exe", self, sizeof self);
  std::filesystem::path program =
      std::filesystem::path(std::string(self, size > 0 ? static_cast<std::size_t>(size) : 0)).parent_path() /
      "hapticctl";
  if (::access(program.c_str(), X_OK) != 0) program = "hapticctl";
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  pid_t child = 0;
  if (const int code = ::posix_spawnp(&child, program.c_str(), nullptr, nullptr, arguments.data(), environ); code != 0)
    throw ImportError("hapticctl", std::strerror(code), "install it, or write the surface with --output");
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : kRefused;
}

int run(const Options& o, bool by_label, std::vector<std::string> rest) {
  Image image = readImage(o);
  fmt::print("{}\n", describe(image));
  if (!o.crop.empty()) image = cropped(image, o.crop);
  if (by_label) chooseLabel(image, static_cast<float>(o.label));
  if (o.smooth_mm > 0) smooth(image, o.smooth_mm);
  if (o.shrink > 1) image = shrink(image, o.shrink);
  Surface surface = isosurface(image, by_label ? 0.5f : static_cast<float>(o.iso));
  if (surface.triangles.empty())
    throw ImportError(by_label ? "--label" : "--iso", "no value reaches it: there is no surface",
                      "choose one within the values above");
  const std::size_t all = surface.triangles.size();
  std::string parts;
  if (o.largest) parts = fmt::format(", the largest of {} parts", keepLargest(surface));
  fmt::print("{} triangles{} of {}, {:.4g} cm3 within\n", surface.triangles.size(), parts, all,
             volumeOf(surface) * 1e-3);
  std::fflush(stdout);
  if (!o.output.empty()) {
    writeFile(o.output, toPly(surface));
    return kDone;
  }
  const TemporaryFile ply;
  writeFile(ply.path(), toPly(surface));
  std::vector<std::string> words = {"hapticctl", "load", ply.path(), "--scale", "mm"};
  if (std::find(rest.begin(), rest.end(), "--name") == rest.end()) {
    std::string name = std::filesystem::path(o.file).stem().string().substr(0, 63);
    for (char& c : name)
      if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
    words.insert(words.end(), {"--name", name});
  }
  words.insert(words.end(), rest.begin(), rest.end());
  return runLoad(words);
}

}  // namespace
}  // namespace hapticctl_import

int main(int argc, char** argv) {
  using namespace hapticctl_import;
  Options o;
  CLI::App app{"Draw the surface of what is dense in a scan, and load it as something to touch.", "hapticctl import"};
  app.footer(
      "Reads MetaImage, NRRD, NIfTI-1, InVesalius projects and raw numbers. Further options go to hapticctl load:\n"
      "--voxel, --points, --center, --name, --at, --friction, ...");
  app.allow_extras();
  app.add_option("FILE", o.file, "The image")->required();
  auto* iso = app.add_option("--iso", o.iso, "Solid is what has at least this value (bone in CT: 226)");
  auto* label = app.add_option("--label", o.label, "Solid is what has exactly this value")->excludes(iso);
  app.add_option("--crop", o.crop, "Only this part, in values of the file")->type_name("X0:X1,Y0:Y1,Z0:Z1");
  app.add_option("--smooth", o.smooth_mm, "Smooth by a Gaussian of this deviation")
      ->type_name("MM")
      ->check(CLI::Range(0.0, 100.0));
  app.add_option("--shrink", o.shrink, "Replace each block of N x N x N values by its mean")
      ->type_name("N")
      ->check(CLI::Range(1u, 64u));
  app.add_flag("--largest", o.largest, "Only the connected part with the most triangles");
  auto* raw =
      app.add_option("--raw", o.raw, "The file is raw numbers of this kind")->type_name("int16|uint8|float|...");
  auto* raw_size = app.add_option("--raw-size", o.raw_size, "How many along each axis")->type_name("X,Y,Z")->needs(raw);
  raw->needs(raw_size);
  app.add_option("--raw-spacing", o.raw_spacing, "How far apart [mm]")->type_name("X,Y,Z")->needs(raw);
  app.add_flag("--raw-big-endian", o.big_endian, "Most significant byte first")->needs(raw);
  app.add_option("--output", o.output, "Write the surface in millimetres and load nothing")->type_name("FILE.ply");
  try {
    app.parse(argc, argv);
    if (iso->count() + label->count() == 0) throw CLI::RequiredError("--iso or --label");
  } catch (const CLI::ParseError& error) {
    return error.get_exit_code() == 0 ? app.exit(error) : (app.exit(error), kUsage);
  }
  try {
    return run(o, label->count() > 0, app.remaining());
  } catch (const ImportError& error) {
    const std::string at = error.where.empty() || error.where == o.file ? o.file : o.file + ": " + error.where;
    fmt::print(stderr, "{}: {}{}\n", at, error.what(), error.remedy.empty() ? "" : " (" + error.remedy + ")");
    return kFile;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}: {}\n", o.file, error.what());
    return kRefused;
  }
}
