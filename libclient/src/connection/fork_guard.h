/** @file
 * What happens to connections when the process forks: the child's copies are closed and refuse every call.
 */
#pragma once

#include <cstdint>
#include <utility>

namespace hapticd::client {

/** Counts the forks between the first process and this one. Servo-safe. */
std::uint32_t forkGeneration() noexcept;

/**
 * A descriptor of this process alone: a child of fork() has its copy closed, whenever the fork comes. Else the daemon
 * would take the parent for alive as long as the child lives. Any one thread.
 */
class OwnDescriptor {
 public:
  OwnDescriptor() noexcept = default;
  /** What `make` gives, a new descriptor or -1 with errno set. Installs the handlers of forks at first use. */
  explicit OwnDescriptor(int (*make)());
  OwnDescriptor(OwnDescriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  OwnDescriptor& operator=(OwnDescriptor&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  ~OwnDescriptor();

  [[nodiscard]] int get() const noexcept { return fd_; }

 private:
  int fd_ = -1;
};

}  // namespace hapticd::client
