#include "tools/haptic-bench/measured/registration.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/measured/least_squares.h"

namespace haptic_bench {
namespace {

constexpr int kFreeRounds = 50;         // Then the steps fade ...
constexpr double kFading = 0.8;         // ... by this in each.
constexpr double kOpen = 0.5;           // Of the rms: the step that may be wanted still when they have.
constexpr double kUnmoved = 1e-9;       // Of the points' extent.
constexpr double kUndetermined = 0.02;  // Of the largest singular value.

struct Match {
  Vec3 x, normal;   ///< Point in the mesh's frame, and the direction in which its distance is measured.
  double miss = 0;  ///< Distance to where it should be, along the normal [m].
};

std::vector<Match> matchAll(const TreeNearest& surface, const std::vector<Vec3>& points, double offset,
                            const Pose& X_MO) {
  std::vector<Match> all;
  for (const Vec3& p : points) {
    const Vec3 x = X_MO * p;
    const SurfacePoint at = surface.find(x);
    // Along the line to the nearest point: right at edges too.
    all.push_back({x, at.outward(x), (at.inside ? -at.distance : at.distance) - offset});
  }
  return all;
}

}  // namespace

Registration registerPoints(const TreeNearest& surface, const std::vector<Vec3>& points, double offset,
                            const Pose& first_guess, int max_rounds) {
  if (points.size() < 6)
    throw Failure("registration", fmt::format("{} points are too few", points.size()), "at least 6 in contact");
  Registration r;
  r.X_MO = first_guess;
  Vec3 lower = points[0], upper = points[0];
  for (const Vec3& p : points) lower = lower.cwiseMin(p), upper = upper.cwiseMax(p);
  const double extent = std::max((upper - lower).norm(), 1e-9);
  Eigen::Matrix<double, 6, 1> before = Eigen::Matrix<double, 6, 1>::Zero();
  double share = 1;  // Of a step that is taken.
  double most = 1;
  for (r.rounds = 1; r.rounds <= max_rounds; ++r.rounds) {
    const std::vector<Match> matches = matchAll(surface, points, offset, r.X_MO);
    std::vector<double> misses;
    misses.reserve(matches.size());
    for (const Match& m : matches) misses.push_back(std::abs(m.miss));
    std::sort(misses.begin(), misses.end());
    r.most = misses[3 * misses.size() / 4];
    const double limit = 3 * misses[misses.size() / 2] + kUnmoved * extent;

    // A small turn w about the points' middle and a shift: (c x n) . w + n . shift = -miss; lengths in extents.
    const Vec3 middle = r.X_MO * Vec3((lower + upper) / 2);
    NormalMatrix normal = NormalMatrix::Zero(6, 6);
    Unknowns right = Unknowns::Zero(6);
    double sum = 0;
    int used = 0;
    for (const Match& m : matches) {
      if (std::abs(m.miss) > limit) continue;
      Eigen::Matrix<double, 6, 1> row;
      row << ((m.x - middle) / extent).cross(m.normal), m.normal;
      normal += row * row.transpose();
      right -= row * m.miss;
      sum += m.miss * m.miss;
      ++used;
    }
    r.rms = std::sqrt(sum / used);
    r.left_out = static_cast<int>(points.size()) - used;
    auto [step, freedoms, inverse] = leastSquares(normal, right, kUndetermined * kUndetermined);
    r.freedoms = freedoms;
    // Nearest triangles and points left out change with the pose, and so may lead to and fro for ever: half way then.
    // Or in a wider ring, where each step turns a little: less and less then.
    if (r.rounds > kFreeRounds) most *= kFading;
    share = std::min(most, step.dot(before) < 0 ? share / 2 : 2 * share);
    before = step;
    const double wanted = step.norm();
    step *= share;
    const Vec3 turn = step.head<3>() / extent, shift = step.tail<3>();
    const Eigen::Quaterniond q = turn.norm() > 0 ? Eigen::Quaterniond(Eigen::AngleAxisd(turn.norm(), turn.normalized()))
                                                 : Eigen::Quaterniond::Identity();
    r.X_MO = Pose{middle + shift - q * middle, q} * r.X_MO;
    if (step.norm() >= kUnmoved * extent) continue;
    r.settled = r.rounds <= kFreeRounds || wanted < std::max(kUnmoved * extent, kOpen * r.rms);
    break;
  }
  return r;
}

}  // namespace haptic_bench
