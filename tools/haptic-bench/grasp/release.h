/** @file
 * A block held off its centre of mass is let go, ever more (thesis section 2.3.6, figures 2.19 to 2.23): does it turn
 * between the fingers, or slide through them? With friction of sliding and turning coupled (condition A) and not (B).
 */
#pragma once

#include <functional>
#include <vector>

#include "tools/haptic-bench/grasp/rig.h"

namespace haptic_bench::grasp {

/** Friction of an index fingertip on sandpaper (table 2.3); sliding, what goes with 1.2 in the thesis's cubes. */
inline constexpr double kSandpaper = 1.67, kSandpaperSliding = 1.53;
inline constexpr double kSandpaperArm = 6.05e-3;  ///< mu_r / mu_l: the lever L_0 at which both yield alike [m].

/** The fingers of these experiments: an arm that does not hang on the force, so that closed forms tell what yields. */
[[nodiscard]] hapticd::SetFinger fingerOf(bool coupled, double arm, double stiffness);
/** A bar of sandpaper, 120 mm long, that is held `lever` from its centre of mass. */
[[nodiscard]] Block barOf(double mass, double lever);
/** How hard each finger presses when the bar first yields [N], which hangs turned by so much [rad]: docs/grasping.md.
 */
[[nodiscard]] double yieldsAt(const Block& block, bool coupled, double arm, double turned);

struct Release {
  bool coupled;
  double arm;                       ///< L_0 [m]
  double lever;                     ///< L [m]
  double closed = 0;                ///< yieldsAt() [N]
  double yields = 0;                ///< Seen [N]
  double slid_10 = 0, slid_30 = 0;  ///< How far it had slid when it had turned by 10 and 30 degrees [m]; nan: never.
  double turned_5 = 0;              ///< How far it had turned when it had slid by 5 mm [rad]; nan: never.
};

/** One tick of a release. */
struct Moment {
  double t, y, z;  ///< Of the centre of mass [s, m],
  double turned;   ///< and about the line between the fingers [rad].
  double slid;     ///< Of the fingertips across the block [m].
  double grip;     ///< [N]
};
using Watch = std::function<void(const Release&, const Moment&)>;

/** Steady hands, which open by a tenth of their depth in a second, until the bar has slid by 20 mm or turned by 60
 * degrees. */
[[nodiscard]] Release letGo(bool coupled, double arm, double lever, const Watch& watch = {});
/** Both conditions, on both sides of L_0, for sandpaper and for a finger three times as wide. */
[[nodiscard]] std::vector<Release> releases(const Watch& watch = {});

}  // namespace haptic_bench::grasp
