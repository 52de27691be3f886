/** @file
 * A short name for a long text.
 */
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace hapticd {

/** 64-bit FNV-1a in 16 hexadecimal digits. Tells URIs apart; no defence against anybody. */
[[nodiscard]] inline std::string hashText(std::string_view text) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
  std::string digits(16, '0');
  for (std::size_t i = 16; i-- > 0; hash >>= 4) digits[i] = "0123456789abcdef"[hash & 15];
  return digits;
}

}  // namespace hapticd
