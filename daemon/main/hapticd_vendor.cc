// hapticd-vendor: one device through its vendor's closed library, in a process of its own. hapticd or systemd starts it
// with a socket as its standard input.
#include <fcntl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>

#include "drivers/vendor/serve.h"

namespace {

std::atomic<bool> stop{false};

}  // namespace

int main() {
  int kind = 0;
  socklen_t size = sizeof kind;
  if (::getsockopt(STDIN_FILENO, SOL_SOCKET, SO_TYPE, &kind, &size) != 0 || kind != SOCK_SEQPACKET) {
    std::fputs("hapticd-vendor: hapticd starts it; by hand it does nothing\n", stderr);
    return 2;
  }
  const int socket = ::fcntl(STDIN_FILENO, F_DUPFD_CLOEXEC, 3);
  const int nothing = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
  if (socket < 0 || nothing < 0 || ::dup2(nothing, STDIN_FILENO) < 0) return 2;
  struct sigaction end {};
  end.sa_handler = [](int) { stop.store(true); };
  for (const int signal : {SIGTERM, SIGINT, SIGHUP, SIGQUIT}) ::sigaction(signal, &end, nullptr);
  ::signal(SIGPIPE, SIG_IGN);
  return hapticd::serveVendor(socket, stop);
}
