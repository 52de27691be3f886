#include "tools/hapticctl-import/input.h"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <iostream>

#include "tools/hapticctl-import/image_file.h"
#include "tools/hapticctl-import/scan_file.h"

namespace hapticctl_import {
namespace {

Image readRaw(const InputOptions& o) {
  RawLayout layout;
  const auto sample = sampleOf(o.raw);
  if (!sample) throw ImportError("--raw", fmt::format("'{}' is no kind of number", o.raw), "int16, uint8, float, ...");
  layout.sample = *sample;
  layout.size = sizesIn(o.raw_size, "--raw-size");
  const auto steps = numbersIn(o.raw_spacing, "--raw-spacing", 3);
  std::copy(steps.begin(), steps.end(), layout.spacing.begin());
  layout.big_endian = o.big_endian;
  return parseRaw(readFile(o.file), layout);
}

/** One of several, by its number in the list or by the beginning of its identifier; null if that names none. */
const DicomSeries* named(const std::vector<DicomSeries>& all, const std::string& choice) {
  std::size_t number = 0;
  const char* const end = choice.data() + choice.size();
  if (const auto parsed = std::from_chars(choice.data(), end, number);
      parsed.ec == std::errc() && parsed.ptr == end && number >= 1 && number <= all.size())
    return &all[number - 1];
  const auto begins = [&](const DicomSeries& s) { return !choice.empty() && s.uid.rfind(choice, 0) == 0; };
  const auto found = std::find_if(all.begin(), all.end(), begins);
  return found == all.end() ? nullptr : &*found;
}

const DicomSeries& choose(const std::vector<DicomSeries>& all, std::string choice) {
  if (all.size() == 1 && choice.empty()) return all[0];
  std::string list;
  for (std::size_t i = 0; i < all.size(); ++i) list += fmt::format("\n  {}  {}", i + 1, all[i].text);
  if (choice.empty() && ::isatty(STDIN_FILENO) != 0 && ::isatty(STDOUT_FILENO) != 0) {
    fmt::print("{} series:{}\nWhich one: ", all.size(), list);
    std::fflush(stdout);
    std::getline(std::cin, choice);
  }
  const DicomSeries* const chosen = named(all, choice);
  if (chosen == nullptr)
    throw ImportError(choice.empty() ? "" : "--series", fmt::format("there are {} series:{}\n", all.size(), list),
                      "choose one with --series NUMBER");
  return *chosen;
}

bool namesInvesalius(const std::string& path) {
  std::string head(1024, '\0');
  std::ifstream(path, std::ios::binary).read(head.data(), static_cast<std::streamsize>(head.size()));
  return isInvesalius(head) || std::filesystem::path(path).extension() == ".inv3";
}

}  // namespace

Image readInput(const InputOptions& o) {
  if (!o.raw.empty()) return readRaw(o);
  if (!std::filesystem::exists(o.file)) throw ImportError({}, "cannot be read", "does it exist?");
  if (std::filesystem::is_directory(o.file) || isDicom(o.file))
    return readSeries(choose(dicomSeriesIn(o.file), o.series));
  if (namesInvesalius(o.file)) return parseInvesalius(readFile(o.file));
  return readScan(o.file);
}

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

}  // namespace hapticctl_import
