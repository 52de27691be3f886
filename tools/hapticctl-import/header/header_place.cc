#include "tools/hapticctl-import/header/header_place.h"

#include <utility>

#include "tools/hapticctl-import/header/header_lines.h"

namespace hapticctl_import {
namespace {

/** 0: it is no length that is known. */
double millimetresPer(std::string_view unit) {
  static constexpr std::pair<const char*, double> kUnits[] = {
      {"mm", 1},           {"millimeter", 1},   {"millimetre", 1},   {"m", 1e3},           {"meter", 1e3},
      {"metre", 1e3},      {"cm", 10},          {"centimeter", 10},  {"centimetre", 10},   {"um", 1e-3},
      {"\xc2\xb5m", 1e-3}, {"\xce\xbcm", 1e-3}, {"micron", 1e-3},    {"micrometer", 1e-3}, {"micrometre", 1e-3},
      {"nm", 1e-6},        {"nanometer", 1e-6}, {"nanometre", 1e-6}, {"inch", 25.4}};
  std::string word = lower(unit);
  if (word.size() > 2 && word.back() == 's') word.pop_back();
  for (const auto& [name, millimetres] : kUnits)
    if (word == name) return millimetres;
  return 0;
}

/** Of "um" "um" "" in quotation marks, or of one word. */
double unitIn(std::string_view words) {
  double unit = 0;
  while (!words.empty()) {
    const auto end = std::min(words.find('"'), words.size());
    const double found = millimetresPer(stripped(words.substr(0, end)));
    words.remove_prefix(std::min(end + 1, words.size()));
    if (found == 0) continue;
    if (unit != 0 && unit != found) throw ImportError("units", "differ from axis to axis", "resample it elsewhere");
    unit = found;
  }
  return unit;
}

/** Calls `take` with the key, in small letters, and the value of each field. */
template <class Take>
void forEachField(std::string_view head, bool nrrd, const Take& take) {
  Lines lines(head);
  std::string_view line;
  while (lines.next(line) && !(nrrd && stripped(line).empty())) {
    const auto sign = line.find_first_of(nrrd ? ":" : "=:");
    if (sign == std::string_view::npos || line[0] == '#' || line.substr(sign, 2) == ":=") continue;
    const std::string key = lower(stripped(line.substr(0, sign)));
    take(key, stripped(line.substr(sign + 1)));
    if (key == "elementdatafile") break;
  }
}

}  // namespace

void placeAsSaid(std::string_view head, const std::string& format, Image& image) {
  const bool nrrd = format == "NRRD";
  double unit = 0;
  bool half_about = false;
  forEachField(head, nrrd, [&](const std::string& key, std::string_view value) {
    if (nrrd ? key == "space units" || key == "units" : key == "distanceunits")
      if (const double said = unitIn(value); said != 0) unit = said;
    if (nrrd && key == "space") half_about = lower(value) == "left-anterior-superior" || lower(value) == "las";
  });
  if (unit == 0) unit = 1;
  for (std::size_t a = 0; a < 3; ++a) {
    const double by = half_about && a < 2 ? -unit : unit;
    image.origin[a] *= by;
    for (auto& step : image.step) step[a] *= by;
  }
}

std::string whatIsNotSaid(std::string_view head, const std::string& format) {
  const bool nrrd = format == "NRRD";
  bool said = false, by_ends = false;
  forEachField(head, nrrd, [&](const std::string& key, std::string_view value) {
    said = said || (nrrd ? key == "space directions" || (key == "spacings" && lower(value).find("nan") == value.npos)
                         : key == "elementspacing" || key == "elementsize");
    by_ends = by_ends || (nrrd && (key == "axis maxs" || key == "axismaxs"));
  });
  if (said) return {};
  if (by_ends)
    throw ImportError("axis maxs", "says how far apart values are, which ITK does not read", "put it into spacings");
  return ", does not say its spacing";
}

}  // namespace hapticctl_import
