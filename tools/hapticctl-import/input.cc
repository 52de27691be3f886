#include "tools/hapticctl-import/input.h"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <optional>

#include "tools/hapticctl-import/format/image_file.h"
#include "tools/hapticctl-import/format/vdb_file.h"
#include "tools/hapticctl-import/itk/scan_file.h"

namespace hapticctl_import {
namespace {

Image readRaw(const InputOptions& o) {
  RawLayout layout;
  const auto sample = sampleOf(o.raw);
  if (!sample) {
    throw ImportError("--raw", fmt::format("'{}' is no kind of number", o.raw),
                      "int8, uint8, int16, uint16, int32, uint32, float or double");
  }
  layout.sample = *sample;
  layout.size = sizesIn(o.raw_size, "--raw-size", "for example 512,512,100");
  if (!o.raw_spacing.empty()) {
    const auto steps = numbersIn(o.raw_spacing, "--raw-spacing", 3, "for example 0.5,0.5,1");
    std::copy(steps.begin(), steps.end(), layout.spacing.begin());
  }
  layout.big_endian = o.big_endian;
  try {
    Image image = parseRaw(readFile(o.file, bytesOf(layout.size, layout.sample)), layout);
    if (o.raw_spacing.empty()) image.format += ", does not say its spacing";  // As of other formats.
    return image;
  } catch (ImportError& error) {
    if (error.where == "data")
      error.remedy = "is it whole and without a header, and are --raw and --raw-size as it was written?";
    throw;
  }
}

/** What a file or folder holds several of. */
struct Choice {
  std::string name, text;
};

/**
 * The only one whose name begins so; of those where a point follows the only one: behind an identifier ITK puts what
 * tells its series apart, and 2.5 is not the beginning of 2.50.
 */
std::optional<std::size_t> beginning(const std::vector<Choice>& all, const std::string& wanted) {
  std::vector<std::size_t> whole, part;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (wanted.empty() || all[i].name.rfind(wanted, 0) != 0) continue;
    (all[i].name[wanted.size()] == '.' ? whole : part).push_back(i);
  }
  const std::vector<std::size_t>& begin = whole.empty() ? part : whole;
  return begin.size() == 1 ? std::optional(begin[0]) : std::nullopt;
}

/** Which one is meant: by its number in the list, or by the beginning of its name. Asks on a terminal. */
std::size_t choose(const std::vector<Choice>& all, std::string wanted, const char* what, const char* option) {
  if (all.size() == 1 && wanted.empty()) return 0;
  std::string list;
  for (std::size_t i = 0; i < all.size(); ++i) list += fmt::format("\n  {}  {}", i + 1, all[i].text);
  if (wanted.empty() && ::isatty(STDIN_FILENO) != 0 && ::isatty(STDOUT_FILENO) != 0) {
    fmt::print("{} {}:{}\nWhich one: ", all.size(), what, list);
    std::fflush(stdout);
    std::getline(std::cin, wanted);
  }
  for (std::size_t i = 0; i < all.size(); ++i)
    if (all[i].name == wanted) return i;
  std::size_t number = 0;
  const char* const end = wanted.data() + wanted.size();
  if (const auto parsed = std::from_chars(wanted.data(), end, number);
      parsed.ec == std::errc() && parsed.ptr == end && number >= 1 && number <= all.size())
    return number - 1;
  if (const auto only = beginning(all, wanted)) return *only;
  throw ImportError(wanted.empty() ? "" : option,
                    wanted.empty() ? fmt::format("there are {} {}:{}\n", all.size(), what, list)
                                   : fmt::format("'{}' names none of the {} {}:{}\n", wanted, all.size(), what, list),
                    fmt::format("choose one with {} NUMBER", option));
}

Image readDicom(const InputOptions& o) {
  const auto all = dicomSeriesIn(o.file);
  std::vector<Choice> choices;
  choices.reserve(all.size());
  for (const DicomSeries& series : all) choices.push_back({series.uid, series.text});
  return readSeries(all[choose(choices, o.series, "series", "--series")]);
}

double metresPerUnit(const std::string& scale) {
  constexpr std::pair<const char*, double> kUnits[] = {{"mm", 1e-3}, {"cm", 1e-2},     {"m", 1},
                                                       {"um", 1e-6}, {"inch", 0.0254}, {"ft", 0.3048}};
  for (const auto& [name, metres] : kUnits)
    if (scale == name) return metres;
  constexpr const char* kRemedy = "mm, cm, m, inch, um, ft or metres per unit, from 1e-9 to 1000";
  const double metres = numbersIn(scale, "--scale", 1, kRemedy).front();
  if (!(metres >= 1e-9 && metres <= 1e3)) throw ImportError("--scale", "is not a length of a unit", kRemedy);
  return metres;
}

Image readGrid(const InputOptions& o) {
  const auto all = gridsOf(o.file);
  std::vector<Choice> choices;
  choices.reserve(all.size());
  for (const VdbGrid& grid : all) choices.push_back({grid.name, grid.text});
  const VdbGrid& grid = all[choose(choices, o.grid, "grids", "--grid")];
  if (o.scale.empty() && grid.metres_per_unit == 0) {
    throw ImportError("--scale", "is needed: a .vdb does not say its unit",
                      "mm, cm, m, inch, um, ft or metres per unit");
  }
  return readVdb(o.file, grid, o.scale.empty() ? grid.metres_per_unit : metresPerUnit(o.scale));
}

bool namesInvesalius(const std::string& path) {
  std::string head(1024, '\0');
  std::ifstream(path, std::ios::binary).read(head.data(), static_cast<std::streamsize>(head.size()));
  return isInvesalius(head) || std::filesystem::path(path).extension() == ".inv3";
}

}  // namespace

