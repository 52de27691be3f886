#include "libclient/src/connection/fork_guard.h"

#include <pthread.h>
#include <unistd.h>

#include <atomic>
#include <mutex>
#include <vector>

namespace hapticd::client {
namespace {

std::atomic<std::uint32_t> generation{0};

struct Descriptors {
  std::mutex mutex;
  std::vector<int> open;
};

/** Never destroyed: a fork may come while the process ends. */
Descriptors& descriptors() {
  static auto* all = new Descriptors;
  return *all;
}

void beforeFork() { descriptors().mutex.lock(); }
void inParent() { descriptors().mutex.unlock(); }
void inChild() {
  for (const int fd : descriptors().open) close(fd);
  descriptors().open.clear();
  generation.fetch_add(1, std::memory_order_relaxed);
  descriptors().mutex.unlock();
}

}  // namespace

std::uint32_t forkGeneration() noexcept { return generation.load(std::memory_order_relaxed); }

// Made and noted, closed and forgotten under the lock that a fork takes: none comes between.

OwnDescriptor::OwnDescriptor(int (*make)()) {
  static const int installed = pthread_atfork(beforeFork, inParent, inChild);
  (void)installed;
  const std::lock_guard lock(descriptors().mutex);
  std::vector<int>& open = descriptors().open;
  open.reserve(open.size() + 1);
  fd_ = make();
  if (fd_ >= 0) open.push_back(fd_);
}

OwnDescriptor::~OwnDescriptor() {
  if (fd_ < 0) return;
  const std::lock_guard lock(descriptors().mutex);
  if (std::erase(descriptors().open, fd_) != 0) close(fd_);  // In a child it is closed already.
}

}  // namespace hapticd::client
