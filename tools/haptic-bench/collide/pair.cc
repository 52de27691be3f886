#include "tools/haptic-bench/collide/pair.h"

#include <algorithm>
#include <cmath>

#include "tools/haptic-bench/collide/shapes.h"
#include "tools/haptic-bench/failure.h"

namespace haptic_bench {
namespace {

using hapticd::Pose;
using hapticd::Quat;

constexpr double kMm = 1e-3;
constexpr double kPairApproach = 0.5;  // [s]
constexpr double kDuration = 2;        // [s]
constexpr double kTurn = 2 * EIGEN_PI;
constexpr double kDegree = EIGEN_PI / 180;

/** From a to b over the approach, gently at both ends. */
double approach(double t, double a, double b) {
  const double s = std::clamp(t / kPairApproach, 0.0, 1.0);
  return a + (b - a) * s * s * (3 - 2 * s);
}

Quat about(const Vec3& axis, double angle) { return Quat(Eigen::AngleAxisd(angle, axis.normalized())); }

Pose bumpyPose(double t) {
  const double s = t - kPairApproach;
  const double distance = approach(t, 125, 97) + (s > 0 ? std::sin(kTurn * 3 * s) : 0);
  const double a = 0.25 * std::sin(kTurn * 0.8 * s);
  return {kMm * Vec3(distance * std::sin(a), 2 * std::sin(kTurn * 0.6 * t), distance * std::cos(a)),
          about({1, 2, 3}, 0.8 * t + 0.4 * std::sin(kTurn * 0.7 * t))};
}

Pose pegPose(double t) {
  const double s = t - kPairApproach;
  const double depth = approach(t, 20, -15) + (s > 0 ? 2 * std::sin(kTurn * 1.3 * s) : 0);
  return {kMm * Vec3(0.12 * std::cos(kTurn * t), 0.12 * std::sin(kTurn * t), depth),
          about(Vec3::UnitX(), 0.2 * kDegree * std::sin(kTurn * 1.1 * t))};
}

Pose fracturePose(double t) {
  const double s = t - kPairApproach;
  const double overlap = s > 0 ? 0.05 + 0.025 * (1 - std::cos(kTurn * 2 * s)) : 0.05 * approach(t, 0, 1);
  const double x = 0.3 * std::sin(kTurn * 1.1 * s), y = 0.3 * std::sin(kTurn * 0.7 * s);
  const Quat slide = about(Vec3::UnitZ(), 0.5 * kDegree * std::sin(kTurn * 0.9 * s));
  const Quat tilt = about(Vec3(1, 1, 0), 0.2 * kDegree * std::sin(kTurn * 1.3 * s));
  return {kMm * Vec3(x, y, approach(t, 20, 0) - overlap), slide * tilt};
}

}  // namespace

std::vector<Pose> CollidePair::poses(double rate_hz) const {
  std::vector<Pose> all;
  const auto count = static_cast<int>(duration * rate_hz);
  all.reserve(static_cast<std::size_t>(std::max(count, 0)));
  for (int i = 0; i < count; ++i) all.push_back(pose(i / rate_hz));
  return all;
}

CollidePair makePair(const std::string& name) {
  CollidePair pair;
  pair.name = name;
  pair.contact_from = kPairApproach;
  pair.duration = kDuration;
  if (name == "bumpy") {
    pair.base = pair.tool = bumpyBall();
    pair.voxel = 0.5 * kMm;
    pair.pose = bumpyPose;
  } else if (name == "peg") {
    pair.base = plateWithHole();
    pair.tool = peg();
    pair.voxel = 0.25 * kMm;
    pair.pose = pegPose;
  } else if (name == "frac") {
    pair.base = fractureHalf(false);
    pair.tool = fractureHalf(true);
    pair.voxel = 0.25 * kMm;
    pair.pose = fracturePose;
  } else {
    throw Failure(name, "no such pair", "bumpy, peg or frac");
  }
  return pair;
}

}  // namespace haptic_bench
