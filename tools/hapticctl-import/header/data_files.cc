#include "tools/hapticctl-import/header/data_files.h"

#include <fmt/core.h>

#include <limits>
#include <optional>

#include "tools/hapticctl-import/header/header_lines.h"
#include "tools/hapticctl-import/image.h"

namespace hapticctl_import {
namespace {

constexpr std::size_t kMostFiles = 65536;  ///< As an image may have values along an axis.
constexpr std::size_t kMostAxes = 10;      ///< MetaIO's.

[[noreturn]] void refuse(const char* what) {
  throw ImportError("ElementDataFile", what, "is the header whole? Write the values into one file");
}

std::optional<int> integerIn(std::string_view word) {
  int n = 0;
  const auto [end, problem] = std::from_chars(word.data(), word.data() + word.size(), n);
  return problem == std::errc() && end == word.data() + word.size() ? std::optional(n) : std::nullopt;
}

/** Product of the sizes from `axis` on; above kMostFiles whatever is more. */
std::size_t productFrom(const std::vector<std::uint64_t>& sizes, std::size_t axis) {
  std::size_t n = 1;
  for (; axis < sizes.size(); ++axis)
    n = std::min<std::size_t>(kMostFiles + 1, n * std::min(sizes[axis], kMostFiles + 1));
  return n;
}

/** One %d or %03d in it: as printf would write `n` there. Nothing if it is no such name. */
std::optional<std::string> numbered(std::string_view pattern, int n) {
  const auto at = pattern.find('%');
  if (at == std::string_view::npos) return {};
  auto end = at + 1;
  while (end < pattern.size() && pattern[end] >= '0' && pattern[end] <= '9') ++end;
  if (end >= pattern.size() || pattern[end] != 'd' || pattern.find('%', end) != std::string_view::npos || end - at > 3)
    return {};
  const std::string_view width = pattern.substr(at + 1, end - at - 1);
  const int wide = integerIn(width).value_or(0);
  const std::string number =
      width.substr(0, 1) == "0" ? fmt::format("{:0{}}", n, wide) : fmt::format("{:>{}}", n, wide);
  return std::string(pattern.substr(0, at)) + number + std::string(pattern.substr(end + 1));
}

std::vector<std::string> listed(Lines& lines, std::size_t needed) {
  std::vector<std::string> names;
  std::string_view line;
  while (names.size() <= needed && lines.next(line) && !stripped(line).empty()) names.emplace_back(stripped(line));
  return names;
}

std::vector<std::string> counted(std::string_view words, std::size_t needed) {
  const std::string_view pattern = takeWord(words), first_word = takeWord(words), last_word = takeWord(words),
                         step_word = takeWord(words);
  const std::int64_t first = integerIn(first_word).value_or(1);
  std::int64_t last = first + static_cast<std::int64_t>(needed) - 1, step = 1;
  if (!last_word.empty()) {
    last = integerIn(last_word).value_or(first - 1);
    step = (last - first) / static_cast<std::int64_t>(needed);  // MetaIO's own, wrong for 1 to 9.
  }
  if (!step_word.empty()) step = integerIn(step_word).value_or(0);
  if (step < 1 || first < 0 || last > std::numeric_limits<int>::max())
    refuse("needs FIRST LAST STEP behind the name, with a step of at least 1");
  std::vector<std::string> names;
  for (std::int64_t n = first; n <= last && names.size() <= needed; n += step) {
    auto name = numbered(pattern, static_cast<int>(n));
    if (!name) refuse("is no name with one number such as %03d in it");
    names.push_back(std::move(*name));
  }
  return names;
}

}  // namespace

std::vector<std::string> metaImageFiles(std::string_view head) {
  std::vector<std::uint64_t> sizes;
  std::uint64_t axes_said = 0;
  std::string_view line, value;
  Lines lines(head);
  while (lines.next(line)) {
    const auto sign = line.find_first_of("=:");
    if (sign == std::string_view::npos) continue;
    const std::string_view key = stripped(line.substr(0, sign));
    value = stripped(line.substr(sign + 1));
    if (key == "NDims") axes_said = countIn(value);
    if (key == "DimSize") {
      sizes.clear();
      for (auto words = value; sizes.size() <= kMostAxes;) {
        const std::string_view word = takeWord(words);
        if (word.empty()) break;
        sizes.push_back(countIn(word));
      }
    }
    if (key == "ElementDataFile") break;
    value = {};
  }
  if (value.empty() || sizes.empty() || sizes.size() > kMostAxes || sizes.size() != axes_said ||
      productFrom(sizes, 0) == 0)
    refuse("stands behind no DimSize of NDims sizes");
  const bool list = value.substr(0, 4) == "LIST";
  std::size_t axes = sizes.size() - 1;  // Of one file.
  if (list) {
    takeWord(value);
    const auto said = integerIn(takeWord(value)).value_or(0);
    if (said == static_cast<int>(sizes.size())) refuse("is a list of one file, of which MetaIO reads nothing");
    if (said > 0 && static_cast<std::size_t>(said) < sizes.size()) axes = static_cast<std::size_t>(said);
  }
  const std::size_t needed = productFrom(sizes, axes);
  if (needed > kMostFiles) refuse("names too many files");
  std::vector<std::string> names = list ? listed(lines, needed) : counted(value, needed);
  if (names.size() == needed) return names;
  throw ImportError("ElementDataFile",
                    fmt::format("names {} files, {} are needed",
                                names.size() > needed ? "more" : std::to_string(names.size()), needed),
                    "is the header whole?");
}

std::vector<std::string> nrrdFiles(std::string_view value, std::string_view below) {
  Lines lines(below);
  if (value.substr(0, 4) == "LIST") return listed(lines, kMostFiles);
  const std::string_view pattern = takeWord(value);
  const auto first = integerIn(takeWord(value)), last = integerIn(takeWord(value)), step = integerIn(takeWord(value));
  std::vector<std::string> names;
  if (!first || !last || step.value_or(0) == 0) return names;
  const auto within = [&](std::int64_t n) { return *step > 0 ? n <= *last : n >= *last; };
  for (std::int64_t n = *first; within(n) && names.size() <= kMostFiles; n += *step) {
    auto name = numbered(pattern, static_cast<int>(n));
    if (!name) return {};
    names.push_back(std::move(*name));
  }
  return names;
}

}  // namespace hapticctl_import
