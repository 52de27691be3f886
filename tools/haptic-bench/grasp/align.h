/** @file
 * A block is let turn between two fingers until it stands like another one, at 30 or 60 degrees (thesis section 2.3.6,
 * figures 2.24, 2.25): how far is it off in the end, and how far has it slid?
 */
#pragma once

#include <vector>

#include "tools/haptic-bench/grasp/rig.h"

namespace haptic_bench::grasp {

struct Attempt {
  double mass;  ///< [kg]
  int person;
  double off = 0;   ///< By how much it is turned too far; of one that is lost, back by all [rad].
  double slid = 0;  ///< [m]
  bool lost = false;
};

/** One lever, condition and angle wanted. */
struct Alignment {
  bool coupled;
  double lever;   ///< [m]
  double wanted;  ///< [rad]
  std::vector<Attempt> attempts{};

  /** Median of how far it was off, whichever way [rad]. */
  [[nodiscard]] double error() const;
  /** Median [m]. */
  [[nodiscard]] double slid() const;
  [[nodiscard]] int lost() const;
};

/**
 * Bars of 0.05, 0.1 and 0.2 kg, by each of `persons`: who opens the fingers until the block turns, lets it turn by some
 * 40 degrees a second, and closes when it is about to be where it is wanted. Sees what was 0.2 s ago.
 */
[[nodiscard]] std::vector<Alignment> alignments(int persons, double unsteady);

}  // namespace haptic_bench::grasp
