#include "drivers/hid/transport.h"

namespace hapticd {

HidResult readNewest(HidTransport& transport, std::span<std::uint8_t> buffer, std::size_t& size,
                     std::int64_t until_ns) noexcept {
  constexpr int kKernelKeeps = 64;
  HidResult result = transport.read(buffer, size, until_ns);
  for (int i = 1; i < kKernelKeeps && result == HidResult::kOk; ++i) {
    std::size_t next = size;
    const HidResult again = transport.read(buffer, next, 0);
    if (again == HidResult::kNothing) break;
    result = again;
    if (again == HidResult::kOk) size = next;
  }
  return result;
}

}  // namespace hapticd
