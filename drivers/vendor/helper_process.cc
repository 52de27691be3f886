#include "drivers/vendor/helper_process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "drivers/sibling_program.h"

namespace hapticd {
namespace {

/** A connection to systemd's socket, or -1 where there is none. */
int connectTo(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.empty() || path.size() >= sizeof address.sun_path) return -1;
  std::memcpy(address.sun_path, path.data(), path.size());
  const int fd = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
  if (fd < 0) return -1;
  if (::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return fd;
  ::close(fd);
  return -1;
}

}  // namespace

Result<HelperProcess> HelperProcess::start(const HelperOptions& options) {
  if (const int fd = connectTo(options.socket); fd >= 0) return HelperProcess(fd, 0);
  auto program = findSibling("hapticd-vendor", options.program, "install it beside hapticd");
  if (!program) return program.error();
  int pair[2];
  if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, pair) != 0) {
    return Error{ErrorCode::kSystem, "hapticd-vendor", std::string("socketpair: ") + std::strerror(errno), {}};
  }
  posix_spawn_file_actions_t files;
  posix_spawnattr_t attributes;
  ::posix_spawn_file_actions_init(&files);
  ::posix_spawnattr_init(&attributes);
  ::posix_spawn_file_actions_adddup2(&files, pair[1], STDIN_FILENO);
  ::posix_spawn_file_actions_addclosefrom_np(&files, STDERR_FILENO + 1);
  sigset_t none, all;
  ::sigemptyset(&none);
  ::sigfillset(&all);
  ::posix_spawnattr_setsigmask(&attributes, &none);
  ::posix_spawnattr_setsigdefault(&attributes, &all);
  ::posix_spawnattr_setpgroup(&attributes, 0);  // a terminal's Ctrl-C is for the daemon
  ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
  char* const arguments[] = {program->data(), nullptr};
  pid_t pid = 0;
  // As a fork would, but without copying the page tables of a locked process. The SDK finds its own settings by the
  // environment (OpenHaptics: GTDD_HOME).
  const int bad = ::posix_spawn(&pid, program->c_str(), &files, &attributes, arguments, environ);
  ::posix_spawn_file_actions_destroy(&files);
  ::posix_spawnattr_destroy(&attributes);
  ::close(pair[1]);
  if (bad == 0) return HelperProcess(pair[0], pid);
  ::close(pair[0]);
  return Error{ErrorCode::kSystem, *program, std::string("it does not start: ") + std::strerror(bad), {}};
}

void HelperProcess::end(int patience_ms) noexcept {
  if (const int fd = std::exchange(socket_, -1); fd >= 0) ::close(fd);
  const pid_t pid = std::exchange(pid_, 0);
  if (pid == 0) return;
  for (int waited_ms = 0; ::waitpid(pid, nullptr, WNOHANG) == 0; ++waited_ms) {
    if (waited_ms == patience_ms) ::kill(pid, SIGKILL);
    (void)::poll(nullptr, 0, 1);
  }
}

}  // namespace hapticd
