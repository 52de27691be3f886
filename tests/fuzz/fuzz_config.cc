// Any text as configuration: refused with a place, or read to what writes and reads back the same.
#include <cstdlib>

#include "daemon/config/config.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace hapticd;
  const auto config = parseConfig({reinterpret_cast<const char*>(data), size}, "fuzz");
  if (!config) {
    if (config.error().where.rfind("fuzz", 0) != 0 || config.error().what.empty()) std::abort();
    return 0;
  }
  const auto again = parseConfig(toToml(*config), "again");
  if (!again) std::abort();
  Config expected = *config;
  for (GroupConfig& group : expected.groups)
    if (group.rate_hz == 0) group.rate_hz = expected.servo.rate_hz;  // written out
  if (!(*again == expected)) std::abort();
  return 0;
}
