/** @file
 * A good block of memory, spoilt as a fuzzer's input says.
 */
#pragma once

#include <fuzzer/FuzzedDataProvider.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <span>
#include <vector>

#include "rt/scene/snapshot_checksum.h"

namespace hapticd {

/** Up to eight words are others, half of these in the header; the end may be cut off; the checksum is right now and
 * then. */
template <class Header>
class Spoilt {
 public:
  Spoilt(const std::vector<std::byte>& good, FuzzedDataProvider& data)
      : memory_(static_cast<std::byte*>(std::aligned_alloc(64, good.size())), &std::free) {
    std::memcpy(memory_.get(), good.data(), good.size());
    for (auto n = data.ConsumeIntegralInRange<int>(0, 8); n > 0; --n) {
      // Half of the patches go to the header, where a word decides most.
      const std::size_t end = data.ConsumeBool() ? sizeof(Header) : good.size();
      const auto at = data.ConsumeIntegralInRange<std::size_t>(0, end / 4 - 1) * 4;
      const auto word = data.ConsumeBool() ? data.ConsumeIntegralInRange<std::uint32_t>(0, 300)
                                           : data.ConsumeIntegral<std::uint32_t>();
      std::memcpy(memory_.get() + at, &word, sizeof word);
    }
    const std::size_t kept =
        data.ConsumeBool() ? good.size() : data.ConsumeIntegralInRange<std::size_t>(0, good.size());
    bytes_ = std::span<const std::byte>(memory_.get(), kept);
    if (kept >= sizeof(Header) && kept % 8 == 0 && data.ConsumeBool()) {
      reinterpret_cast<Header*>(memory_.get())->checksum = snapshotChecksum(bytes_.subspan(sizeof(Header)));
    }
  }
  [[nodiscard]] std::span<const std::byte> bytes() const { return bytes_; }

 private:
  // Its own allocation, so that the address sanitizer stands right behind the last byte; blocks are page aligned.
  std::unique_ptr<std::byte, decltype(&std::free)> memory_;
  std::span<const std::byte> bytes_;
};

}  // namespace hapticd
