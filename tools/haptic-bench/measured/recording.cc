#include "tools/haptic-bench/measured/recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/measured/least_squares.h"
#include "tools/haptic-bench/trajectory/trajectory.h"

namespace haptic_bench {
namespace {

using Quat = Eigen::Quaterniond;

constexpr double kUnturned = 1e-6;  // Of the largest eigenvalue: the probe has not turned.
constexpr double kNoWeight = 0.05;  // [N]: what may seem to pull upwards where next to nothing hangs on the sensor.
constexpr double kSure = 5;         // Standard deviations.

struct PoseColumns {
  Table::Column p[3], q[4];

  [[nodiscard]] Pose at(const Table& table, std::size_t row) const {
    const Quat turn(q[0][row], q[1][row], q[2][row], q[3][row]);
    if (std::abs(turn.norm() - 1) > 0.01) {
      throw Failure(table.at(row), fmt::format("the quaternion has length {:.4g}", turn.norm()),
                    "unit, in the order w x y z");
    }
    const Vec3 place(p[0][row], p[1][row], p[2][row]);
    checkPosition(table, row, place);
    return {place, turn.normalized()};
  }
};

PoseColumns poseColumns(const Table& table, const std::string& prefix) {
  PoseColumns c;
  for (int i = 0; i < 3; ++i)
    c.p[i] = table.need(prefix + "xyz"[i] + (prefix.empty() ? std::string(" p") + "xyz"[i] : ""));
  for (int i = 0; i < 4; ++i) c.q[i] = table.need(prefix + "q" + "wxyz"[i]);
  return c;
}

/** Whether any of their columns is there: one that is misnamed must not make of a moving object one that stands. */
bool hasSome(const Table& table, const std::string& prefix) {
  const char* const names[] = {"x", "y", "z", "qw", "qx", "qy", "qz"};
  return std::any_of(std::begin(names), std::end(names),
                     [&](const char* name) { return static_cast<bool>(table.find(prefix + name)); });
}

/** Times as they stand, checked. */
std::vector<double> times(const Table& table, double max_gap_s) {
  std::vector<double> t_s = readTimes(table, 0, max_gap_s);
  const double first = table.need("t time")[0];
  for (double& t : t_s) t += first;
  return t_s;
}

/** Pose at time t, between poses[i] and poses[i + 1]. */
PoseSample between(const std::vector<PoseSample>& poses, std::size_t i, double t) {
  const PoseSample &a = poses[i], &b = poses[i + 1];
  const double h = b.t_s - a.t_s, u = (t - a.t_s) / h;
  // Slopes at a and b from their neighbours: a Catmull-Rom cubic for uneven times.
  const auto slope = [&](std::size_t k) -> Vec3 {
    const std::size_t before = k == 0 ? 0 : k - 1, after = std::min(k + 1, poses.size() - 1);
    return (poses[after].X_OS.p - poses[before].X_OS.p) / (poses[after].t_s - poses[before].t_s);
  };
  const double u2 = u * u, u3 = u2 * u;
  PoseSample out;
  out.t_s = t;
  out.X_OS.p = (2 * u3 - 3 * u2 + 1) * a.X_OS.p + (u3 - 2 * u2 + u) * h * slope(i) + (3 * u2 - 2 * u3) * b.X_OS.p +
               (u3 - u2) * h * slope(i + 1);
  out.X_OS.q = a.X_OS.q.slerp(u, b.X_OS.q);
  out.q_WO = a.q_WO.slerp(u, b.q_WO);
  return out;
}

/** Down, in the sensor's frame. */
Vec3 down_S(const PoseSample& pose) { return (pose.q_WO * pose.X_OS.q).conjugate() * -Vec3::UnitZ(); }

/** Goes along the poses as time rises. */
class PoseCursor {
 public:
  explicit PoseCursor(const std::vector<PoseSample>& poses) : poses_(poses) {}
  [[nodiscard]] bool covers(double t) const { return t >= poses_.front().t_s && t <= poses_.back().t_s; }
  PoseSample at(double t) {
    while (i_ + 2 < poses_.size() && poses_[i_ + 1].t_s < t) ++i_;
    return between(poses_, i_, t);
  }

