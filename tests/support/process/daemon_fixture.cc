#include "tests/support/process/daemon_fixture.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sstream>
#include <thread>

namespace hapticd::test {
namespace {

constexpr std::chrono::seconds kPatience{30};  // sanitizers on a busy machine are slow
constexpr char kPatient[] = "\n[servo]\nmissed_limit = 100000\n";

/** Where the daemon says READY=1, as it does to systemd. */
int notifySocket(const std::string& path) {
  const int fd = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof address.sun_path - 1);
  unlink(path.c_str());
  if (fd < 0 || bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) std::abort();
  return fd;
}

bool saysReady(int fd) {
  pollfd readable{fd, POLLIN, 0};
  if (poll(&readable, 1, 20) != 1) return false;
  char message[1024];
  const ssize_t size = recv(fd, message, sizeof message, 0);
  return size > 0 &&
         std::string_view(message, static_cast<std::size_t>(size)).find("READY=1") != std::string_view::npos;
}

}  // namespace

DaemonFixture::DaemonFixture(DaemonOptions options) : options_(std::move(options)) {
  if (options_.program.empty()) {
    const char* program = std::getenv("HAPTICD_PROGRAM");
    options_.program = program == nullptr ? "hapticd" : program;
  }
  std::ofstream(directory_.path() + "/hapticd.toml") << options_.config << kPatient;
  start();
}

DaemonFixture::~DaemonFixture() { terminate(); }

bool DaemonFixture::start() {
  if (running()) return true;
  said_ = log().size();
  const int notify = notifySocket(directory_.path() + "/notify");
  spawn(notify);
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  while (!ready_ && !reap(false) && std::chrono::steady_clock::now() < deadline) ready_ = saysReady(notify);
  close(notify);
  if (!ready_) kill();
  return ready_;
}

void DaemonFixture::spawn(int notify) {
  std::vector<std::string> arguments = {
      options_.program, "--allow-no-rt", "--socket", socket(),
      "--admin-socket", adminSocket(),   "--config", directory_.path() + "/hapticd.toml"};
  if (!options_.device.empty()) arguments.insert(arguments.end(), {"--device", options_.device});
  arguments.insert(arguments.end(), options_.arguments.begin(), options_.arguments.end());
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  const std::string log_path = directory_.path() + "/hapticd.log";
  const std::string notify_path = directory_.path() + "/notify";
  const pid_t parent = getpid();

  ready_ = false;
  pid_ = fork();
  if (pid_ != 0) return;
  // If this test is killed, so is its daemon; if it was killed already, nobody would tell.
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(127);
  const int log = open(log_path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
  dup2(log, STDOUT_FILENO);
  dup2(log, STDERR_FILENO);
  const int nothing = open("/dev/null", O_RDONLY | O_CLOEXEC);
  dup2(nothing, STDIN_FILENO);
  close(notify);
  setenv("NOTIFY_SOCKET", notify_path.c_str(), 1);
  setenv("XDG_RUNTIME_DIR", directory_.path().c_str(), 1);
  for (const char* name : {"HAPTICD_SOCKET", "HAPTICD_CONFIG", "LISTEN_FDS", "LISTEN_PID", "WATCHDOG_USEC"}) {
    unsetenv(name);
  }
  execvp(argv[0], argv.data());
  dprintf(STDERR_FILENO, "%s: %s\n", argv[0], strerror(errno));
  _exit(127);
}

bool DaemonFixture::reap(bool wait) {
  if (pid_ <= 0) return true;
  const pid_t reaped = waitpid(pid_, &status_, wait ? 0 : WNOHANG);
  if (reaped == 0) return false;
  pid_ = -1;
  ready_ = false;
  return true;
}

bool DaemonFixture::running() { return !reap(false) && ready_; }

void DaemonFixture::kill() {
  if (pid_ > 0) ::kill(pid_, SIGKILL);
  reap(true);
}

int DaemonFixture::terminate() {
  if (pid_ > 0) ::kill(pid_, SIGTERM);
  for (int i = 0; i < 6000 && !reap(false); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  kill();
  return WIFEXITED(status_) ? WEXITSTATUS(status_) : -1;
}

std::string DaemonFixture::stop() {
  const int code = terminate();
  const std::string said = log().substr(said_);
  if (said.find("Sanitizer") != std::string::npos) return "a sanitizer speaks in its log";
  // A machine too busy to run a servo within 0.3 s: the daemon ends without it, and says so.
  if (code == 0 || (code == 1 && said.find("does not come back") != std::string::npos)) return {};
  return "it ends with " + std::to_string(code) + " when it is stopped";
}

std::string DaemonFixture::log() const {
  std::ostringstream text;
  text << std::ifstream(directory_.path() + "/hapticd.log").rdbuf();
  return text.str();
}

}  // namespace hapticd::test
