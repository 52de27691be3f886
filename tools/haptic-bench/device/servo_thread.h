/** @file
 * A thread that does as a servo at 1 kHz, without one.
 */
#pragma once

#include <cstdint>

#include "rt/cycle/realtime.h"
#include "tools/haptic-bench/failure.h"

namespace haptic_bench {

/** Calls `tick(i, now_ns)` each millisecond, `ticks` times, with a servo's priority where that may be had. Waits. */
template <class Tick>
void onServoThread(std::int64_t ticks, hapticd::Clock& clock, Tick&& tick) {
  constexpr std::int64_t kTick_ns = 1'000'000;
  hapticd::RtThread servo;
  orFail(servo.start("servo", 256 * 1024, [&] {
    (void)hapticd::becomeRealtime(80);
    std::int64_t deadline_ns = (clock.now() / kTick_ns + 1) * kTick_ns;
    for (std::int64_t i = 0; i < ticks; ++i, deadline_ns += kTick_ns) {
      clock.sleepUntil(deadline_ns);
      tick(i, clock.now());
    }
  }));
  servo.join();
}

}  // namespace haptic_bench
