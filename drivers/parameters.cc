#include "drivers/parameters.h"

#include <fmt/format.h>

#include <algorithm>

#include "drivers/did_you_mean.h"
#include "drivers/number.h"

namespace hapticd {
namespace {

constexpr std::size_t kMaxTextBytes = 1024;

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(separator, begin), text.size());
    parts.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return parts;
}

/** One setter per type; each leaves the value alone when the text does not fit. */
struct Setter {
  const ParameterSpec& spec;
  std::string_view text;

  [[nodiscard]] bool inRange(double value) const { return value >= spec.lowest && value <= spec.highest; }

  bool operator()(double* value) const {
    const std::optional<double> number = parseNumber(text);
    if (!number || !inRange(*number)) return false;
    *value = *number;
    return true;
  }
  bool operator()(std::uint64_t* value) const {
    const std::optional<std::uint64_t> number = parseInteger(text);
    if (!number || !inRange(static_cast<double>(*number))) return false;
    *value = *number;
    return true;
  }
  bool operator()(bool* value) const {
    const bool yes = text == "1" || text == "yes" || text == "true" || text == "on";
    const bool no = text == "0" || text == "no" || text == "false" || text == "off";
    if (yes || no) *value = yes;
    return yes || no;
  }
  bool operator()(Vec3* value) const {
    const std::optional<Vec3> vector = parseVector(text);
    if (!vector || !inRange(vector->minCoeff()) || !inRange(vector->maxCoeff())) return false;
    *value = *vector;
    return true;
  }
  bool operator()(std::string* value) const {
    if (text.size() > kMaxTextBytes) return false;
    if (!spec.choices.empty()) {
      const std::vector<std::string_view> choices = split(spec.choices, '|');
      if (std::find(choices.begin(), choices.end(), text) == choices.end()) return false;
    }
    *value = text;
    return true;
  }
};

struct Formatter {
  std::string operator()(const double* value) const { return formatNumber(*value); }
  std::string operator()(const std::uint64_t* value) const { return fmt::format("{}", *value); }
  std::string operator()(const bool* value) const { return *value ? "1" : "0"; }
  std::string operator()(const Vec3* value) const { return formatVector(*value); }
  std::string operator()(const std::string* value) const { return *value; }
};

}  // namespace

std::string describeRange(const ParameterSpec& spec, ParameterSlot slot) {
  if (std::holds_alternative<bool*>(slot)) return "0 or 1";
  if (std::holds_alternative<std::string*>(slot)) {
    return spec.choices.empty() ? fmt::format("text of at most {} bytes", kMaxTextBytes)
                                : fmt::format("one of {}", fmt::join(split(spec.choices, '|'), ", "));
  }
  std::string_view kind = "a number";
  if (std::holds_alternative<std::uint64_t*>(slot)) kind = "an integer";
  if (std::holds_alternative<Vec3*>(slot)) kind = "three numbers x,y,z";
  return fmt::format("{} from {} to {}{}{}", kind, formatNumber(spec.lowest), formatNumber(spec.highest),
                     spec.unit.empty() ? "" : " ", spec.unit);
}

Result<void> setParameter(const ParameterSpec& spec, ParameterSlot slot, std::string_view text) {
  if (std::visit(Setter{spec, text}, slot)) return {};
  std::string remedy = fmt::format("{} takes {}", spec.key, describeRange(spec, slot));
  if (!spec.choices.empty()) {
    const std::string_view near = nearest(text, split(spec.choices, '|'));
    if (!near.empty()) remedy += fmt::format("; did you mean {}?", near);
  }
  return Error{ErrorCode::kInvalidArgument, fmt::format("device URI, key {}", spec.key),
               fmt::format("\"{}\" does not fit", text.substr(0, 80)), std::move(remedy)};
}

std::string formatParameter(ParameterSlot slot) { return std::visit(Formatter{}, slot); }

Error unknownKey(std::string_view key, const std::vector<std::string_view>& keys) {
  const std::string_view near = nearest(key, keys);
  std::string remedy =
      near.empty() ? fmt::format("known keys: {}", fmt::join(keys, ", ")) : fmt::format("did you mean \"{}\"?", near);
  return {ErrorCode::kInvalidArgument, fmt::format("device URI, key {}", key.substr(0, 80)), "there is no such key",
          std::move(remedy)};
}

}  // namespace hapticd
