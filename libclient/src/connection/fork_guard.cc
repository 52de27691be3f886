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
  // Else the daemon would take the parent for alive as long as the child lives.
  for (const int fd : descriptors().open) close(fd);
  descriptors().open.clear();
  generation.fetch_add(1, std::memory_order_relaxed);
  descriptors().mutex.unlock();
}

}  // namespace

std::uint32_t forkGeneration() noexcept { return generation.load(std::memory_order_relaxed); }

void closeInChildren(int fd) {
  static const int installed = pthread_atfork(beforeFork, inParent, inChild);
  (void)installed;
  const std::lock_guard lock(descriptors().mutex);
  descriptors().open.push_back(fd);
}

void forgetDescriptor(int fd) noexcept {
  const std::lock_guard lock(descriptors().mutex);
  std::erase(descriptors().open, fd);
}

}  // namespace hapticd::client
