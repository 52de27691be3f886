/** @file
 * Where the simulated hand wants to be: built-in motions, a recording, or what a client says.
 */
#pragma once

#include <memory>
#include <string_view>

#include "drivers/pose_track.h"
#include "rt/device.h"

namespace hapticd {

/** Kinds of intended motion, by the names of the query key `motion`. */
enum class MotionKind : std::uint8_t { kLive, kHold, kTap, kStroke, kCircle, kLissajous, kMinJerk, kCsv };
inline constexpr std::string_view kMotionNames = "live|hold|tap|stroke|circle|lissajous|minjerk|csv";
/** The kind of that name; `name` must be one of kMotionNames. */
[[nodiscard]] MotionKind motionKind(std::string_view name) noexcept;

/** What the motion is made of; each kind uses its own part. Lengths in m, times in s, angles in rad. */
struct MotionParameters {
  MotionKind kind = MotionKind::kLive;
  Vec3 centre = Vec3::Zero();
  double period = 2;
  double wait = 0;  ///< Before it starts; the hand holds the first pose.
  // tap
  Vec3 direction = Vec3(0, 0, -1);
  double depth = 0.02;
  // stroke
  Vec3 from = Vec3(0, -0.03, 0), to = Vec3(0, 0.03, 0);
  // circle
  double radius = 0.03;
  Vec3 normal = Vec3::UnitZ();
  // lissajous
  Vec3 amplitude = Vec3(0.02, 0.03, 0), ratio = Vec3(3, 2, 1), phase = Vec3::Zero();
  // minjerk
  Vec3 box_lower = Vec3::Constant(-0.03), box_upper = Vec3::Constant(0.03);
  std::uint64_t seed = 1;
  double tremor = 0;  ///< Peak per axis; added to every kind but live and csv.
  // rotation, all but csv
  Vec3 orientation = Vec3::Zero();  ///< Rotation vector.
  Vec3 sway = Vec3::Zero();         ///< Rotation vector swung through about it, once a period.
  double gripper_angle = 0.2;
  // csv
  std::shared_ptr<const PoseTrack> track;
  bool loop = false;
};

/** An intended motion: a function of simulated time alone, but for kLive. Real-time safe but for the constructor. */
class IntendedMotion {
 public:
  explicit IntendedMotion(const MotionParameters& parameters);

  [[nodiscard]] PoseOnTrack at(double t_s) const HD_RT;
  /** For kLive: the pose held from now on, at rest. Ignored by other kinds, and where it is not finite or beyond 10 m.
   */
  void setLive(const DeviceIntent& intent) HD_RT;

 private:
  static constexpr int kTremorTones = 3;

  void path(double t_s, PoseOnTrack& out) const HD_RT;
  void minimumJerk(double t_s, PoseOnTrack& out) const HD_RT;
  void addTremor(double t_s, PoseOnTrack& out) const HD_RT;
  [[nodiscard]] Vec3 target(std::uint64_t n) const HD_RT;

  MotionParameters parameters_;
  Quat orientation_;
  Vec3 circle_u_, circle_v_;  ///< Orthonormal, in the plane of the circle.
  double tone_rate_[3][kTremorTones], tone_phase_[3][kTremorTones];
  PoseOnTrack live_;
};

}  // namespace hapticd
