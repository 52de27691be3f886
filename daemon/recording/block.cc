#include "daemon/recording/block.h"

#include <capnp/serialize.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>

#include "rt/scene/snapshot_checksum.h"

namespace hapticd {
namespace {

constexpr std::size_t kPiece = 1u << 20;
constexpr std::uint64_t kPage = 4096;  // What is written to a file arrives in pages.

std::string place(std::uint64_t number, std::uint64_t offset) {
  return fmt::format("block {} at byte {}", number, offset);
}

}  // namespace

std::uint32_t headCheck(const BlockHead& head) noexcept {
  const std::uint64_t words[] = {head.magic, head.number, head.bytes, head.checksum};
  return static_cast<std::uint32_t>(snapshotChecksum(std::as_bytes(std::span(words))));
}

std::vector<std::byte> encodeBlock(std::uint64_t number, capnp::MessageBuilder& message) {
  const kj::Array<capnp::word> flat = capnp::messageToFlatArray(message);
  const auto bytes = flat.asBytes();
  std::vector<std::byte> block(sizeof(BlockHead) + bytes.size());
  std::memcpy(block.data() + sizeof(BlockHead), bytes.begin(), bytes.size());
  BlockHead head{kBlockMagic, number, static_cast<std::uint32_t>(bytes.size()), 0,
                 snapshotChecksum(std::span<const std::byte>(block).subspan(sizeof(BlockHead)))};
  head.check = headCheck(head);
  std::memcpy(block.data(), &head, sizeof head);
  return block;
}

Error BlockReader::errorHere(std::string what, std::string remedy) const {
  return {ErrorCode::kInvalidArgument, place(number_ == 0 ? 0 : number_ - 1, last_offset_), std::move(what),
          std::move(remedy)};
}

Error BlockReader::damaged(std::string what) const {
  return {ErrorCode::kInvalidArgument, place(number_, offset_), std::move(what),
          offset_ == 0 ? "give a file that hapticctl record wrote" : "the file is damaged from here on; copy it anew"};
}

/** A file system may leave zeros where the last write did not arrive before the power went. */
bool BlockReader::restIsZero() {
  std::array<char, 4096> piece;
  while (in_) {
    in_.read(piece.data(), piece.size());
    if (std::any_of(piece.begin(), piece.begin() + in_.gcount(), [](char c) { return c != 0; })) return false;
  }
  return true;
}

/**
 * Whether a block that is not as written was on its way when the power went: up to a page it is there, from that page
 * on all is zero to the end of the file.
 */
bool BlockReader::restDidNotArrive(std::span<const std::byte> head, std::span<const std::byte> message) {
  const auto written = [](std::span<const std::byte> part) {
    const auto last = std::find_if(part.rbegin(), part.rend(), [](std::byte b) { return b != std::byte{0}; });
    return static_cast<std::size_t>(part.rend() - last);
  };
  const std::size_t of_message = written(message);
  const std::size_t there = of_message > 0 ? head.size() + of_message : written(head);
  const std::uint64_t page = (offset_ + there + kPage - 1) / kPage * kPage;
  return page < offset_ + head.size() + message.size() && restIsZero();
}

Result<bool> BlockReader::next(kj::Array<capnp::word>& message) {
  if (cut_) return false;
  BlockHead head{};
  in_.read(reinterpret_cast<char*>(&head), sizeof head);
  const std::streamsize got = in_.gcount();
  if (in_.bad()) return damaged("it cannot be read");
  if (got == 0) return false;
  const bool whole = got == static_cast<std::streamsize>(sizeof head);
  if (!whole || head.magic == 0) {
    const char* const bytes = reinterpret_cast<const char*>(&head);
    const char* const magic = reinterpret_cast<const char*>(&kBlockMagic);
    const bool zeros = std::all_of(bytes, bytes + got, [](char c) { return c == 0; }) && restIsZero();
    const bool begins = !whole && std::equal(bytes, bytes + std::min<std::streamsize>(got, 8), magic);
    if (!zeros && !begins) return damaged("no block begins here");
    cut_ = true;
    return false;
  }
  if (head.magic != kBlockMagic) return damaged("no block begins here");
  if (head.check != headCheck(head)) {
    cut_ = restDidNotArrive(std::as_bytes(std::span(&head, 1)), {});
    if (cut_) return false;
    return damaged("its head is damaged");
  }
  if (head.number != number_) return damaged(fmt::format("the block is number {}", head.number));
  if (head.bytes == 0 || head.bytes % 8 != 0 || head.bytes > kMostBlockBytes) {
    return damaged(fmt::format("the block claims {} bytes", head.bytes));
  }
  // Read piece by piece, so that a block which claims to be huge takes no more memory than it really has bytes.
  std::vector<std::byte> bytes;
  while (bytes.size() < head.bytes) {
    const std::size_t before = bytes.size();
    bytes.resize(std::min<std::size_t>(head.bytes, before + kPiece));
    in_.read(reinterpret_cast<char*>(bytes.data() + before), static_cast<std::streamsize>(bytes.size() - before));
    if (in_.bad()) return damaged("it cannot be read");
    if (static_cast<std::size_t>(in_.gcount()) != bytes.size() - before) {
      cut_ = true;
      return false;
    }
  }
  if (head.checksum != snapshotChecksum(bytes)) {
    cut_ = restDidNotArrive(std::as_bytes(std::span(&head, 1)), bytes);
    if (cut_) return false;
    return damaged("its checksum is wrong");
  }
  message = kj::heapArray<capnp::word>(bytes.size() / sizeof(capnp::word));
  std::memcpy(static_cast<void*>(message.begin()), bytes.data(), bytes.size());
  last_offset_ = offset_;
  offset_ += sizeof head + head.bytes;
  ++number_;
  return true;
}

}  // namespace hapticd
