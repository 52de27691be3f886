#include "daemon/scene/mesh/vdb_maker.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <exception>
#include <system_error>

#include "daemon/leash/spawn.h"
#include "daemon/log/log.h"
#include "daemon/scene/mesh/sync_in_parts.h"

namespace hapticd {

VdbMaker::VdbMaker(VdbOptions options, std::function<void()> made)
    : options_(std::move(options)), made_(std::move(made)), stop_(::eventfd(0, EFD_CLOEXEC)) {}

VdbMaker::~VdbMaker() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
    const std::uint64_t one = 1;
    (void)!::write(stop_.get(), &one, sizeof one);
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void VdbMaker::want(const std::string& cached, const std::string& vdb, bool fresh) {
  {
    const std::lock_guard lock(mutex_);
    if (fresh) failed_.erase(vdb);
    if (isWaiting(vdb) || stopping_ || failed_.count(vdb) != 0) return;
    jobs_.push_back({cached, vdb});
    try {
      if (!thread_.joinable()) thread_ = std::thread([this] { work(); });
    } catch (const std::system_error& e) {  // No more threads: asked for again when the volume is used again.
      log::warn("no OpenVDB file beside a cached volume: {}: no thread can be started: {} {}", vdb, e.what(),
                "(raise TasksMax= or the user's nproc)");
      jobs_.pop_back();
      return;
    }
  }
  changed_.notify_all();
}

bool VdbMaker::isWaiting(const std::string& vdb) const {
  return std::any_of(jobs_.begin(), jobs_.end(), [&](const Job& job) { return job.vdb == vdb; });
}

bool VdbMaker::waits(const std::string& vdb) {
  const std::lock_guard lock(mutex_);
  return isWaiting(vdb);
}

bool VdbMaker::isStopping() {
  const std::lock_guard lock(mutex_);
  return stopping_;
}

void VdbMaker::wait() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return jobs_.empty(); });
}

void VdbMaker::work() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return stopping_ || !jobs_.empty(); });
    if (stopping_) return;
    const Job job = jobs_.front();
    lock.unlock();
    bool made = false;
    try {
      made = make(job);
      if (made) made_();
    } catch (const std::exception& e) {  // Nobody is above us.
      log::warn("no OpenVDB file beside a cached volume: {}: {}", job.vdb, e.what());
    }
    lock.lock();
    if (!made) failed_.insert(job.vdb);
    jobs_.pop_front();
    changed_.notify_all();
  }
}

bool VdbMaker::make(const Job& job) {
  const UniqueFd from(::open(job.cached.c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC));
  if (!from.valid()) return false;  // It went meanwhile.
  const std::string unfinished = job.vdb + ".new";
  const UniqueFd to(::open(unfinished.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW | O_CLOEXEC, 0600));
  if (!to.valid()) {
    log::warn("{}", toString(systemError(unfinished, "open", errno,
                                         "hapticd must be able to write to that folder; builder.cache names another")));
    return false;
  }
  const int fds[] = {from.get(), to.get()};
  const auto pid = spawnProgram(options_.program, {std::to_string(options_.memory_bytes)}, fds);
  std::optional<std::string> why = pid ? await(*pid) : toString(pid.error());
  if (why && why->empty() && !syncInParts(to.get(), [this] { return !isStopping(); })) {
    const int number = errno;
    why.reset();  // The daemon ends.
    if (number != ECANCELED) why = systemError(unfinished, "fsync", number).what;
  }
  if (why && why->empty() && std::rename(unfinished.c_str(), job.vdb.c_str()) == 0) return true;
  ::unlink(unfinished.c_str());
  if (why) log::warn("no OpenVDB file beside a cached volume: {}: {}", job.vdb, why->empty() ? "rename" : *why);
  return false;
}

std::optional<std::string> VdbMaker::await(int pid) {
  const UniqueFd process(static_cast<int>(::syscall(SYS_pidfd_open, pid, 0)));
  pollfd fds[] = {{process.get(), POLLIN, 0}, {stop_.get(), POLLIN, 0}};
  int ready = 0;
  do {
    ready = ::poll(fds, 2, static_cast<int>(std::min<std::int64_t>(options_.timeout_ns / 1'000'000, 1 << 30)));
  } while (ready < 0 && errno == EINTR);
  const bool ended = (fds[0].revents & POLLIN) != 0, stop = fds[1].revents != 0;
  if (!ended) ::kill(pid, SIGKILL);
  int status = 0;
  while (::waitpid(pid, &status, 0) < 0 && errno == EINTR) {
  }
  if (ended && WIFEXITED(status) && WEXITSTATUS(status) == 0) return "";
  if (stop) return {};
  if (!ended) return fmt::format("it took longer than {:.3g} s", static_cast<double>(options_.timeout_ns) * 1e-9);
  if (WIFSIGNALED(status)) return fmt::format("hapticd-builder-vdb died of signal {}", WTERMSIG(status));
  return fmt::format("hapticd-builder-vdb ended with status {}", WEXITSTATUS(status));
}

}  // namespace hapticd
