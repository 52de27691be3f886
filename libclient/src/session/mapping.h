/** @file
 * A mapped descriptor of the daemon's. Not inherited by children: two processes must not write one ring.
 */
#pragma once

#include <cstddef>

#include "libclient/src/reply/failure.h"

namespace hapticd::client {

class Mapping {
 public:
  Mapping() = default;
  Mapping(Mapping&& other) noexcept
      : address_(std::exchange(other.address_, nullptr)), bytes_(std::exchange(other.bytes_, 0)) {}
  Mapping& operator=(Mapping&& other) noexcept {
    std::swap(address_, other.address_);
    std::swap(bytes_, other.bytes_);
    return *this;
  }
  ~Mapping() { unmap(); }

  /** Maps at least `bytes` of it, faulted in; the descriptor stays the caller's. */
  static Failure map(int fd, std::size_t bytes, bool writable, const char* name, Mapping& mapping);
  void unmap() noexcept;

  [[nodiscard]] void* address() const noexcept { return address_; }
  [[nodiscard]] std::size_t bytes() const noexcept { return bytes_; }

 private:
  void* address_ = nullptr;
  std::size_t bytes_ = 0;
};

}  // namespace hapticd::client
