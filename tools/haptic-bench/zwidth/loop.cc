#include "tools/haptic-bench/zwidth/loop.h"

#include <fmt/format.h>

#include "drivers/registry.h"
#include "tools/haptic-bench/failure.h"

namespace haptic_bench::zwidth {
namespace {

void drop(hapticd::DeviceUri& uri, const std::string& key) {
  std::erase_if(uri.query, [&](const auto& entry) { return entry.first == key; });
}
void set(hapticd::DeviceUri& uri, const std::string& key, double value) {
  drop(uri, key);
  uri.query.emplace_back(key, fmt::format("{}", value));
}

}  // namespace

Loop makeLoop(const std::string& text, const Change& change) {
  hapticd::DeviceUri uri = orFail(hapticd::parseDeviceUri(text));
  if (uri.scheme != "sim") {
    throw Failure("device URI", text + " is no simulated device", "the loop is closed on sim:// alone: sim://default");
  }
  for (const char* key : {"motion", "file", "tremor"}) drop(uri, key);  // The hand does as it is told.
  set(uri, "rate", change.rate_hz);
  set(uri, "delay", change.delay);
  set(uri, "position_delay", 0);
  if (change.step >= 0) set(uri, "resolution", change.step);
  if (change.friction >= 0) set(uri, "coulomb", change.friction);
  Loop loop;
  loop.device = orFail(hapticd::resolveSim(uri));
  if (!(loop.device.parameters.hand_stiffness > 0)) {
    throw Failure("device URI, key hand_stiffness", "a hand without stiffness does not press", "let it be positive");
  }
  const double lower = loop.device.parameters.lower.z(), upper = loop.device.parameters.upper.z();
  if (!(lower < 0 && upper > kGap)) {
    throw Failure(
        "device URI, keys lower and upper",
        fmt::format("the wall at z = 0 does not lie between {} and {} m, the hand {} m above it", lower, upper, kGap),
        "a workspace about the origin");
  }
  loop.rate_hz = change.rate_hz;
  loop.delay = change.delay;
  return loop;
}

}  // namespace haptic_bench::zwidth