 private:
  const std::vector<PoseSample>& poses_;
  std::size_t i_ = 0;
};

}  // namespace

Recording readRecording(const std::string& forces_path, const std::string& poses_path, double max_gap_s) {
  Recording recording;
  const Table forces = Table::read(forces_path, "");
  const std::vector<double> force_times = times(forces, max_gap_s);
  const Table::Column fx = forces.need("fx"), fy = forces.need("fy"), fz = forces.need("fz");
  for (std::size_t i = 0; i < forces.rows(); ++i) {
    recording.forces.push_back({force_times[i], {fx[i], fy[i], fz[i]}});
    checkForce(forces, i, recording.forces.back().f_S);
  }

  const Table poses = Table::read(poses_path, "");
  const std::vector<double> pose_times = times(poses, max_gap_s);
  const PoseColumns probe = poseColumns(poses, "");
  const bool object_moves = hasSome(poses, "object_");
  const PoseColumns object = object_moves ? poseColumns(poses, "object_") : PoseColumns{};
  for (std::size_t i = 0; i < poses.rows(); ++i) {
    const Pose X_WO = object_moves ? object.at(poses, i) : Pose{};
    recording.poses.push_back({pose_times[i], X_WO.inverse() * probe.at(poses, i), X_WO.q});
  }
  if (recording.poses.size() < 2) throw Failure(poses_path, "there is only one pose in it", "a recording");
  return recording;
}

double freeUntil(const Recording& recording, double free_s) { return recording.forces.front().t_s + free_s; }

ProbeLoad estimateLoad(const Recording& recording, double until_s) {
  // f = bias + weight * down, four unknowns.
  NormalMatrix normal = NormalMatrix::Zero(4, 4);
  Unknowns right = Unknowns::Zero(4);
  double squares = 0;
  int count = 0;
  PoseCursor poses(recording.poses);
  for (const ForceSample& f : recording.forces) {
    if (!poses.covers(f.t_s) || f.t_s >= until_s) continue;
    Eigen::Matrix<double, 3, 4> row;
    row << Eigen::Matrix3d::Identity(), down_S(poses.at(f.t_s));
    normal += row.transpose() * row;
    right += row.transpose() * f.f_S;
    squares += f.f_S.squaredNorm();
    ++count;
  }
  const auto [x, rank, inverse] = leastSquares(normal, right, kUnturned);
  const double variance = std::max(0.0, squares - x.dot(right)) / std::max(1, 3 * count - rank);
  if (rank == 4 && x[3] < -kNoWeight && x[3] < -kSure * std::sqrt(variance * inverse(3, 3))) {
    throw Failure("recording", fmt::format("in its free time {:.3g} N pull the probe upwards", -x[3]),
                  "forces on the probe: change their sign, or see the poses: z up, and the order w x y z");
  }
  return {x.head<3>(), x[3]};
}

ClockLag estimateLag(const Recording& recording, double until_s) {
  using Row = Eigen::Matrix<double, 3, 5>;
  // f(t) = bias + weight * down(t + lag), about the lag found so far.
  const std::vector<PoseSample>& poses = recording.poses;
  const double reach = (poses.back().t_s - poses.front().t_s) / static_cast<double>(poses.size() - 1) / 2;
  ClockLag found;
  constexpr int kRounds = 6;
  for (int round = 0; round < kRounds; ++round) {
    NormalMatrix normal = NormalMatrix::Zero(5, 5);
    Unknowns right = Unknowns::Zero(5);
    double squares = 0;
    int count = 0;
    PoseCursor before(poses), at(poses), after(poses);
    for (const ForceSample& f : recording.forces) {
      const double t = f.t_s + found.lag_s;
      if (f.t_s >= until_s || !before.covers(t - reach) || !after.covers(t + reach)) continue;
      const Vec3 turning = (down_S(after.at(t + reach)) - down_S(before.at(t - reach))) / (2 * reach);
      Row row;
      row << Eigen::Matrix3d::Identity(), down_S(at.at(t)), turning;
      normal += row.transpose() * row;
      right += row.transpose() * f.f_S;
      squares += f.f_S.squaredNorm();
      ++count;
    }
    const auto [x, rank, inverse] = leastSquares(normal, right, kUnturned);
    if (count < 2 || rank < 5 || x[3] == 0) return {};
    const double variance = std::max(0.0, squares - x.dot(right)) / (3 * count - 5);
    found.deviation_s = std::sqrt(variance * inverse(4, 4)) / std::abs(x[3]);
    found.lag_s += x[4] / x[3];
    if (std::abs(found.lag_s) > (until_s - recording.forces.front().t_s) / 2) return {};
  }
  return found;
}

std::vector<ProbeSample> merge(const Recording& recording, const MergeOptions& options, ProbeLoad* found) {
  const std::vector<ForceSample>& forces = recording.forces;
  const double both = std::max(forces.front().t_s, recording.poses.front().t_s);
  const double end = std::min(forces.back().t_s, recording.poses.back().t_s);
  const double until = freeUntil(recording, options.free_s), begin = std::max(both, until);
  if (!(end > begin) || (options.free_s > 0 && !(until > both))) {
    throw Failure("recording",
                  fmt::format("forces run from {} to {} s and poses from {} to {} s", forces.front().t_s,
                              forces.back().t_s, recording.poses.front().t_s, recording.poses.back().t_s),
                  "two streams on one clock, and a free time that both have, and more after it");
  }
  const double length = end - begin;
  if (!(length * options.rate_hz < kMaxSamples)) {
    throw Failure("recording", fmt::format("{:.3g} s at {:g} Hz are too many samples", length, options.rate_hz),
                  fmt::format("at most {:g}: name the column of times with its unit, as t_ns", kMaxSamples));
  }
  const ProbeLoad load = options.free_s > 0 ? estimateLoad(recording, until) : options.load;
  if (found != nullptr) *found = load;
  std::vector<ProbeSample> merged;
  PoseCursor poses(recording.poses);
  const double half = 0.5 / options.rate_hz;
  constexpr double kRounding = 1e-3;  // Of half a step: of seconds since 1970, a quarter of a microsecond.
  std::size_t next = 0;
  while (next < forces.size() && forces[next].t_s < begin) ++next;
  for (int i = 0;; ++i) {
    // Not by adding up steps: each would be rounded.
    const double t = begin + 2 * i * half;
    if (t > end + kRounding * half) break;
    Vec3 sum = Vec3::Zero();
    int count = 0;
    // Every force falls into one window. One with an edge of its own below would lose those that rounding puts between.
    const double edge = std::min(t + (1 - kRounding) * half, end + kRounding * half);
    for (; next < forces.size() && forces[next].t_s < edge; ++next, ++count) sum += forces[next].f_S;
    if (count == 0) continue;  // A stream slower than the result: the next sample has one.
    const PoseSample pose = poses.at(t);
    const Vec3 contact_S = sum / count - load.bias_S - load.weight * down_S(pose);
    merged.push_back({t, pose.X_OS * options.tip_S, pose.X_OS.q * contact_S});
  }
  if (merged.empty()) throw Failure("recording", "no instant has both force and pose", "a longer recording");
  return merged;
}

}  // namespace haptic_bench
