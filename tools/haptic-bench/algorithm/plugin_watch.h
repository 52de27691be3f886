/** @file
 * A plug-in that crashes or exits takes haptic-bench with it: this says whose fault it was, and at which sample.
 */
#pragma once

#include <csignal>
#include <cstddef>
#include <string>

namespace haptic_bench {

/**
 * While it stands, a crash, an abort or an exit of the program is told on the standard error as this plug-in's. A
 * crash then ends the program as it would have, with its core; an exit ends it with 1. One at a time.
 */
class PluginWatch {
 public:
  explicit PluginWatch(const std::string& plugin);
  PluginWatch(const PluginWatch&) = delete;
  PluginWatch& operator=(const PluginWatch&) = delete;
  ~PluginWatch();

  /** The sample at which its functions are called from now on, from 1; 0: none. */
  static void atSample(std::size_t number) noexcept;

  static constexpr int kSignals[] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT};

 private:
  struct sigaction before_[5] = {};
};

}  // namespace haptic_bench
