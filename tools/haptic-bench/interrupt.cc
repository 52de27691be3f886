#include "tools/haptic-bench/interrupt.h"

#include <cstddef>
#include <iterator>

#include "tools/haptic-bench/failure.h"

namespace haptic_bench {
namespace {

constexpr int kSignals[] = {SIGINT, SIGTERM, SIGHUP};
volatile std::sig_atomic_t came = 0;

}  // namespace

Interrupts::Interrupts() {
  struct sigaction noted = {};
  noted.sa_handler = [](int) { came = 1; };
  for (std::size_t i = 0; i < std::size(kSignals); ++i) {
    sigaction(kSignals[i], nullptr, &before_[i]);
    if (before_[i].sa_handler != SIG_IGN) sigaction(kSignals[i], &noted, nullptr);  // nohup stays so.
  }
}

Interrupts::~Interrupts() {
  for (std::size_t i = 0; i < std::size(kSignals); ++i) sigaction(kSignals[i], &before_[i], nullptr);
}

bool interrupted() noexcept { return came != 0; }

void checkInterrupts(const char* who, const char* remedy) {
  if (interrupted()) throw Failure(who, "it was interrupted", remedy);
}

void endOnInterrupts() {
  for (const int signal : kSignals) std::signal(signal, SIG_DFL);
}

}  // namespace haptic_bench