Image readInput(const InputOptions& o) {
  // An option that is passed over would be taken for one that has worked.
  const auto only = [&o](bool dicom, bool vdb) {
    if (!dicom && !o.series.empty()) throw ImportError("--series", "is for DICOM, which this is not", "leave it out");
    if (!vdb && !o.grid.empty()) throw ImportError("--grid", "is for OpenVDB, which this is not", "leave it out");
    if (!vdb && !o.scale.empty())
      throw ImportError("--scale", "is for OpenVDB: this file says its lengths, in millimetres", "leave it out");
  };
  if (!o.raw.empty()) {
    only(false, false);
    return readRaw(o);
  }
  if (::access(o.file.c_str(), R_OK) != 0) throw notRead({}, errno);
  const bool dicom = std::filesystem::is_directory(o.file) || isDicom(o.file);
  const bool vdb = !dicom && isVdb(o.file);
  only(dicom, vdb);
  if (dicom) return readDicom(o);
  if (vdb) return readGrid(o);
  if (namesInvesalius(o.file)) return parseInvesalius(readFile(o.file));
  return readScan(o.file);
}

Image cropped(const Image& image, const std::string& text) {
  std::string plain = text;
  std::replace(plain.begin(), plain.end(), ':', ' ');
  constexpr const char* kRemedy = "for example 0:100,20:80,0:50";
  const auto n = numbersIn(plain, "--crop", 6, kRemedy);
  std::array<std::uint32_t, 3> first{}, end{};
  for (std::size_t k = 0; k < 3; ++k) {
    const bool whole = n[2 * k] == std::floor(n[2 * k]) && n[2 * k + 1] == std::floor(n[2 * k + 1]);
    if (!(whole && n[2 * k] >= 0 && n[2 * k + 1] > n[2 * k] && n[2 * k + 1] < 1e6))
      throw ImportError("--crop", "is not FIRST:END for each axis", kRemedy);
    first[k] = static_cast<std::uint32_t>(n[2 * k]);
    end[k] = static_cast<std::uint32_t>(n[2 * k + 1]);
  }
  return crop(image, first, end);
}

std::string describe(const Image& image) {
  const auto [low, high] = std::minmax_element(image.values.begin(), image.values.end());
  return fmt::format("{}: {} x {} x {} values, {:.4g} x {:.4g} x {:.4g} mm apart, from {:g} to {:g}{}", image.format,
                     image.size[0], image.size[1], image.size[2], spacing(image, 0), spacing(image, 1),
                     spacing(image, 2), *low, *high,
                     image.no_numbers > 0 ? fmt::format(", {} of them no numbers", image.no_numbers) : "");
}

}  // namespace hapticctl_import
