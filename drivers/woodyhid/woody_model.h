/** @file
 * The WoodenHaptics and Polhem family: one table of what each model is made of.
 *
 * Figures: forsslund/haptikfabrikenapi at b8d6c944 (src/haptikfabrikenapi.h) and, for the links of the five-bar,
 * forsslund/hfabapi at cf00e976. SI, angles in rad, encoders in counts.
 */
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "rt/base/math.h"

namespace hapticd {

/** Body B and C on one shoulder (WoodenHaptics, Polhem 1), or each with a motor of its own and a bar between (Polhem
 * 3). */
enum class WoodyLinkage : std::uint8_t { kSerial, kFiveBar };

/** Links of the five-bar [m]: the motors are L0 apart; L1 and L2 turn with them; L3 joins L2 to the forearm L4 + L5. */
struct FiveBarLinks {
  double L0 = 0, L1 = 0, L2 = 0, L3 = 0, L4 = 0, L5 = 0;
};

/** A link's mass and where its centre lies, along and across the link, from its inner joint [kg, m]. */
struct LinkMass {
  double mass = 0, along = 0, across = 0;
};

struct WoodyModel {
  std::string_view name, title;
  WoodyLinkage linkage = WoodyLinkage::kSerial;
  Vec3 capstan = Vec3::Zero();  ///< Diameters of the motors' capstans, for bodies A, B, C.
  Vec3 body = Vec3::Zero();     ///< Diameters of the bodies they turn.
  double La = 0, Lb = 0, Lc = 0;
  FiveBarLinks bars;
  Vec3 origin = Vec3::Zero();           ///< Of the workspace, from the base.
  Vec3 torque_constant = Vec3::Zero();  ///< [N m/A]
  double counts_per_turn = 0;           ///< Of the motors' encoders, quadrature counted.
  double gimbal_counts_per_turn = 0;    ///< 0: no gimbal.
  double max_force = 0, max_stiffness = 0, max_damping = 0;
  std::array<std::int16_t, 6> calibration{};  ///< What the encoders read in the pose of calibration.
  std::array<bool, 3> aligned{};              ///< Motor and body turn the same way round.
  /** Links that hang: B and C; of the five-bar the links 1, 2, 3 and the forearm. */
  std::array<LinkMass, 4> masses{};
};

[[nodiscard]] std::span<const WoodyModel> woodyModels();
/** Null if there is none of that name. */
[[nodiscard]] const WoodyModel* findWoodyModel(std::string_view name);

}  // namespace hapticd
