/** @file
 * What the checks of a snapshot and of a volume have in common: a header with a checksum, and sections behind it.
 */
#pragma once

#include <cstring>
#include <string>
#include <type_traits>

#include "rt/base/error.h"
#include "rt/scene/snapshot_checksum.h"

namespace hapticd {

/** Of blocks whose header has magic, version, total_bytes, checksum and section[]. Control thread. */
class BlockCheck {
 public:
  /** `name` of the block stands in every error. */
  explicit BlockCheck(const char* name) : name_(name) {}

  [[nodiscard]] Error bad(const std::string& where, std::string what) const {
    return {ErrorCode::kBadSnapshot, std::string(name_) + " " + where, std::move(what), "build it again"};
  }
  [[nodiscard]] Error bad(const char* kind, std::size_t index, std::string what) const {
    return bad(kind + std::string(" ") + std::to_string(index), std::move(what));
  }

  /** Takes the header out: of that magic and version, the block whole, aligned to 64 bytes and undamaged. */
  template <class Header>
  [[nodiscard]] Result<void> header(std::span<const std::byte> bytes, std::uint64_t magic, std::uint32_t version,
                                    Header& h) const {
    if (bytes.size() < sizeof h) return bad("header", std::to_string(bytes.size()) + " bytes cannot hold it");
    if (reinterpret_cast<std::uintptr_t>(bytes.data()) % 64 != 0) return bad("memory", "is not aligned to 64 bytes");
    std::memcpy(&h, bytes.data(), sizeof h);
    if (h.magic != magic) return bad("header", "the magic number is wrong");
    if (h.version != version)
      return bad("header", "version " + std::to_string(h.version) + " is not " + std::to_string(version));
    if (h.total_bytes != bytes.size() || h.total_bytes % 64 != 0) {
      return bad("header",
                 "it tells of " + std::to_string(h.total_bytes) + " bytes, there are " + std::to_string(bytes.size()));
    }
    if (snapshotChecksum(bytes.subspan(sizeof h)) != h.checksum) return bad("checksum", "does not match: damaged");
    return {};
  }

  /** Each section has that size and lies behind the one before it, aligned, within the block. */
  template <class Header, std::size_t kCount>
  [[nodiscard]] Result<void> sections(const Header& h, const std::uint64_t (&expected)[kCount]) const {
    static_assert(std::extent_v<decltype(h.section)> == kCount);
    std::uint64_t end = sizeof h;
    for (std::size_t i = 0; i < kCount; ++i) {
      const hd_section& s = h.section[i];
      if (s.bytes != expected[i]) return bad("section", i, "has the wrong size");
      if (s.offset % 64 != 0 || s.offset < end || s.offset > h.total_bytes || s.bytes > h.total_bytes - s.offset)
        return bad("section", i, "lies outside its place");
      end = s.offset + s.bytes;
    }
    return {};
  }

 private:
  const char* name_;
};

}  // namespace hapticd
