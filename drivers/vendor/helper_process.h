/** @file
 * The process that holds a vendor's library: started by systemd behind a socket, or by the daemon itself.
 */
#pragma once

#include <sys/types.h>

#include <string>

#include "rt/base/error.h"

namespace hapticd {

/** Where hapticd-vendor comes from. */
struct HelperOptions {
  std::string socket = "/run/hapticd/vendor.sock";  ///< systemd's; each connection is a process in a unit of its own.
  std::string program;  ///< Started where that socket is not; "": beside this program or in its libexec folder.
};

/** One hapticd-vendor. It ends when this does. Any one thread. */
class HelperProcess {
 public:
  HelperProcess() noexcept = default;
  HelperProcess(HelperProcess&& other) noexcept : socket_(other.socket_), pid_(other.pid_) {
    other.socket_ = -1;
    other.pid_ = 0;
  }
  HelperProcess& operator=(HelperProcess&&) = delete;
  ~HelperProcess() { end(); }

  /** kNotFound when there is neither socket nor program. */
  [[nodiscard]] static Result<HelperProcess> start(const HelperOptions& options);
  [[nodiscard]] int socket() const noexcept { return socket_; }
  /** 0 where systemd has started it. */
  [[nodiscard]] pid_t pid() const noexcept { return pid_; }
  /** Hangs up, at which it brings its device to zero and ends; kills it if it does not within `patience_ms`. */
  void end(int patience_ms = 300) noexcept;

 private:
  HelperProcess(int socket, pid_t pid) noexcept : socket_(socket), pid_(pid) {}
  int socket_ = -1;
  pid_t pid_ = 0;
};

}  // namespace hapticd
