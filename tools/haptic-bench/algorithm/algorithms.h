/** @file
 * The algorithms in the box.
 */
#pragma once

#include "tools/haptic-bench/plugin/haptic_algorithm.h"

namespace haptic_bench {

extern const haptic_algorithm kOurs;
extern const haptic_algorithm kGodObject;
extern const haptic_algorithm kNearest;
extern const haptic_algorithm kVoxel;
extern const haptic_algorithm kLocal;
extern const haptic_algorithm kDaemon;
extern const haptic_algorithm kClient;

}  // namespace haptic_bench
