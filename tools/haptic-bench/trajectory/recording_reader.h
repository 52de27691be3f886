/** @file
 * Recordings of real sessions (docs/recording.md) as trajectories.
 */
#pragma once

#include <string>

#include "tools/haptic-bench/trajectory/trajectory.h"

namespace haptic_bench {

/** Whether a file begins as a recording does. */
[[nodiscard]] bool isRecording(const std::string& path);

/**
 * Where the hand of one device was in each cycle, and as truth the force that was sent then. Throws Failure with block
 * and byte, or when there is no such device. A recording that was cut off gives what is whole, and that is
 * told on the standard error.
 */
[[nodiscard]] Trajectory readRecordedSession(const std::string& path, std::size_t device);

}  // namespace haptic_bench
