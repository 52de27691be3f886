/** @file
 * Makes the blocks of a recording in their order. Where the bytes go is the caller's.
 */
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "daemon/recording/recording.h"

namespace hapticd {

/** Any one thread. False everywhere: the sink has refused bytes; nothing more is written. */
class RecordingWriter {
 public:
  /** Takes the bytes of one block, whole; false to stop. */
  using Sink = std::function<bool(std::span<const std::byte>)>;
  static constexpr std::size_t kMostCycles = 128;  ///< In one block.
  static constexpr std::size_t kMeshPartBytes = 1u << 20;

  explicit RecordingWriter(Sink sink) : sink_(std::move(sink)) {}

  /** First, once. */
  bool header(const RecordingHeader& header);
  /** A mesh, before the first cycle that uses it. Writes out the cycles that wait. */
  bool mesh(std::uint32_t entry, std::span<const std::byte> snapshot);
  /** A texture, likewise. */
  bool texture(std::uint32_t entry, const TextureView& texture);
  /** Keeps the cycle; writes a block when kMostCycles wait. */
  bool cycle(const RecordedCycle& cycle);
  /** Writes out the cycles that wait. */
  bool flush();
  /** Last, once. */
  bool end(const std::string& reason, std::uint64_t lost);

  /** In blocks that the sink has taken. */
  [[nodiscard]] std::uint64_t cycles() const { return cycles_; }
  [[nodiscard]] bool good() const { return good_; }

 private:
  template <class Fill>
  bool block(Fill&& fill);

  Sink sink_;
  std::uint32_t device_count_ = 0;
  std::vector<RecordedCycle> waiting_;
  std::size_t waiting_count_ = 0;
  std::uint64_t cycles_ = 0;
  std::uint64_t blocks_ = 0;
  bool good_ = true;
};

}  // namespace hapticd
