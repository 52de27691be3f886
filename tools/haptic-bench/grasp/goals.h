/** @file
 * What of the thesis's grasping must come out with any hands.
 */
#pragma once

#include <string>
#include <vector>

#include "tools/haptic-bench/grasp/align.h"
#include "tools/haptic-bench/grasp/cubes.h"
#include "tools/haptic-bench/grasp/release.h"

namespace haptic_bench::grasp {

struct Goal {
  std::string name;
  bool met;
};
[[nodiscard]] std::vector<Goal> judge(const std::vector<Cube>& cubes);
[[nodiscard]] std::vector<Goal> judge(const std::vector<Release>& releases);
[[nodiscard]] std::vector<Goal> judge(const std::vector<Alignment>& alignments);

}  // namespace haptic_bench::grasp
