#include "daemon/armed/make_safe.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <optional>

#include "daemon/ipc/unique_fd.h"

namespace hapticd {
namespace {

using SteadyClock = std::chrono::steady_clock;

struct Child {
  pid_t pid = -1;
  UniqueFd answer;
  std::string said;
};

/** Closes all other descriptors but the standard ones. */
void keepAlone(int fd) noexcept {
  constexpr unsigned kFirst = STDERR_FILENO + 1;
  const auto kept = static_cast<unsigned>(fd);
  if (kept > kFirst) (void)::close_range(kFirst, kept - 1, 0);
  (void)::close_range(std::max(kept + 1, kFirst), ~0U, 0);
}

/** In the child: the device, then its answer into the pipe: '+' or '-', and a text. */
[[noreturn]] void answer(int pipe, const std::string& uri, const SafeOne& one) {
  // One that is left behind would hold the lock on the list, and the sockets. The log may have been among them: nothing
  // writes to it here.
  keepAlone(pipe);
  std::string said;
  try {
    const Result<void> done = one(uri);
    said = done ? "+" : "-" + toString(done.error());
  } catch (const std::exception& e) {  // drivers' libraries may throw; nobody is above us
    said = std::string("-") + e.what();
  }
  said.resize(std::min<std::size_t>(said.size(), 1000));  // one write into an empty pipe
  (void)!::write(pipe, said.data(), said.size());
  ::_exit(0);
}

Child start(const std::string& uri, const SafeOne& one) {
  Child child;
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) return child;
  child.answer.reset(ends[0]);
  UniqueFd theirs(ends[1]);
  child.pid = ::fork();
  if (child.pid == 0) answer(theirs.get(), uri, one);
  return child;
}

/** Reads until the child closes its end or time is over. */
void listen(Child& child, SteadyClock::time_point end) {
  std::array<char, 1024> piece;
  while (true) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - SteadyClock::now()).count();
    pollfd look{child.answer.get(), POLLIN, 0};
    const int n = ::poll(&look, 1, static_cast<int>(std::max<long>(left, 0)));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return;
    const ssize_t got = ::read(child.answer.get(), piece.data(), piece.size());
    if (got <= 0) return;
    child.said.append(piece.data(), static_cast<std::size_t>(got));
  }
}

/** Its status, or nothing: one that hangs within the kernel dies when that lets go of it, and is init's then. */
std::optional<int> end(pid_t pid) {
  constexpr int kTries = 100;
  ::kill(pid, SIGKILL);  // its word is given; what it has left to do is nothing
  for (int i = 0; i < kTries; ++i) {
    int status = 0;
    if (::waitpid(pid, &status, WNOHANG) == pid) return status;
    ::usleep(1000);
  }
  return {};
}

}  // namespace

std::vector<MadeSafe> makeSafe(const std::vector<std::string>& uris, const SafeOne& one,
                               std::chrono::milliseconds within) {
  const auto until = SteadyClock::now() + within;
  std::vector<Child> children;
  children.reserve(uris.size());
  for (const std::string& uri : uris) children.push_back(start(uri, one));
  std::vector<MadeSafe> all;
  for (std::size_t i = 0; i < uris.size(); ++i) {
    Child& child = children[i];
    MadeSafe result{uris[i], false, "no process could be started for it"};
    if (child.pid > 0) {
      listen(child, until);
      result.ok = !child.said.empty() && child.said[0] == '+';
      result.text = child.said.empty() ? "it did not answer in time" : child.said.substr(1);
      const std::optional<int> status = end(child.pid);
      if (child.said.empty() && status && WIFSIGNALED(*status) && WTERMSIG(*status) != SIGKILL) {
        result.text = "its process died of signal " + std::to_string(WTERMSIG(*status));
      }
    }
    all.push_back(std::move(result));
  }
  return all;
}

}  // namespace hapticd
