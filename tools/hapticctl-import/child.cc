#include "tools/hapticctl-import/child.h"

#include <fmt/core.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>

#include "tools/hapticctl-import/image.h"

namespace hapticctl_import {

int inChild(const std::function<int()>& work, std::uint64_t most_bytes) {
  std::fflush(nullptr);
  const pid_t parent = ::getpid(), child = ::fork();
  if (child < 0) throw ImportError({}, fmt::format("no process can be started: {}", std::strerror(errno)));
  if (child == 0) {
    if (most_bytes == 0) {
      most_bytes =
          static_cast<std::uint64_t>(::sysconf(_SC_PHYS_PAGES)) * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
    }
    ::prctl(PR_SET_PDEATHSIG, SIGTERM);  // It writes for nobody else, and leaves nothing half written.
    if (::getppid() != parent) ::_exit(1);
    const rlimit memory{most_bytes, most_bytes}, core{0, 0};
    ::setrlimit(RLIMIT_AS, &memory);
    ::setrlimit(RLIMIT_CORE, &core);
    const int code = work();
    std::fflush(nullptr);
    ::_exit(code);
  }
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFEXITED(status)) return WEXITSTATUS(status);
  throw ImportError({}, fmt::format("the reader died of it ({})", ::strsignal(WTERMSIG(status))),
                    "the file is damaged, or too large for this machine; nothing was loaded");
}

}  // namespace hapticctl_import
