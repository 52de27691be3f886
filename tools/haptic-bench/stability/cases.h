/** @file
 * What is done to a tool that a hand holds, against which solid: dropped, pushed, jammed, spun and hammered.
 */
#pragma once

#include <string>
#include <vector>

#include "tools/haptic-bench/stability/analytic_detector.h"
#include "tools/haptic-bench/stability/tool_rig.h"

namespace haptic_bench {

/** A tool and what it meets. */
struct StabilityPair {
  const char* name;
  Points points;  ///< Empty: volumes tell where they touch.
  Field field;
  Vec3 size;                   ///< Of the tool's box.
  Vec3 middle = Vec3::Zero();  ///< Of it in the tool's frame.
  Vec3 home = Vec3::Zero();    ///< Where the tool's middle is when both just touch, or fit.
  double above = 0.03;         ///< What is dropped or hammers starts so high over that [m].
  bool judged = true;          ///< False: known to fall short; told, not judged.
};

/** What happens to it; the hand's places are relative to home. */
struct Excitation {
  const char* name;
  double start;  ///< Above home, as a part of StabilityPair::above.
  void (*excite)(ToolRig& rig, const StabilityPair& pair);
  bool airborne = false;  ///< Ends in the air.
};

inline constexpr double kDegreeRad = EIGEN_PI / 180;

inline std::vector<StabilityPair> stabilityPairs() {
  const Vec3 brick(0.03, 0.03, 0.03), wide(0.04, 0.03, 0.02), rod(0.01, 0.01, 0.04);
  return {
      {"brick on floor", boxCorners(brick), halfSpace(), brick, Vec3::Zero(), {0, 0, 0.015}},
      {"plate in bowl", boxCorners(wide), bowl(0.05), wide, Vec3::Zero(), {0, 0, -0.033}, 0.02},
      {"peg in hole", peg(0.005, 0.04, 5, 12), hole(0.0051, 0.06), rod},
      {"peg held deep", peg(0.005, 0.04, 5, 12), hole(0.0051, 0.06), rod, Vec3::Zero(), {0, 0, -0.01}, 0.03, false},
  };
}

inline std::vector<Excitation> excitations() {
  return {
      {"dropped", 1,
       [](ToolRig& rig, const StabilityPair&) {
         rig.tool().setTwist({{0.1, 0, -1}, {3, 1, 0}});
         rig.run(0.3);
       },
       true},
      {"pushed", 0.2,
       [](ToolRig& rig, const StabilityPair& pair) {
         rig.aim(pair.home + Vec3(0.01, 0.005, -0.045), Vec3(0.3, 0.2, 0));
         rig.run(0.3);
       }},
      {"jammed", 0.2,
       [](ToolRig& rig, const StabilityPair& pair) {
         rig.aim(pair.home + Vec3(0, 0, -0.005));
         rig.run(0.4);
         rig.aim(pair.home + Vec3(0.01, 0.004, -0.012), kDegreeRad * Vec3(10, 15, 20));
         rig.run(0.4);
       }},
      {"spun", 0.5,
       [](ToolRig& rig, const StabilityPair& pair) {
         rig.tool().setTwist({Vec3::Zero(), {40, 60, 10}});
         rig.aim(pair.home + Vec3(0, 0, -0.012));
         rig.run(0.4);
       }},
      {"hammered", 1,
       [](ToolRig& rig, const StabilityPair& pair) {
         for (int i = 0; i < 4; ++i) {
           rig.aim(pair.home + Vec3(0, 0, -0.045));
           rig.run(0.07);
           rig.aim(pair.home + Vec3(0, 0, pair.above), Vec3(0.1 * i, 0.2, 0));
           rig.run(0.07);
         }
         rig.aim(pair.home + Vec3(0, 0, -0.01));
         rig.run(0.1);
       }},
  };
}

/** What became of one run. */
struct StabilityOutcome {
  double created = 0;    ///< Most energy that a tick made of nothing [J].
  double strongest = 0;  ///< Force on the hand [N].
  ToolRig::Unrest unrest;
  bool finite = true;
};

/** Leaves the rig at rest, if it comes to rest. */
inline StabilityOutcome play(const StabilityPair& pair, const Excitation& what, double mass, ToolRig& rig) {
  rig.start(pair.home + Vec3(0, 0, what.start * pair.above));
  what.excite(rig, pair);
  rig.run(1.2 + (what.airborne ? 3 : 1.2) * mass);  // Two kilograms on a spring swing for long.
  const ToolRig::Unrest unrest = rig.watch(0.3);
  return {rig.created(), rig.strongest(), unrest, rig.finite()};
}

}  // namespace haptic_bench
