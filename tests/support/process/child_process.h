/** @file
 * A client in a process of its own that a test stops, continues and kills; and a piece of a test run by another user.
 */
#pragma once

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <string>
#include <utility>

namespace hapticd::test {

/** Runs `work` in a forked child, which ends without the test's destructors; it dies with the test, too. */
class ChildProcess {
 public:
  /** `work(say)`: say(text) goes to the parent's heard(). */
  template <class Work>
  explicit ChildProcess(Work work) {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0) std::abort();  // A daemon started later has none of them.
    const pid_t parent = getpid();
    pid_ = fork();
    if (pid_ < 0) std::abort();
    if (pid_ == 0) {
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      if (getppid() != parent) _exit(1);
      close(ends[0]);
      work([&](const std::string& text) { (void)!write(ends[1], text.data(), text.size()); });
      _exit(0);
    }
    close(ends[1]);
    heard_ = ends[0];
  }
  ~ChildProcess() {
    kill();
    close(heard_);
  }
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  [[nodiscard]] pid_t pid() const { return pid_; }
  void signal(int number) const { ::kill(pid_, number); }
  /** SIGKILL, and waits. True if it was alive until then. */
  bool kill() {
    if (pid_ <= 0) return false;
    ::kill(pid_, SIGKILL);
    return end() == "killed by signal 9";
  }
  /** All it says until it ends, and how it ended if not by itself: empty when all is well. */
  std::string all() {
    std::string text;
    char bytes[4096];
    for (ssize_t n = 0; (n = read(heard_, bytes, sizeof bytes)) > 0;) text.append(bytes, static_cast<std::size_t>(n));
    return text + end();
  }
  /** Whether it has ended. Does not wait. */
  [[nodiscard]] bool over() const {
    siginfo_t info{};
    return waitid(P_PID, static_cast<id_t>(pid_), &info, WEXITED | WNOHANG | WNOWAIT) == 0 && info.si_pid == pid_;
  }
  /** Waits until it has said something; false when it ended without. */
  bool saysSomething() {
    char byte = 0;
    return read(heard_, &byte, 1) == 1;
  }

 private:
  std::string end() {
    int status = 0;
    waitpid(std::exchange(pid_, -1), &status, 0);
    if (WIFSIGNALED(status)) return "killed by signal " + std::to_string(WTERMSIG(status));
    return WEXITSTATUS(status) == 0 ? "" : "exit code " + std::to_string(WEXITSTATUS(status));
  }

  pid_t pid_ = -1;
  int heard_ = -1;
};

}  // namespace hapticd::test
