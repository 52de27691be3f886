/** @file
 * Ctrl-C in the middle of minutes: what has been started is ended, what has been measured is shown.
 */
#pragma once

#include <csignal>

namespace haptic_bench {

/** While it stands, SIGINT, SIGTERM and SIGHUP are noted instead of ending the program. One at a time. */
class Interrupts {
 public:
  Interrupts();
  Interrupts(const Interrupts&) = delete;
  Interrupts& operator=(const Interrupts&) = delete;
  ~Interrupts();

 private:
  struct sigaction before_[3] = {};
};

/** Whether one has come, also to an object that is gone. */
[[nodiscard]] bool interrupted() noexcept;

/** Throws Failure once one has come, also to an object that is gone. Often enough is ten times a second. */
void checkInterrupts(const char* who, const char* remedy);

/** In a process that is no longer this program: they end it again. */
void endOnInterrupts();

}  // namespace haptic_bench
