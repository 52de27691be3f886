/** @file
 * A client process that a test kills: regions in a memfd shared with a forked child.
 */
#pragma once

#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>

#include "rt/ring/state.h"

namespace hapticd::test {

/** Both regions in one memfd, mapped shared before the fork. */
class SharedRegions {
 public:
  SharedRegions() noexcept {
    const int fd = memfd_create("hostile-test", MFD_CLOEXEC);
    if (fd < 0 || ftruncate(fd, kBytes) != 0) std::abort();
    memory_ = static_cast<std::byte*>(mmap(nullptr, kBytes, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0));
    ::close(fd);
    if (memory_ == MAP_FAILED) std::abort();
    reset();
  }
  ~SharedRegions() { munmap(memory_, kBytes); }
  SharedRegions(const SharedRegions&) = delete;
  SharedRegions& operator=(const SharedRegions&) = delete;

  /** As new. Nobody else may be at work on them. */
  void reset() noexcept { initialiseRegions(a(), b(), {}); }
  [[nodiscard]] hd_region_a* a() const noexcept { return reinterpret_cast<hd_region_a*>(memory_); }
  [[nodiscard]] hd_region_b* b() const noexcept { return reinterpret_cast<hd_region_b*>(memory_ + kOffsetB); }

 private:
  static constexpr std::size_t kPage = 4096;
  static constexpr std::size_t kOffsetB = (sizeof(hd_region_a) + kPage - 1) / kPage * kPage;
  static constexpr std::size_t kBytes = kOffsetB + sizeof(hd_region_b);
  std::byte* memory_;
};

/** A child that runs `work` over and over until it is killed; it dies with the test, too. */
class Attacker {
 public:
  template <class Work>
  explicit Attacker(Work work) noexcept {
    const pid_t parent = getpid();
    pid_ = fork();
    if (pid_ < 0) std::abort();
    if (pid_ != 0) return;
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent) _exit(1);
    for (;;) work();
  }
  ~Attacker() { kill(); }
  Attacker(const Attacker&) = delete;
  Attacker& operator=(const Attacker&) = delete;

  /** SIGKILL, and waits for the end. True if it was alive until then. */
  bool kill() noexcept {
    if (pid_ <= 0) return false;
    ::kill(pid_, SIGKILL);
    int status = 0;
    waitpid(pid_, &status, 0);
    pid_ = 0;
    return WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL;
  }

 private:
  pid_t pid_ = 0;
};

}  // namespace hapticd::test
