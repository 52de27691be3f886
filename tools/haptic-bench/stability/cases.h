/** @file
 * What is done to a tool that a hand holds, against which solid: dropped, pushed, jammed, spun and hammered.
 */
#pragma once

#include <algorithm>
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
  double patience = 0;         ///< So much longer than others it may take to come to rest [s].
};

inline constexpr double kRest = 80e-6;  ///< What is at rest moves less in 0.3 s: eight encoder steps [m].

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
  // Hammered, a peg may end on its rim beside the hole, leaned on by the hand: it waddles from corner to corner of the
  // rim until it stands or finds the hole.
  return {
      {"brick on floor", boxCorners(brick), halfSpace(), brick, Vec3::Zero(), {0, 0, 0.015}},
      {"plate in bowl", boxCorners(wide), bowl(0.05), wide, Vec3::Zero(), {0, 0, -0.033}, 0.02},
      {"peg in hole", peg(0.005, 0.04, 5, 12), hole(0.0051, 0.06), rod},
      {"peg held deep", peg(0.005, 0.04, 5, 12), hole(0.0051, 0.06), rod, Vec3::Zero(), {0, 0, -0.01}, 0.03, 60},
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
  double unrest = 0;     ///< Of device and tool, whichever moves more, in the last 0.3 s [m].
  double patience = 0;   ///< How much longer than others it took to come to rest [s].
  bool finite = true;
};

/** Leaves the rig at rest, if it comes to rest. */
inline StabilityOutcome play(const StabilityPair& pair, const Excitation& what, double mass, ToolRig& rig) {
  rig.start(pair.home + Vec3(0, 0, what.start * pair.above));
  what.excite(rig, pair);
  rig.run(1.2 + (what.airborne ? 3 : 1.2) * mass);  // Two kilograms on a spring swing for long.
  StabilityOutcome out;
  for (;; out.patience += 0.3) {
    const ToolRig::Unrest unrest = rig.watch(0.3);
    out.unrest = std::max(unrest.device, unrest.tool);
    if (out.unrest < kRest || out.patience >= pair.patience) break;
  }
  out.created = rig.created();
  out.strongest = rig.strongest();
  out.finite = rig.finite();
  return out;
}

}  // namespace haptic_bench
