#include "tools/haptic-bench/algorithm/plugin_watch.h"

#include <unistd.h>

#include <array>
#include <atomic>
#include <cstdlib>
#include <cstring>
#include <iterator>

namespace haptic_bench {
namespace {

std::array<char, 512> name{};  // Of the plug-in; empty where none is watched.
std::atomic<std::size_t> sample{0};
std::array<char, 1 << 16> stack{};  // A plug-in that has used up its own is told too.

void say(const char* text) { (void)!::write(STDERR_FILENO, text, std::strlen(text)); }

void sayNumber(std::size_t number) {
  char digits[24];
  char* first = digits + sizeof digits - 1;
  *first = 0;
  do {
    *--first = static_cast<char>('0' + number % 10);
  } while ((number /= 10) != 0);
  say(first);
}

/** Async-signal-safe. */
void blame(const char* what) {
  say("haptic-bench: ");
  say(name.data());
  say(what);
  if (const std::size_t number = sample.load(); number > 0) {
    say(" at sample ");
    sayNumber(number);
  }
  say(" (mend the algorithm; a debugger shows where)\n");
}

void crashed(int number) {
  blame(number == SIGABRT ? ": it aborted" : number == SIGFPE ? ": it crashed in its arithmetic" : ": it crashed");
  std::signal(number, SIG_DFL);  // What crashed does so again, and abort() goes on.
}

void exited() {
  if (name[0] == 0) return;
  blame(": it ended the program");
  _exit(1);
}

}  // namespace

PluginWatch::PluginWatch(const std::string& plugin) {
  static const int once = std::atexit(exited);
  (void)once;
  name[plugin.copy(name.data(), name.size() - 1)] = 0;
  sample = 0;
  stack_t own{};
  own.ss_sp = stack.data();
  own.ss_size = stack.size();
  sigaltstack(&own, nullptr);
  struct sigaction told = {};
  told.sa_handler = crashed;
  told.sa_flags = SA_ONSTACK;
  for (std::size_t i = 0; i < std::size(kSignals); ++i) sigaction(kSignals[i], &told, &before_[i]);
}

PluginWatch::~PluginWatch() {
  for (std::size_t i = 0; i < std::size(kSignals); ++i) sigaction(kSignals[i], &before_[i], nullptr);
  name[0] = 0;
}

void PluginWatch::atSample(std::size_t number) noexcept { sample = number; }

}  // namespace haptic_bench
