#include "tools/haptic-bench/load/child.h"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <thread>

#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/interrupt.h"

namespace haptic_bench {
namespace {

/** Forks; the child dies with its parent. */
pid_t forkBound() {
  const pid_t parent = getpid();
  const pid_t pid = fork();
  if (pid < 0) throw Failure("process", std::strerror(errno), "raise the limit of processes");
  if (pid == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    endOnInterrupts();
    if (getppid() != parent) _exit(127);
  }
  return pid;
}

}  // namespace

Child::Child(const std::function<void()>& body) {
  pid_ = forkBound();
  if (pid_ != 0) return;
  try {
    body();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "haptic-bench: %s\n", error.what());
  }
  _exit(0);
}

Child::Child(std::vector<std::string> command, const std::string& log) {
  std::vector<char*> argv;
  argv.reserve(command.size() + 1);
  for (std::string& argument : command) argv.push_back(argument.data());
  argv.push_back(nullptr);
  pid_ = forkBound();
  if (pid_ != 0) return;
  const int out = open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
  dup2(out, STDOUT_FILENO);
  dup2(out, STDERR_FILENO);
  for (const char* name : {"HAPTICD_SOCKET", "HAPTICD_CONFIG", "LISTEN_FDS", "LISTEN_PID", "NOTIFY_SOCKET"}) {
    unsetenv(name);
  }
  execvp(argv[0], argv.data());
  std::fprintf(stderr, "%s: %s\n", argv[0], std::strerror(errno));
  _exit(127);
}

bool Child::running() {
  if (pid_ > 0 && waitpid(pid_, nullptr, WNOHANG) == pid_) pid_ = -1;
  return pid_ > 0;
}

void Child::stop() {
  if (pid_ > 0) kill(pid_, SIGTERM);
  for (int i = 0; i < 500 && running(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  if (!running()) return;
  kill(pid_, SIGKILL);
  waitpid(pid_, nullptr, 0);
  pid_ = -1;
}

ScratchDirectory::ScratchDirectory() {
  std::error_code none;
  const std::filesystem::path place = std::filesystem::temp_directory_path(none);
  if (none) throw Failure("TMPDIR", none.message(), "a folder that is there, or none");
  path_ = (place / "haptic-bench-XXXXXX").string();
  if (mkdtemp(path_.data()) == nullptr) throw Failure(path_, std::strerror(errno), "set TMPDIR");
}

ScratchDirectory::~ScratchDirectory() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace haptic_bench
