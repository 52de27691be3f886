/** @file
 * The checksum of proto/snapshot.h.
 */
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "proto/snapshot.h"

namespace hapticd {

/** Over what follows the header: a multiple of 8 bytes; a shorter rest is ignored. Any thread. */
[[nodiscard]] inline std::uint64_t snapshotChecksum(std::span<const std::byte> body) noexcept {
  static_assert(std::endian::native == std::endian::little);
  const auto mix = [](std::uint64_t sum, std::uint64_t word) {
    return std::rotl((sum ^ word) * HD_CHECKSUM_PRIME, 29);
  };
  std::uint64_t lane[4];
  for (std::uint64_t i = 0; i < 4; ++i) lane[i] = HD_CHECKSUM_BASIS + i;
  const std::size_t words = body.size() / 8;
  const std::byte* p = body.data();
  std::uint64_t w[4];
  std::size_t i = 0;
  for (; i + 4 <= words; i += 4, p += 32) {
    std::memcpy(w, p, 32);
    for (int k = 0; k < 4; ++k) lane[k] = mix(lane[k], w[k]);
  }
  for (; i < words; ++i, p += 8) {
    std::memcpy(w, p, 8);
    lane[i % 4] = mix(lane[i % 4], w[0]);
  }
  std::uint64_t sum = HD_CHECKSUM_BASIS;
  for (const std::uint64_t l : lane) sum = mix(sum, l);
  return sum;
}

}  // namespace hapticd
