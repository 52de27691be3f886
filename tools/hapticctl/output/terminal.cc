#include "tools/hapticctl/output/terminal.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <csignal>

#include "tools/hapticctl/output/output.h"

namespace hapticctl {
namespace {

std::atomic<bool> interrupted{false};
int wake_pipe[2] = {-1, -1};

void onSignal(int) {
  const int saved = errno;
  interrupted.store(true);
  const char byte = 0;
  if (wake_pipe[1] >= 0 && ::write(wake_pipe[1], &byte, 1) < 0) errno = 0;  // Full: it wakes anyway.
  errno = saved;
}

constexpr std::array kSignals = {SIGINT, SIGTERM, SIGHUP};
static_assert(kSignals.size() == Interrupt::kCount);

}  // namespace

Interrupt::Interrupt() {
  if (wake_pipe[0] < 0 && pipe2(wake_pipe, O_CLOEXEC | O_NONBLOCK) != 0) wake_pipe[0] = wake_pipe[1] = -1;
  struct sigaction action {};
  action.sa_handler = onSignal;
  for (std::size_t i = 0; i < std::size(kSignals); ++i) {
    sigaction(kSignals[i], nullptr, &before_[i]);
    if (kSignals[i] != SIGHUP || before_[i].sa_handler != SIG_IGN) sigaction(kSignals[i], &action, nullptr);
  }
}

Interrupt::~Interrupt() {
  for (std::size_t i = 0; i < std::size(kSignals); ++i) sigaction(kSignals[i], &before_[i], nullptr);
}

bool Interrupt::asked() noexcept { return interrupted.load(); }

char Interrupt::wait(std::chrono::milliseconds time, bool keys) const {
  if (asked()) return 0;
  pollfd watched[2] = {{wake_pipe[0], POLLIN, 0}, {STDIN_FILENO, POLLIN, 0}};
  const int n = ::poll(watched, keys ? 2 : 1, static_cast<int>(std::max<std::int64_t>(time.count(), 0)));
  char key = 0;
  if (n > 0 && keys && (watched[1].revents & (POLLIN | POLLHUP)) != 0 && ::read(STDIN_FILENO, &key, 1) != 1) return 'q';
  return key;
}

RawKeys::RawKeys() {
  if (!stdinIsTerminal() || tcgetattr(STDIN_FILENO, &saved_) != 0) return;
  termios raw = saved_;
  raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
  raw.c_cc[VMIN] = 1;
  raw.c_cc[VTIME] = 0;
  active_ = tcsetattr(STDIN_FILENO, TCSANOW, &raw) == 0;
}

RawKeys::~RawKeys() {
  if (active_) tcsetattr(STDIN_FILENO, TCSANOW, &saved_);
}

LiveLine::LiveLine() : active_(isatty(STDERR_FILENO) != 0) {}
LiveLine::~LiveLine() { clear(); }

void LiveLine::show(std::string_view text) {
  if (!active_) return;
  const auto width = static_cast<std::size_t>(std::max(terminalSize().columns - 1, 20));
  const std::string line = fmt::format("\r\x1b[K{}", text.substr(0, width));
  shown_ = ::write(STDERR_FILENO, line.data(), line.size()) > 0;
}

void LiveLine::clear() {
  if (shown_ && ::write(STDERR_FILENO, "\r\x1b[K", 4) > 0) shown_ = false;
}

std::string progressBar(double fraction, std::string_view stage) {
  constexpr int kCells = 30;
  const double part = std::isfinite(fraction) ? std::clamp(fraction, 0.0, 1.0) : 0.0;
  const int full = static_cast<int>(part * kCells);
  return fmt::format("[{}{}] {:3.0f} %  {}", std::string(static_cast<std::size_t>(full), '#'),
                     std::string(static_cast<std::size_t>(kCells - full), '.'), part * 100, stage);
}

bool stdinIsTerminal() { return isatty(STDIN_FILENO) != 0; }
bool stdoutIsTerminal() { return isatty(STDOUT_FILENO) != 0; }

TerminalSize terminalSize() {
  winsize size{};
  if ((ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 || ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0) &&
      size.ws_col > 0) {
    return {size.ws_col, size.ws_row > 0 ? size.ws_row : 24};  // Some tell of columns alone.
  }
  return {80, 24};
}

}  // namespace hapticctl
