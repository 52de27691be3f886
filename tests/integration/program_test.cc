// The program hapticd: its exit codes, its refusals, its clean end.
#include <fcntl.h>
#include <grp.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <chrono>
#include <fstream>
#include <thread>

#include "tests/integration/raw_client.h"
#include "tests/support/temporary_directory.h"

namespace hapticd::test {
namespace {

/** A run of hapticd with its output in a file. */
class Program {
 public:
  Program(const TemporaryDirectory& directory, std::vector<std::string> arguments, bool unprivileged = false)
      : output_(directory.path() + "/output" + std::to_string(++count_)) {
    arguments.insert(arguments.begin(), HAPTICD_PROGRAM);
    std::vector<char*> argv;
    for (auto& a : arguments) argv.push_back(a.data());
    argv.push_back(nullptr);
    const int out = open(output_.c_str(), O_CREAT | O_WRONLY | O_CLOEXEC, 0666);
    pid_ = fork();
    if (pid_ == 0) {
      dup2(out, 1);
      dup2(out, 2);
      setenv("HOME", directory.path().c_str(), 1);  // the user's own configuration is not ours
      for (const char* name : {"XDG_CONFIG_HOME", "HAPTICD_CONFIG", "CONFIGURATION_DIRECTORY"}) unsetenv(name);
      if (unprivileged) {
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

  /** Exit code; -1 after ten seconds, -signal when killed. */
  int wait() {
    for (int i = 0; i < 1000 && pid_ > 0; ++i) {
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
  [[nodiscard]] std::string output() const {
    std::ifstream in(output_);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  [[nodiscard]] bool says(const std::string& text) const {
    for (int i = 0; i < 500; ++i) {
      if (output().find(text) != std::string::npos) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
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

TEST_F(ProgramTest, ServesRefusesASecondEndsCleanlyAndLeavesNoSocket) {
  Program first(directory, run());
  ASSERT_TRUE(first.says("ready")) << first.output();
  {
    Loop loop;
    RawClient client{loop, socket};
    EXPECT_TRUE(good(loop.call(client.daemon.stateRequest()).getStatus()));
  }
  Program second(directory, run());
  EXPECT_EQ(second.wait(), 5) << second.output();
  EXPECT_NE(second.output().find("another hapticd"), std::string::npos);
  {
    Loop loop;
    RawClient client{loop, socket};
    EXPECT_TRUE(good(loop.call(client.daemon.stateRequest()).getStatus())) << "the first serves on";
  }
  first.terminate();
  EXPECT_EQ(first.wait(), 0) << first.output();
  EXPECT_NE(access(socket.c_str(), F_OK), 0);
  struct stat folder {};
  ASSERT_EQ(stat((directory.path() + "/run").c_str(), &folder), 0);
  EXPECT_EQ(folder.st_mode & 0777u, 0700u);
}

TEST_F(ProgramTest, ASocketLeftByADeadDaemonIsTakenOver) {
  {
    Program dies(directory, run());
    ASSERT_TRUE(dies.says("ready")) << dies.output();
    dies.terminate(SIGKILL);
    EXPECT_EQ(dies.wait(), -SIGKILL);
  }
  EXPECT_EQ(access(socket.c_str(), F_OK), 0) << "the dead one left it";
  Program next(directory, run());
  EXPECT_TRUE(next.says("ready")) << next.output();
  next.terminate(SIGINT);
  EXPECT_EQ(next.wait(), 0);
}

TEST_F(ProgramTest, AFileInTheWayIsNotRemoved) {
  const std::string precious = directory.path() + "/notes.txt";
  std::ofstream(precious) << "mine";
  Program program(directory, {"--allow-no-rt", "--socket", precious});
  EXPECT_EQ(program.wait(), 5) << program.output();
  std::string kept;
  std::ifstream(precious) >> kept;
  EXPECT_EQ(kept, "mine");
}

TEST_F(ProgramTest, ExitCodesSayWhatIsWrong) {
  const auto code = [&](std::vector<std::string> arguments) {
    Program program(directory, std::move(arguments));
    return program.wait();
  };
  EXPECT_EQ(code({"--version"}), 0);
  EXPECT_EQ(code({"--help"}), 0);
  EXPECT_EQ(code({"--print-config"}), 0);
  EXPECT_EQ(code({"--check-config"}), 0);
  EXPECT_EQ(code({"--no-such-option"}), 1);
  EXPECT_EQ(code({"--rate", "5"}), 1);
  EXPECT_EQ(code({"--log-level", "loud"}), 1);
  EXPECT_EQ(code({"--config", directory.path() + "/missing.toml"}), 2);
  const std::string bad = directory.path() + "/bad.toml";
  std::ofstream(bad) << "[servo]\nrate_zh = 1000\n";
  Program misspelt(directory, {"--check-config", "--config", bad});
  EXPECT_EQ(misspelt.wait(), 2);
  EXPECT_NE(misspelt.output().find("bad.toml:2"), std::string::npos) << misspelt.output();
  EXPECT_EQ(code({"--allow-no-rt", "--socket", socket, "--device", "nosuch://thing"}), 4);
  EXPECT_EQ(code({"--allow-no-rt", "--socket", "/" + std::string(200, 'x')}), 5);
}

TEST_F(ProgramTest, WithoutRealTimeRightsItRefusesAndNamesTheRemedy) {
  if (geteuid() != 0) GTEST_SKIP() << "needs root to drop rights from";
  ASSERT_EQ(chmod(directory.path().c_str(), 0777), 0);
  const auto at = [&](const char* name) { return directory.path() + "/" + name + "/control.sock"; };
  {
    Program allowed(directory, {"--socket", at("root"), "--device", "sim://default"});
    ASSERT_TRUE(allowed.says("ready")) << "with rights it runs: " << allowed.output();
    allowed.terminate();
    EXPECT_EQ(allowed.wait(), 0);
  }
  Program refused(directory, {"--socket", at("user"), "--device", "sim://default"}, true);
  EXPECT_EQ(refused.wait(), 3) << refused.output();
  EXPECT_NE(refused.output().find("RLIMIT_RTPRIO"), std::string::npos) << refused.output();
  EXPECT_NE(refused.output().find("--allow-no-rt"), std::string::npos) << refused.output();
  Program told(directory, {"--socket", at("told"), "--device", "sim://default", "--allow-no-rt"}, true);
  EXPECT_TRUE(told.says("ready")) << told.output();
  told.terminate();
  EXPECT_EQ(told.wait(), 0);
}

}  // namespace
}  // namespace hapticd::test
