#include "daemon/armed/last_resort.h"

#include <array>
#include <atomic>
#include <csignal>

#include "proto/shm_layout.h"

namespace hapticd {
namespace {

constexpr std::size_t kMostGroups = 16;
std::array<std::atomic<Device*>, kMostGroups * HD_MAX_DEVICES> held;
static_assert(std::atomic<Device*>::is_always_lock_free);  // read by a signal handler

/** All that would end the process at once, but real-time signals; of these SIGPIPE and SIGXFSZ are ignored by whoever
 * installs this. */
constexpr int kFatal[] = {SIGXCPU, SIGABRT, SIGSEGV, SIGBUS,    SIGFPE,  SIGILL,  SIGSYS, SIGTRAP, SIGQUIT,
                          SIGHUP,  SIGALRM, SIGUSR1, SIGVTALRM, SIGPROF, SIGUSR2, SIGPWR, SIGPOLL, SIGSTKFLT};

/** Only what is safe in a signal handler: safe() is by its contract. */
void bringToZero(int signal) {
  for (const auto& slot : held) {
    if (Device* const device = slot.load(std::memory_order_acquire)) device->safe();  // A, pairs with R
  }
  // The handler was removed when it was called. Another servo may still write; it ends with the process, at once.
  std::raise(signal);
}

}  // namespace

void installLastResort() noexcept {
  struct sigaction action {};
  action.sa_handler = bringToZero;
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_NODEFER);
  sigemptyset(&action.sa_mask);
  const auto install = [&](int signal) {
    struct sigaction before {};
    // What is ignored kills nobody.
    if (sigaction(signal, nullptr, &before) == 0 && before.sa_handler == SIG_DFL) sigaction(signal, &action, nullptr);
  };
  for (const int signal : kFatal) install(signal);
  for (int signal = SIGRTMIN; signal <= SIGRTMAX; ++signal) install(signal);
}

LastResort::LastResort(Device& device) noexcept : device_(&device) {
  for (auto& slot : held) {
    Device* nobody = nullptr;
    if (slot.compare_exchange_strong(nobody, device_, std::memory_order_release)) return;  // R: it stands
  }
}

LastResort::~LastResort() {
  for (auto& slot : held) {
    Device* mine = device_;
    if (slot.compare_exchange_strong(mine, nullptr, std::memory_order_release)) return;
  }
}

}  // namespace hapticd
