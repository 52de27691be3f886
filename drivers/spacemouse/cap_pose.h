/** @file
 * From the deflection of a SpaceMouse's cap to the pose of a tool.
 */
#pragma once

#include "drivers/spacemouse/spacemouse_parameters.h"
#include "drivers/spacemouse/spacemouse_protocol.h"
#include "rt/base/math.h"

namespace hapticd {

/** Deflection in hapticd's frame (x toward the operator, y right, z up), full is 1 along an axis. */
struct CapDeflection {
  Vec3 shift = Vec3::Zero();
  Vec3 turn = Vec3::Zero();  ///< Rotation vector.
};
/** With the dead zone taken off, so that it begins from zero beyond it. */
[[nodiscard]] CapDeflection capDeflection(const spacemouse::State& state, double dead_zone) HD_RT;

/**
 * The tool that the cap moves. displacement: it is where the cap is pushed to, and back in the middle when let go.
 * rate: it goes on as fast as the cap is pushed, within a box, and stays when let go.
 */
class CapPose {
 public:
  explicit CapPose(const SpaceMouseParameters& parameters) noexcept
      : rate_(parameters.mode == "rate"), parameters_(parameters) {}

  /** The pose `dt` seconds on, the cap having stood as it stands now. */
  void step(const CapDeflection& cap, double dt) HD_RT;
  void reset() HD_RT { pose_ = Pose{}; }
  [[nodiscard]] const Pose& pose() const HD_RT { return pose_; }

 private:
  bool rate_;
  SpaceMouseParameters parameters_;
  Pose pose_;
};

}  // namespace hapticd
