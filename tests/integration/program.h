/** @file
 * The daemon's program as it is started by a user or by systemd: its arguments, its words, its exit code.
 */
#pragma once

#include <fcntl.h>
#include <grp.h>
#include <gtest/gtest.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/eventually.h"
#include "tests/support/process/temporary_directory.h"

namespace hapticd::test {

/** A run of hapticd with its output in a file. */
class Program {
 public:
  /** What the child gets besides its arguments. */
  struct Surroundings {
    bool unprivileged = false;
    std::string notify_socket;  ///< $NOTIFY_SOCKET
    std::string watchdog_us;    ///< $WATCHDOG_USEC
    std::vector<int> sockets;   ///< Passed as systemd does, named control and admin.
  };
  Program(const TemporaryDirectory& directory, std::vector<std::string> arguments, bool unprivileged)
      : Program(directory, std::move(arguments), Surroundings{unprivileged, {}, {}, {}}) {}
  Program(const TemporaryDirectory& directory, std::vector<std::string> arguments)
      : Program(directory, std::move(arguments), Surroundings{}) {}
  Program(const TemporaryDirectory& directory, std::vector<std::string> arguments, const Surroundings& around)
      : output_(directory.path() + "/output" + std::to_string(++count_)) {
    arguments.insert(arguments.begin(), HAPTICD_PROGRAM);
    std::vector<char*> argv;
    for (auto& a : arguments) argv.push_back(a.data());
    argv.push_back(nullptr);
    const int out = open(output_.c_str(), O_CREAT | O_WRONLY | O_CLOEXEC, 0666);
    const pid_t parent = getpid();
    pid_ = fork();
    if (pid_ == 0) {
      prctl(PR_SET_PDEATHSIG, SIGKILL);  // If this test is killed, so is its daemon.
      if (getppid() != parent) _exit(97);
      dup2(out, 1);
      dup2(out, 2);
      setenv("HOME", directory.path().c_str(), 1);  // the user's own configuration is not ours
      for (const char* name : {"XDG_CONFIG_HOME", "HAPTICD_CONFIG", "CONFIGURATION_DIRECTORY"}) unsetenv(name);
      if (!around.notify_socket.empty()) setenv("NOTIFY_SOCKET", around.notify_socket.c_str(), 1);
      if (!around.watchdog_us.empty()) setenv("WATCHDOG_USEC", around.watchdog_us.c_str(), 1);
      for (std::size_t i = 0; i < around.sockets.size(); ++i) dup2(around.sockets[i], 3 + static_cast<int>(i));
      if (!around.sockets.empty()) {
        setenv("LISTEN_PID", std::to_string(getpid()).c_str(), 1);
        setenv("LISTEN_FDS", std::to_string(around.sockets.size()).c_str(), 1);
        setenv("LISTEN_FDNAMES", "control:admin", 1);
      }
      if (around.unprivileged) {
        rlimit none{0, 0};
        setrlimit(RLIMIT_RTPRIO, &none);
        if (setgroups(0, nullptr) != 0 || setgid(65534) != 0 || setuid(65534) != 0) _exit(99);
      }
      execv(argv[0], argv.data());
      _exit(98);
    }
    close(out);
  }
  ~Program() {
    if (pid_ > 0) {
      kill(pid_, SIGKILL);
      waitpid(pid_, nullptr, 0);
    }
  }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  /** Exit code; -1 after a minute, -signal when killed. */
  int wait() {
    for (int i = 0; i < 6000 && pid_ > 0; ++i) {
      int status = 0;
      if (waitpid(pid_, &status, WNOHANG) == pid_) {
        pid_ = -1;
        return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return -1;
  }
  void terminate(int signal = SIGTERM) const { kill(pid_, signal); }
  /** A limit that it has, soft and hard. */
  [[nodiscard]] rlimit limit(__rlimit_resource what) const {
    rlimit has{};
    EXPECT_EQ(prlimit(pid_, what, nullptr, &has), 0);
    return has;
  }
  [[nodiscard]] std::string output() const {
    std::ifstream in(output_);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  [[nodiscard]] bool says(const std::string& text) const {
    return eventually([&] { return output().find(text) != std::string::npos; });
  }

 private:
  static inline int count_ = 0;
  std::string output_;
  pid_t pid_ = -1;
};

class ProgramTest : public ::testing::Test {
 protected:
  TemporaryDirectory directory;
  std::string socket = directory.path() + "/run/control.sock";
  std::vector<std::string> run(std::vector<std::string> more = {}) {
    std::vector<std::string> arguments{"--allow-no-rt", "--socket", socket, "--device", "sim://default"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
};

}  // namespace hapticd::test
