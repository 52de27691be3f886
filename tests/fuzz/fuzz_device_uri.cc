// Device URIs as clients send them: parsed, formatted, parsed again; and the query against the table of the simulator.
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "drivers/sim/sim_parameters.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace hapticd;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const Result<DeviceUri> uri = parseDeviceUri(text);
  if (!uri.ok()) {
    if (uri.error().what.empty() || uri.error().remedy.empty()) std::abort();
    return 0;
  }
  const std::string formatted = formatDeviceUri(*uri);
  // Encoding makes a URI up to three times as long.
  if (formatted.size() <= kMaxUriBytes) {
    const Result<DeviceUri> again = parseDeviceUri(formatted);
    if (!again.ok() || again->scheme != uri->scheme || again->authority != uri->authority ||
        again->query != uri->query) {
      std::abort();
    }
  }
  for (const auto& [key, value] : uri->query) {
    if (key == "file") return 0;  // No files here.
  }
  const Result<SimSetup> setup = resolveSim(*uri);
  if (!setup.ok()) return 0;
  // What was accepted has one canonical name.
  const Result<DeviceUri> canonical = parseDeviceUri(setup->uri);
  if (!canonical.ok()) return 0;  // Only a serial full of reserved characters makes it too long.
  const Result<SimSetup> same = resolveSim(*canonical);
  if (!same.ok() || same->uri != setup->uri) std::abort();
  return 0;
}
