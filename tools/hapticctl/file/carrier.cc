#include "tools/hapticctl/file/carrier.h"

#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <utility>

namespace hapticctl {
namespace {

constexpr std::size_t kMostAtOnce = 1u << 18;

}  // namespace

Carrier::Carrier(int stream, Target target)
    : stream_(stream),
      target_(std::move(target)),
      room_(std::make_unique_for_overwrite<char[]>(kRoom)),
      keeper_([this] { keep(); }) {
  try {
    taker_ = std::thread([this] { take(); });
  } catch (...) {  // A destructor of a thread that runs would end the program.
    giveUp(EAGAIN);
    keeper_.join();
    throw;
  }
}

void Carrier::join() {
  if (taker_.joinable()) taker_.join();
  if (keeper_.joinable()) keeper_.join();
}

void Carrier::end(std::chrono::milliseconds patience) {
  {
    std::unique_lock lock(mutex_);
    if (!changed_.wait_for(lock, patience, [this] { return ended_; })) (void)::shutdown(stream_, SHUT_RDWR);
  }
  join();
}

void Carrier::take() {
  for (;;) {
    std::size_t at = 0, room = 0;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [this] { return filled_ < kRoom || ended_; });
      if (ended_) return;
      if (filled_ == 0) first_ = 0;  // The same pages again, not ever more of them.
      at = (first_ + filled_) % kRoom;
      room = std::min({kRoom - filled_, kRoom - at, kMostAtOnce});
    }
    const ssize_t n = ::read(stream_, room_.get() + at, room);
    if (n < 0 && errno == EINTR) continue;
    const std::lock_guard lock(mutex_);
    if (n > 0) filled_ += static_cast<std::size_t>(n);
    if (n <= 0) ended_ = true;
    changed_.notify_all();
    if (ended_) return;
  }
}

void Carrier::keep() {
  using Clock = std::chrono::steady_clock;
  auto synced = Clock::now();
  for (;;) {
    std::size_t at = 0, bytes = 0;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [this] { return filled_ > 0 || ended_; });
      if (filled_ == 0) break;
      at = first_;
      bytes = std::min({filled_, kRoom - at, kMostAtOnce});
    }
    int problem = target_.write(room_.get() + at, bytes);
    // Blocks come four times a second: this is at most 0.75 s after the last.
    if (problem == 0 && Clock::now() - synced >= std::chrono::milliseconds(500)) {
      problem = target_.sync();
      synced = Clock::now();
    }
    if (problem != 0) {
      giveUp(problem);
      break;
    }
    const std::lock_guard lock(mutex_);
    first_ = (first_ + bytes) % kRoom;
    filled_ -= bytes;
    changed_.notify_all();
  }
  if (problem_ == 0) problem_ = target_.sync();
  over_ = true;
}

/** Nothing more is taken; the daemon, which may wait for room in the stream, learns it. */
void Carrier::giveUp(int problem) {
  problem_ = problem;
  (void)::shutdown(stream_, SHUT_RDWR);
  const std::lock_guard lock(mutex_);
  ended_ = true;
  changed_.notify_all();
}

}  // namespace hapticctl
