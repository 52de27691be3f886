/** @file
 * What could be touched in a recorded session (docs/recording.md), as a model.
 */
#pragma once

#include <cstdint>
#include <string>

#include "tools/haptic-bench/model/model.h"

namespace hapticd {
class RecordingReader;
}

namespace haptic_bench {

/**
 * The meshes of a recording where they stood when its first device was armed (if none was, at its end), as one model in
 * the world frame; of one object alone if `object` is its number, as an export shows it, and not 0. Their material and
 * what else can be touched, then or later, is told on the standard error. Throws Failure where there is no mesh,
 * and where one moves later: the hand's way would meet it elsewhere.
 */
[[nodiscard]] Model readRecordedModel(const std::string& path, std::uint32_t object);

/** Says on the standard error if a recording, read to its end, was cut off or lost cycles: the session went on. */
void tellWhatLacks(const std::string& path, const hapticd::RecordingReader& recording, std::uint64_t cycles);

}  // namespace haptic_bench
