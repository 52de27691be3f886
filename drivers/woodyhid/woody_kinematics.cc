#include "drivers/woodyhid/woody_kinematics.h"

#include <cmath>

namespace hapticd {
namespace {

constexpr double kTau = 6.283185307179586;
constexpr double kGravity = 9.81;  // [m/s^2]

/** A point of the arm's own plane, r outward and z up, with its derivatives by the angles of B and C. */
struct Planar {
  double r = 0, z = 0;
  double r_b = 0, r_c = 0, z_b = 0, z_c = 0;
};

Planar operator+(const Planar& a, const Planar& b) HD_RT {
  return {a.r + b.r, a.z + b.z, a.r_b + b.r_b, a.r_c + b.r_c, a.z_b + b.z_b, a.z_c + b.z_c};
}

/** The vector (along, across) of a link at angle t from the horizontal, where t moves by t_b and t_c with B and C. */
Planar link(double along, double across, double t, double t_b, double t_c) HD_RT {
  const double c = std::cos(t), s = std::sin(t);
  const double r = along * c - across * s, z = along * s + across * c;
  return {r, z, -z * t_b, -z * t_c, r * t_b, r * t_c};
}

WoodyArm turned(const WoodyModel& model, const Planar& tip, double a) HD_RT {
  const double c = std::cos(a), s = std::sin(a);
  WoodyArm arm;
  arm.reachable = true;
  arm.p = Vec3(c * tip.r, s * tip.r, tip.z) - model.origin;
  arm.jacobian << -s * tip.r, c * tip.r_b, c * tip.r_c,  //
      c * tip.r, s * tip.r_b, s * tip.r_c,               //
      0, tip.z_b, tip.z_c;
  return arm;
}

void carry(const LinkMass& mass, const Planar& centre, Vec3& torque) HD_RT {
  torque += kGravity * mass.mass * Vec3(0, centre.z_b, centre.z_c);
}

WoodyArm solveSerial(const WoodyModel& m, const Vec3& angles) HD_RT {
  // B leans from the vertical by its angle; C hangs at its angle from below: from the horizontal 90 - B and C - 90
  // degrees.
  const double b = kTau / 4 - angles[1], c = angles[2] - kTau / 4;
  Planar shoulder;
  shoulder.z = m.La;
  const Planar elbow = shoulder + link(m.Lb, 0, b, -1, 0);
  WoodyArm arm = turned(m, elbow + link(m.Lc, 0, c, 0, 1), angles[0]);
  arm.pitch = c;
  const LinkMass &mb = m.masses[0], &mc = m.masses[1];
  carry(mb, shoulder + link(mb.along, mb.across, b, -1, 0), arm.gravity_torque);
  carry(mc, elbow + link(mc.along, mc.across, c, 0, 1), arm.gravity_torque);
  return arm;
}

WoodyArm solveFiveBar(const WoodyModel& m, const Vec3& angles) HD_RT {
  const FiveBarLinks& L = m.bars;
  Planar motor_b, motor_c;
  motor_b.r = L.L0 / 2;
  motor_c.r = -L.L0 / 2;
  const Planar elbow = motor_b + link(L.L1, 0, angles[1], 1, 0);
  const Planar crank = motor_c + link(L.L2, 0, angles[2], 0, 1);
  // The forearm goes on from the elbow at the pitch whose other end, L4 behind it, is L3 from the crank's end:
  // |w - L4 u|^2 = L3^2 with w from crank to elbow, the solution below w.
  const double wr = elbow.r - crank.r, wz = elbow.z - crank.z;
  const double d = std::hypot(wr, wz);
  const double cosine = (d * d + L.L4 * L.L4 - L.L3 * L.L3) / (2 * d * L.L4);
  if (!(std::abs(cosine) < 1)) return {};
  const double pitch = std::atan2(wz, wr) - std::acos(cosine);
  const double ur = std::cos(pitch), uz = std::sin(pitch);
  const double kr = wr - L.L4 * ur, kz = wz - L.L4 * uz;  // the bar L3
  // Its length stays: k.(dw - L4 u' dpitch) = 0.
  const double turn = L.L4 * (-kr * uz + kz * ur);
  if (!(std::abs(turn) > 1e-9)) return {};
  const double pitch_b = (kr * elbow.r_b + kz * elbow.z_b) / turn;
  const double pitch_c = -(kr * crank.r_c + kz * crank.z_c) / turn;

  WoodyArm arm = turned(m, elbow + link(L.L5, 0, pitch, pitch_b, pitch_c), angles[0]);
  arm.pitch = pitch;
  // The bar's own angle: its ends move as crank and forearm do.
  const double bar = std::atan2(kz, kr);
  const double kk = kr * kr + kz * kz;
  const auto turns = [&](double dr, double dz) noexcept { return (kr * dz - kz * dr) / kk; };
  const double bar_b = turns(elbow.r_b + L.L4 * uz * pitch_b, elbow.z_b - L.L4 * ur * pitch_b);
  const double bar_c = turns(-crank.r_c + L.L4 * uz * pitch_c, -crank.z_c - L.L4 * ur * pitch_c);
  const auto& g = m.masses;
  carry(g[0], motor_b + link(g[0].along, g[0].across, angles[1], 1, 0), arm.gravity_torque);
  carry(g[1], motor_c + link(g[1].along, g[1].across, angles[2], 0, 1), arm.gravity_torque);
  carry(g[2], crank + link(g[2].along, g[2].across, bar, bar_b, bar_c), arm.gravity_torque);
  carry(g[3], elbow + link(g[3].along, g[3].across, pitch, pitch_b, pitch_c), arm.gravity_torque);
  return arm;
}

}  // namespace

Vec3 woodyAngles(const WoodyModel& model, const std::array<std::int32_t, 6>& encoder) HD_RT {
  Vec3 angles;
  for (int i = 0; i < 3; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double turn = kTau * encoder[k] / model.counts_per_turn * model.capstan[i] / model.body[i];
    angles[i] = model.aligned[k] ? -turn : turn;
  }
  return angles;
}

WoodyArm solveWoodyArm(const WoodyModel& model, const Vec3& angles) HD_RT {
  if (!isFinite(angles)) return {};
  return model.linkage == WoodyLinkage::kSerial ? solveSerial(model, angles) : solveFiveBar(model, angles);
}

Quat woodyOrientation(const WoodyModel& model, const Vec3& angles, double pitch,
                      const std::array<std::int32_t, 6>& encoder) HD_RT {
  using Eigen::AngleAxisd;
  if (model.gimbal_counts_per_turn <= 0) return Quat::Identity();
  // The firmware counts the gimbal against its bodies.
  const auto gimbal = [&](std::size_t i) noexcept { return -kTau * encoder[i] / model.gimbal_counts_per_turn; };
  return Quat(AngleAxisd(angles[0], Vec3::UnitZ())) * Quat(AngleAxisd(-pitch, Vec3::UnitY())) *
         Quat(AngleAxisd(gimbal(3), Vec3::UnitX())) * Quat(AngleAxisd(gimbal(4), Vec3::UnitY())) *
         Quat(AngleAxisd(gimbal(5), Vec3::UnitX()));
}

Vec3 forceForTorque(const WoodyArm& arm, const Vec3& torque, double limit) HD_RT {
  if (!arm.reachable) return Vec3::Zero();
  // J^T f = torque by cofactors.
  const Mat3 a = arm.jacobian.transpose();
  const Vec3 bc = a.row(1).cross(a.row(2)), ca = a.row(2).cross(a.row(0)), ab = a.row(0).cross(a.row(1));
  const double determinant = a.row(0).dot(bc);
  const Vec3 times = bc * torque[0] + ca * torque[1] + ab * torque[2];
  if (!(std::abs(determinant) * limit > times.norm()))
    return clampNorm(times * (determinant < 0 ? -1e12 : 1e12), limit);
  return times / determinant;
}

WoodyCurrents woodyCurrents(const WoodyModel& model, const WoodyArm& arm, const Vec3& force, double limit_A) HD_RT {
  WoodyCurrents out;
  Vec3 current = arm.jacobian.transpose() * force;
  for (int i = 0; i < 3; ++i) {
    current[i] *= model.capstan[i] / model.body[i] / model.torque_constant[i];
    if (model.aligned[static_cast<std::size_t>(i)]) current[i] = -current[i];
  }
  const double most = current.cwiseAbs().maxCoeff();
  if (!arm.reachable || !isFinite(current)) return out;
  out.saturated = most > limit_A;
  const double scale = out.saturated ? limit_A / most : 1.0;
  for (int i = 0; i < 3; ++i) {
    // Toward zero: rounding must not pass the limit.
    out.mA[static_cast<std::size_t>(i)] = static_cast<std::int16_t>(std::trunc(1000 * scale * current[i]));
  }
  return out;
}

}  // namespace hapticd
