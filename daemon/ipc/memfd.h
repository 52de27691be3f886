/** @file
 * Shared memory that neither side can pull from under the other: sealed memfds and their mappings.
 *
 * The daemon makes every memfd that a client sees (region A, region B, uploads) and checks the seals of those the
 * builder makes. What each set of seals stops was measured: without FUTURE_WRITE a client can punch holes into memory
 * that the servo has locked, and the servo faults (docs/protocol.md).
 */
#pragma once

#include <cstddef>
#include <span>

#include "daemon/ipc/unique_fd.h"

namespace hapticd {

/** What nobody can do to a memfd any more. Sets are exact: see Memfd::requireSeals(). */
enum class Seals {
  kNone,          ///< Anything goes.
  kFixedSize,     ///< SHRINK|GROW: region B and uploads from their creation.
  kNoNewWriters,  ///< SHRINK|GROW|FUTURE_WRITE|SEAL: region A once the daemon, B once both sides have mapped it.
  kFrozen,        ///< SHRINK|GROW|WRITE|SEAL: uploads at commit, snapshots.
};

/** A mapped range, unmapped on destruction. */
class Mapping {
 public:
  Mapping() noexcept = default;
  Mapping(Mapping&& other) noexcept { *this = std::move(other); }
  Mapping& operator=(Mapping&& other) noexcept;
  Mapping(const Mapping&) = delete;
  Mapping& operator=(const Mapping&) = delete;
  ~Mapping() { reset(); }

  [[nodiscard]] std::byte* data() const noexcept { return data_; }
  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  [[nodiscard]] bool writable() const noexcept { return writable_; }
  [[nodiscard]] explicit operator bool() const noexcept { return data_ != nullptr; }
  [[nodiscard]] std::span<const std::byte> bytes() const noexcept { return {data_, size_}; }
  /** The start of the mapping as a T; null if it is smaller than a T. */
  template <class T>
  [[nodiscard]] T* as() const noexcept {
    return size_ >= sizeof(T) ? reinterpret_cast<T*>(data_) : nullptr;
  }

  /**
   * Locks the pages and touches each, so that no thread faults on them later. Writable pages are touched by an atomic
   * `or 0`: what another process writes meanwhile is not lost. kSystem names the bytes wanted and RLIMIT_MEMLOCK.
   */
  [[nodiscard]] Result<void> lock();

  void reset() noexcept;

 private:
  friend class Memfd;
  std::byte* data_ = nullptr;
  std::size_t size_ = 0;
  bool writable_ = false;
};

/** An anonymous file in memory. */
class Memfd {
 public:
  enum class Access {
    kRead,
    kWrite,    ///< Shared: others see what is written.
    kPrivate,  ///< Writable copy of this mapping alone; possible when frozen. lock() makes the copies at once.
  };

  Memfd() noexcept = default;

  /** Of `bytes` zeros, closed on exec, not executable where the kernel knows how (6.3). `name` shows in /proc. */
  [[nodiscard]] static Result<Memfd> create(const char* name, std::size_t bytes);
  /** Takes over a descriptor that came from elsewhere. kInvalidArgument if it is not a memfd or is empty. */
  [[nodiscard]] static Result<Memfd> adopt(UniqueFd fd);

  /** The whole file. Never empty. */
  [[nodiscard]] Result<Mapping> map(Access access) const;

  /**
   * Adds what is missing of that set and reads it back. kFrozen: kStillMapped while anybody has it mapped writable;
   * nothing is sealed then that was not before.
   */
  [[nodiscard]] Result<void> seal(Seals seals) const;
  /** Ok only if exactly those seals are set (F_SEAL_EXEC aside, which the kernel may set by itself). */
  [[nodiscard]] Result<void> requireSeals(Seals seals) const;
  /** F_SEAL_* bits without F_SEAL_EXEC. */
  [[nodiscard]] Result<int> sealBits() const;

  /** A descriptor to hand to another process. */
  [[nodiscard]] Result<UniqueFd> share() const { return duplicate(fd_.get()); }
  [[nodiscard]] int fd() const noexcept { return fd_.get(); }
  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  [[nodiscard]] bool valid() const noexcept { return fd_.valid(); }

 private:
  UniqueFd fd_;
  std::size_t size_ = 0;
};

}  // namespace hapticd
