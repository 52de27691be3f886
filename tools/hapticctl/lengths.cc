#include "tools/hapticctl/lengths.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "tools/hapticctl/failure.h"
#include "tools/hapticctl/numbers.h"
#include "tools/hapticctl/output/output.h"

namespace hapticctl {
namespace {

constexpr double kLongest_m = 1;  // No hand reaches beyond; a longer one was perhaps meant in another unit.

}  // namespace

std::vector<double> parseLengths(std::string_view option, std::string_view text, std::size_t count) {
  std::vector<const Unit*> units;
  std::string bare;  // The numbers alone.
  for (std::string_view rest = text;;) {
    const std::size_t comma = rest.find(',');
    const std::string_view field = rest.substr(0, comma), name = hapticd_options::unitOf(field);
    units.push_back(name.empty() ? nullptr : findUnit(name));
    if (!name.empty() && units.back() == nullptr) {
      failUsage(std::string(option), fmt::format("'{}' in '{}' is no unit", name, field),
                "units are um, mm, cm, m, in and ft, without a space before: 10mm; without one it is metres");
    }
    bare += field.substr(0, field.size() - name.size());
    if (comma == std::string_view::npos) break;
    bare += ',';
    rest.remove_prefix(comma + 1);
  }
  if (count != 0 && units.size() != count) {
    failUsage(std::string(option),
              fmt::format("{} wanted, '{}' has {}", count == 1 ? "one length is" : fmt::format("{} lengths are", count),
                          text, units.size()),
              "they stand between commas, without spaces: 20mm,20mm,40mm");
  }
  std::vector<double> lengths = parseNumbers(option, bare, count);
  const bool united = std::any_of(units.begin(), units.end(), [](const Unit* unit) { return unit != nullptr; });
  bool told = false;
  for (std::size_t i = 0; i < lengths.size(); ++i) {
    double& x = lengths[i];
    if (units[i] != nullptr) {
      x = units[i]->inMetres(x);
    } else if (united && x != 0) {
      failUsage(std::string(option), fmt::format("'{}' has a unit for some of its lengths", text),
                "write it behind each: 1mm,2mm,3mm");
    } else if (std::abs(x) >= kLongest_m && !std::exchange(told, true)) {
      note(fmt::format("hapticctl: {}: {} without a unit is {}; write {}mm or {}m to say which you mean", option,
                       exact(x), length(x), exact(x), exact(x)));
    }
  }
  return lengths;
}

double parseLength(std::string_view option, std::string_view text) {
  const double metres = parseLengths(option, text, 1).front();
  if (!(metres > 0)) failUsage(std::string(option), fmt::format("{} is too small: it must be above 0", text));
  return metres;
}

}  // namespace hapticctl
