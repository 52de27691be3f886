/** @file
 * A hand on a real daemon in a child process, real clients as processes: what the servo's periods are and how far the
 * force is from the native one.
 */
#pragma once

#include <string>

#include "tools/haptic-bench/load/child.h"
#include "tools/haptic-bench/load/levels.h"
#include "tools/haptic-bench/load/local_client.h"
#include "tools/haptic-bench/load/stroke.h"

namespace haptic_bench {

/** A hapticd with a simulated hand that strokes the top of a sphere of 50 mm, on a socket of its own. */
class LiveDaemon {
 public:
  /** `program`: path of hapticd; empty: the one built beside this program, else that of $PATH. */
  explicit LiveDaemon(const std::string& program);

  [[nodiscard]] const std::string& socket() const { return socket_; }
  [[nodiscard]] const std::string& folder() const { return folder_.path(); }

 private:
  ScratchDirectory folder_;
  std::string socket_;
  Child process_;
};

/** What one run came to. */
struct LiveResult {
  double period_mean_us = 0;  ///< Of the servo.
  double period_p99_us = 0;   ///< Periods above it: 1 %.
  double period_max_us = 0;
  double missed = 0;                 ///< Periods of the servo.
  double client_period_mean_us = 0;  ///< Of the client that computes; 0 without one.
  double client_period_max_us = 0;
  double force_rms = 0;   ///< Difference from the native force at the same places, of its mean magnitude.
  double mean_force = 0;  ///< Native, in contact [N].
};

/** One run of `seconds`, by a client at `rate_hz` unless `source` is kNative. Throws Failure. */
[[nodiscard]] LiveResult runLive(const LiveDaemon& daemon, const Model& model, Source source, double rate_hz,
                                 Level level, double seconds);

}  // namespace haptic_bench
