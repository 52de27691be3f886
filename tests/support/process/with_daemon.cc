// Runs a program with a real daemon of its own:
//   with_daemon [--device URI] [--config TEXT] PROGRAM [ARGUMENT...]
// The program finds the daemon by $HAPTICD_SOCKET. Ends with the program's exit code; shows the daemon's log if that is
// not 0. The daemon is $HAPTICD_PROGRAM.
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "tests/support/process/daemon_fixture.h"

int main(int argc, char** argv) {
  hapticd::test::DaemonOptions options;
  int i = 1;
  for (; i + 1 < argc && std::strncmp(argv[i], "--", 2) == 0; i += 2) {
    if (std::strcmp(argv[i], "--device") == 0) options.device = argv[i + 1];
    if (std::strcmp(argv[i], "--config") == 0) options.config = argv[i + 1];
  }
  if (i >= argc) {
    std::fprintf(stderr, "usage: with_daemon [--device URI] [--config TEXT] PROGRAM [ARGUMENT...]\n");
    return 2;
  }
  hapticd::test::DaemonFixture daemon(options);
  if (!daemon.running()) {
    std::fprintf(stderr, "the daemon did not start:\n%s", daemon.log().c_str());
    return 3;
  }
  setenv("HAPTICD_SOCKET", daemon.socket().c_str(), 1);
  const pid_t child = fork();
  if (child == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    execvp(argv[i], argv + i);
    std::perror(argv[i]);
    _exit(127);
  }
  int status = 0;
  waitpid(child, &status, 0);
  const int code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  if (code != 0) std::fprintf(stderr, "%s ended with %d; the daemon said:\n%s", argv[i], code, daemon.log().c_str());
  return code;
}
