// The kernel's side of USB/IP as bytes: whatever comes, every reply is whole and nothing grows without bound.
#include <cstdint>
#include <cstdlib>

#include "tools/haptic-emu/falcon/falcon_model.h"
#include "tools/haptic-emu/usbip.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  haptic_emu::FalconModel model;
  haptic_emu::UsbIp usbip(model);
  std::int64_t now_ns = 0;
  for (std::size_t at = 0; at < size;) {
    const std::size_t piece = std::min<std::size_t>(size - at, 1 + data[at] % 100);
    if (!usbip.feed({data + at, piece})) return 0;
    at += piece;
    usbip.advance(now_ns += 125'000);
    const auto bytes = usbip.take();
    if (!bytes.empty() && bytes.size() < 48) std::abort();
    if (usbip.waiting() > 256) std::abort();
  }
  return 0;
}
