/** @file
 * How a recording is framed: blocks that stand alone, each a Cap'n Proto message behind a head with its number, its
 * length and a checksum. A file cut off at any byte is whole up to its last whole block.
 */
#pragma once

#include <capnp/message.h>
#include <kj/array.h>

#include <cstddef>
#include <cstdint>
#include <istream>
#include <span>
#include <vector>

#include "rt/base/error.h"

namespace hapticd {

/** Little-endian, before each message. */
struct BlockHead {
  std::uint64_t magic;
  std::uint64_t number;    ///< From 0, without gaps.
  std::uint32_t bytes;     ///< Of the message: a multiple of 8, at most kMostBlockBytes.
  std::uint32_t check;     ///< headCheck(): a damaged length is not taken for the end of a file that was cut off.
  std::uint64_t checksum;  ///< Of the message, as proto/snapshot.h defines it.
};
inline constexpr std::uint64_t kBlockMagic = 0x314B434F4C425248;  ///< "HRBLOCK1"
inline constexpr std::uint64_t kMostBlockBytes = 64u << 20;

/** The low half of that checksum over magic, number, bytes and the message's checksum, a 64-bit word each. */
[[nodiscard]] std::uint32_t headCheck(const BlockHead& head) noexcept;

/** The message as a block. */
[[nodiscard]] std::vector<std::byte> encodeBlock(std::uint64_t number, capnp::MessageBuilder& message);

/** Reads blocks in order. Any one thread. */
class BlockReader {
 public:
  /** The stream outlives the reader. */
  explicit BlockReader(std::istream& in) noexcept : in_(in) {}

  /**
   * The next message; false at the end. A block that the end of the file cuts off, or zeros from a page on to that
   * end, is no error: cut() says so.
   * kInvalidArgument names block and byte: foreign bytes, a wrong number, length or checksum.
   */
  [[nodiscard]] Result<bool> next(kj::Array<capnp::word>& message);

  [[nodiscard]] std::uint64_t number() const noexcept { return number_; }  ///< Blocks read so far.
  [[nodiscard]] std::uint64_t offset() const noexcept { return offset_; }  ///< Byte at which the next one starts.
  [[nodiscard]] bool cut() const noexcept { return cut_; }
  /** An error about the block read last. */
  [[nodiscard]] Error errorHere(std::string what, std::string remedy = {}) const;

 private:
  [[nodiscard]] Error damaged(std::string what) const;
  bool restIsZero();
  bool restDidNotArrive(std::span<const std::byte> head, std::span<const std::byte> message);

  std::istream& in_;
  std::uint64_t number_ = 0;
  std::uint64_t offset_ = 0;
  std::uint64_t last_offset_ = 0;
  bool cut_ = false;
};

}  // namespace hapticd
