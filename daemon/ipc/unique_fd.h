/** @file
 * An owned file descriptor.
 */
#pragma once

#include <unistd.h>

#include <string>
#include <utility>

#include "rt/base/error.h"

namespace hapticd {

/** Closes its descriptor. Any one thread. */
class UniqueFd {
 public:
  UniqueFd() noexcept = default;
  explicit UniqueFd(int fd) noexcept : fd_(fd) {}
  UniqueFd(UniqueFd&& other) noexcept : fd_(other.release()) {}
  UniqueFd& operator=(UniqueFd&& other) noexcept {
    reset(other.release());
    return *this;
  }
  UniqueFd(const UniqueFd&) = delete;
  UniqueFd& operator=(const UniqueFd&) = delete;
  ~UniqueFd() { reset(); }

  [[nodiscard]] int get() const noexcept { return fd_; }
  [[nodiscard]] bool valid() const noexcept { return fd_ >= 0; }
  [[nodiscard]] int release() noexcept { return std::exchange(fd_, -1); }
  void reset(int fd = -1) noexcept {
    if (fd_ >= 0 && fd_ != fd) ::close(fd_);
    fd_ = fd;
  }

 private:
  int fd_ = -1;
};

/** kSystem: "`where`: `call`: text of `number`". Where something has run out, the remedy for that if none is given. */
[[nodiscard]] Error systemError(std::string where, const char* call, int number, std::string remedy = {});
/** The remedy where something has run out, as systemError() has it; else this one, which is for want of rights. */
[[nodiscard]] std::string unlessRunOut(int number, std::string remedy);

/** A second descriptor of the same file, closed on exec. */
[[nodiscard]] Result<UniqueFd> duplicate(int fd);

}  // namespace hapticd
