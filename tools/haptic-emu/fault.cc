#include "tools/haptic-emu/fault.h"

#include <charconv>
#include <iterator>
#include <limits>

namespace haptic_emu {

hapticd::Result<Fault> parseFault(std::string_view text) {
  const auto wrong = [&](std::string what) {
    return hapticd::Error{hapticd::ErrorCode::kInvalidArgument, "fault \"" + std::string(text.substr(0, 60)) + "\"",
                          std::move(what), "write for instance silence@0.5+0.1"};
  };
  const std::size_t at = text.find('@');
  Fault fault;
  std::size_t kind = 0;
  while (kind < std::size(kFaultNames) && kFaultNames[kind] != text.substr(0, at)) ++kind;
  if (kind == std::size(kFaultNames)) {
    std::string names;
    for (const std::string_view name : kFaultNames) names += " " + std::string(name);
    return wrong("there are" + names);
  }
  fault.kind = static_cast<FaultKind>(kind);
  fault.to_ns = std::numeric_limits<std::int64_t>::max();
  if (at == std::string_view::npos) return fault;
  const auto seconds = [](std::string_view number, std::int64_t& ns) {
    double s = 0;
    const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), s);
    if (error != std::errc() || end != number.data() + number.size() || !(s >= 0 && s < 1e6)) return false;
    ns = static_cast<std::int64_t>(s * 1e9);
    return true;
  };
  const std::string_view times = text.substr(at + 1);
  const std::size_t plus = times.find('+');
  if (!seconds(times.substr(0, plus), fault.from_ns)) return wrong("no time in seconds after '@'");
  if (plus == std::string_view::npos) return fault;
  std::int64_t length_ns = 0;
  if (!seconds(times.substr(plus + 1), length_ns)) return wrong("no length in seconds after '+'");
  fault.to_ns = fault.from_ns + length_ns;
  return fault;
}

}  // namespace haptic_emu
