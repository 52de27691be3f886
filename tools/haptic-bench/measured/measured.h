/** @file
 * From a measured recording to an out-trajectory on the mesh.
 */
#pragma once

#include <string>

#include "tools/haptic-bench/measured/recording.h"
#include "tools/haptic-bench/measured/registration.h"
#include "tools/haptic-bench/spec.h"
#include "tools/haptic-bench/trajectory/trajectory.h"

namespace haptic_bench {

struct MeasuredOptions {
  MergeOptions merge;
  double tip_radius = 0;        ///< [m]
  double contact_force = 0.05;  ///< More than this is contact [N].
  bool registered = false;      ///< The frames agree already.
  Pose first_guess;             ///< X_MO
  int points = 400;             ///< For the registration.
  double clock_s = 0;           ///< What has been added to the times of the recording's poses.
};

/** An out-trajectory and how it came about. */
struct Measured {
  /** From the first contact to the last: point and force along the normal. In the air between, where the ball's
   * surface is nearest to the mesh, without force. */
  std::vector<SurfaceSample> out;
  ProbeLoad load;      ///< Taken off the forces.
  ClockLag lag;        ///< As the free time shows it; not taken off.
  double clock_s = 0;  ///< That of the options.
  double pose_step_s = 0;
  int contacts = 0;  ///< Samples of `out` in contact.
  int points = 0;    ///< Of them, those registered; 0: the frames agreed already.
  Registration registration;
};

/** One line by which the user sees whether it went well: what was taken off, and how near the points lie. */
[[nodiscard]] std::string describe(const Measured& measured);

/**
 * Merges, compensates, registers, and moves each contact from the ball's centre to the surface, against the mesh's
 * normal there. Throws Failure when there is too little contact, or when it lies nowhere near the mesh.
 */
[[nodiscard]] Measured onSurface(const Recording& recording, const MeasuredOptions& options, const Model& model);

/** The settings of "measured:forces=F.csv,poses=P.csv,...". Says on the standard error how it went. */
[[nodiscard]] std::vector<SurfaceSample> readMeasured(Spec& spec, const Model& model);

}  // namespace haptic_bench
