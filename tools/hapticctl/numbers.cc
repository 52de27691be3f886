#include "tools/hapticctl/numbers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/hapticctl/failure.h"
#include "tools/options/parse_number.h"

namespace hapticctl {

void failUsage(std::string where, std::string what, std::string remedy) {
  throw Failure{kExitUsage, std::move(where), std::move(what), std::move(remedy)};
}

std::optional<double> parseNumber(std::string_view text) {
  double value = 0;
  return hapticd_options::parseNumber(text, value) ? std::optional(value) : std::nullopt;
}

std::vector<double> parseNumbers(std::string_view option, std::string_view text, std::size_t count) {
  std::vector<double> values;
  for (std::string_view rest = text;;) {
    const std::size_t comma = rest.find(',');
    std::string_view field = rest.substr(0, comma);
    field.remove_prefix(std::min(field.size(), field.find_first_not_of(' ')));  // As people write behind a comma.
    const auto value = parseNumber(field);
    if (!value) {
      failUsage(std::string(option), fmt::format("'{}' is not a finite number (field {})", field, values.size() + 1),
                "numbers stand between commas, with a point: 0,0,0.02");
    }
    values.push_back(*value);
    if (comma == std::string_view::npos) break;
    rest.remove_prefix(comma + 1);
  }
  if (count != 0 && values.size() != count) {
    failUsage(std::string(option),
              fmt::format("{} wanted, '{}' has {}", count == 1 ? "one number is" : fmt::format("{} numbers are", count),
                          text, values.size()),
              "numbers stand between commas, without spaces");
  }
  return values;
}

std::array<double, 3> parseVec3(std::string_view option, std::string_view text) {
  const auto v = parseNumbers(option, text, 3);
  return {v[0], v[1], v[2]};
}

std::array<double, 4> parseRotation(std::string_view option, std::string_view text) {
  if (text.size() > 2 && text[1] == ',' && text[0] >= 'x' && text[0] <= 'z') {
    // Whole turns go before anything is rounded.
    const double half = std::remainder(parseNumbers(option, text.substr(2), 1)[0], 720) * (M_PI / 360);
    std::array<double, 4> q{std::cos(half), 0, 0, 0};
    q[static_cast<std::size_t>(text[0] - 'x') + 1] = std::sin(half);
    return q;
  }
  if (text.find(',') == std::string_view::npos || !parseNumber(text.substr(0, text.find(',')))) {
    failUsage(std::string(option), fmt::format("'{}' is no rotation", text),
              "write an axis and degrees (x,90) or a quaternion w,x,y,z");
  }
  const auto v = parseNumbers(option, text, 4);
  const double norm = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2] + v[3] * v[3]);
  if (!(norm > 1e-6) || !std::isfinite(norm))
    failUsage(std::string(option), "a quaternion of no length turns nothing", "no rotation is 1,0,0,0");
  return {v[0] / norm, v[1] / norm, v[2] / norm, v[3] / norm};
}

std::array<double, 4> multiply(const std::array<double, 4>& a, const std::array<double, 4>& b) {
  return {a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3], a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
          a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1], a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]};
}

std::string exact(double value) { return fmt::format("{}", value); }

std::string fixed(double value, int digits) {
  if (!std::isfinite(value)) return "-";
  std::string text = fmt::format("{:.{}f}", value, digits);
  if (text.front() == '-' && text.find_first_not_of("-0.") == std::string::npos) text.erase(0, 1);
  return text;
}

std::string grouped(std::uint64_t value) {
  std::string text = std::to_string(value);
  for (std::size_t i = text.size(); i > 3; i -= 3) text.insert(i - 3, 1, ' ');
  return text;
}

namespace {
/** Three significant digits. */
std::string significant(double value) {
  const double size = std::fabs(value);
  return fixed(value, size < 9.995 ? 2 : size < 99.95 ? 1 : 0);
}
}  // namespace

std::string duration(double ns) {
  if (!std::isfinite(ns)) return "-";
  if (ns < 999.5) return fmt::format("{:.0f} ns", ns);
  if (ns < 999.5e3) return significant(ns * 1e-3) + " us";
  if (ns < 999.5e6) return significant(ns * 1e-6) + " ms";
  return significant(ns * 1e-9) + " s";
}

std::string length(double metres) {
  if (!std::isfinite(metres)) return "-";
  const double size = std::fabs(metres);
  if (size == 0) return "0 m";
  if (size < 0.9995e-3) return significant(metres * 1e6) + " um";
  if (size < 0.9995) return significant(metres * 1e3) + " mm";
  if (size < 999.5) return significant(metres) + " m";
  return significant(metres * 1e-3) + " km";
}

std::string bytes(std::uint64_t count) {
  if (count < 1024) return fmt::format("{} B", count);
  double value = static_cast<double>(count);
  const char* unit = "";
  for (const char* next : {"KiB", "MiB", "GiB", "TiB"}) {
    if (value < 1023.5) break;
    value /= 1024;
    unit = next;
  }
  return fmt::format("{} {}", significant(value), unit);
}

}  // namespace hapticctl
