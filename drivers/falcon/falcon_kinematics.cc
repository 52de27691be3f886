#include "drivers/falcon/falcon_kinematics.h"

#include <cmath>
#include <numbers>

namespace hapticd::falcon {
namespace {

// [m]
constexpr double kA = 0.060, kB = 0.1025, kC = 0.01443, kDE = 0.0225, kF = -0.025, kR = 0.0400, kS = -0.02309;
constexpr double kRadPerDegree = std::numbers::pi / 180;
constexpr double kCountsPerDegree = 27.446;  // 1280 a turn, times 110 mm / 14.25 mm
constexpr double kRest = 35 * kRadPerDegree;
/** cos and sin of where each leg stands about z. */
const std::array<std::array<double, 2>, 3> kAzimuth = [] {
  std::array<std::array<double, 2>, 3> out{};
  const std::array<double, 3> degrees{90 + 15, -30 + 15, -150 + 15};
  for (std::size_t i = 0; i < 3; ++i)
    out[i] = {std::cos(degrees[i] * kRadPerDegree), std::sin(degrees[i] * kRadPerDegree)};
  return out;
}();

std::optional<Leg> legAt(const Vec3& p, std::size_t i) noexcept {
  const auto [cosine, sine] = kAzimuth[i];
  const double across = p.x() * cosine + p.y() * sine - kR + kC;  // u + c
  const double side = -p.x() * sine + p.y() * cosine - kS + kF;   // v + f
  const double out = p.z();                                       // w
  if (!(std::abs(side) < kB)) return {};
  Leg leg;
  leg.t3 = std::acos(side / kB);
  const double reach = kDE + kB * std::sin(leg.t3);
  const double k = across * across + out * out + kA * kA - reach * reach;
  // With the tangent of half the angle the loop is l2 t^2 + l1 t + l0 = 0; the elbow points outward.
  const double l0 = k - 2 * kA * across, l1 = -4 * kA * out, l2 = k + 2 * kA * across;
  const double inside = l1 * l1 - 4 * l0 * l2;
  if (!(inside > 0) || out <= 0) return {};
  // The root in the form that stays well when l2 passes zero, as it does in the workspace.
  leg.t1 = 2 * std::atan(2 * l0 / (-l1 + std::sqrt(inside)));
  leg.t2 = std::atan2(out - kA * std::sin(leg.t1), across - kA * std::cos(leg.t1));
  return leg;
}

Vec3 anglesOf(const std::array<Leg, 3>& legs) noexcept { return {legs[0].t1, legs[1].t1, legs[2].t1}; }

}  // namespace

std::optional<std::array<Leg, 3>> legsAt(const Vec3& p) noexcept {
  std::array<Leg, 3> legs;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto leg = legAt(p, i);
    if (!leg) return {};
    legs[i] = *leg;
  }
  return legs;
}

Mat3 jacobian(const std::array<Leg, 3>& legs) noexcept {
  Mat3 rows;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto [cosine, sine] = kAzimuth[i];
    const Leg& leg = legs[i];
    const double c2 = std::cos(leg.t2), s3 = std::sin(leg.t3), c3 = std::cos(leg.t3);
    const double scale = -1 / (kA * s3 * std::sin(leg.t1 - leg.t2));
    // The last is sin t2 sin t3; with sin^2 t2, as in libnifalcon, the force along z is 30 % too large.
    rows.row(static_cast<Eigen::Index>(i)) =
        scale * Vec3(cosine * c2 * s3 - sine * c3, sine * c2 * s3 + cosine * c3, std::sin(leg.t2) * s3).transpose();
  }
  return rows;
}

namespace {

/**
 * From p. A step that leads out of reach, or farther from the angles, is halved until it does not: where an arm is
 * nearly stretched its angle goes like a square root, and full steps would swing about the place for ever.
 */
std::optional<Grip> solvedFrom(Vec3 p, const Vec3& t1) noexcept {
  constexpr double kFar = 0.02;  // [m] in one step
  constexpr int kHalvings = 8;
  auto legs = legsAt(p);
  for (int step = 0; legs && step < kMostSteps; ++step) {
    const Mat3 rows = jacobian(*legs);
    const Vec3 missing = t1 - anglesOf(*legs);
    Vec3 move = rows.fullPivLu().solve(missing);
    if (!move.allFinite()) return {};
    if (move.norm() < 1e-10) return Grip{p, rows};
    move = clampNorm(move, kFar);
    for (int halving = 0;; ++halving) {
      legs = legsAt(p + move);
      if (halving == kHalvings || (legs && (t1 - anglesOf(*legs)).norm() < missing.norm())) break;
      move *= 0.5;
    }
    p += move;
  }
  return {};
}

}  // namespace

std::optional<Grip> gripAt(const Vec3& t1, const Vec3& guess) noexcept {
  if (!t1.allFinite() || !guess.allFinite()) return {};
  const auto grip = solvedFrom(guess, t1);
  return grip ? grip : solvedFrom(kMiddle, t1);
}

double anglePerCount() noexcept { return kRadPerDegree / kCountsPerDegree; }
double armAngle(double counts) noexcept { return kRest + counts * anglePerCount(); }

std::optional<Vec3> torquesFor(const Mat3& dt1_dp, const Vec3& f) noexcept {
  // Virtual work: f . dp = torque . dt1, so f = (dt1/dp)^T torque.
  const Mat3 transposed = dt1_dp.transpose();
  const double determinant = transposed.determinant();
  constexpr double kFlat = 1.0;  // [1/m^3]; some thousands in the workspace
  if (!(std::abs(determinant) > kFlat) || !f.allFinite()) return {};
  const Vec3 torques = transposed.inverse() * f;
  if (!torques.allFinite()) return {};
  return torques;
}

bool limitTogether(Vec3& torques, double limit) noexcept {
  const double largest = torques.cwiseAbs().maxCoeff();
  if (largest <= limit) return false;
  torques *= limit / largest;
  return true;
}

}  // namespace hapticd::falcon
