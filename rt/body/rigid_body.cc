#include "rt/body/rigid_body.h"

#include <Eigen/Eigenvalues>

#include "rt/base/rotation.h"

namespace hapticd {
namespace {

double spin(const Vec3& momentum, const Vec3& moments) HD_RT {
  return 0.5 * momentum.cwiseProduct(momentum).cwiseQuotient(moments).sum();
}

/** One factor of the splitting: the free motion under the energy m_i^2 / (2 I_i) alone, exact. */
void turnAbout(int i, double dt, const Vec3& moments, Vec3& momentum, Quat& q) HD_RT {
  const Vec3 turn = Vec3::Unit(i) * (dt * momentum[i] / moments[i]);
  const Quat step = fromRotationVector(turn);
  q = q * step;
  momentum = step.conjugate() * momentum;
}

/**
 * Turns the momentum within the body to where its energy is `wanted` again, and the body the other way, so that the
 * momentum stays in the world. About momentum x w the energy changes fastest; Newton's steps, of which only those count
 * that help: beside a principal axis, where no turn changes it, what is missing is rounding.
 */
void restoreEnergy(double wanted, const Vec3& moments, Vec3& momentum, Quat& q) HD_RT {
  constexpr int kMostSteps = 3;
  constexpr double kRounding = 1e-14;
  double excess = spin(momentum, moments) - wanted;
  for (int i = 0; i < kMostSteps && std::abs(excess) > kRounding * wanted; ++i) {
    const Vec3 way = momentum.cross(momentum.cwiseQuotient(moments));
    const double slope = way.squaredNorm();
    if (!(slope > 0)) return;
    const Quat step = fromRotationVector(way * (-excess / slope));
    const Vec3 turned = step * momentum;
    const double left = spin(turned, moments) - wanted;
    if (!(std::abs(left) < 0.5 * std::abs(excess))) return;
    momentum = turned;
    q = q * step.conjugate();
    excess = left;
  }
}

}  // namespace

MassProperties MassProperties::ofBox(double mass, const Vec3& size) {
  const Vec3 s = size.cwiseProduct(size);
  MassProperties out;
  out.mass = mass;
  out.inertia_O = Vec3(s.y() + s.z(), s.x() + s.z(), s.x() + s.y()).asDiagonal();
  out.inertia_O *= mass / 12;
  return out;
}

MassProperties MassProperties::ofBall(double mass, double radius) {
  MassProperties out;
  out.mass = mass;
  out.inertia_O = Mat3::Identity() * (0.4 * mass * radius * radius);
  return out;
}

MassProperties MassProperties::ofCylinder(double mass, double radius, double half_length) {
  const double rr = radius * radius, ll = half_length * half_length;
  MassProperties out;
  out.mass = mass;
  out.inertia_O = Vec3(rr / 4 + ll / 3, rr / 4 + ll / 3, rr / 2).asDiagonal();
  out.inertia_O *= mass;
  return out;
}

MassProperties MassProperties::ofCapsule(double mass, double radius, double half_length) {
  const double caps = 2 * radius / (2 * radius + 3 * half_length) * mass;
  // A half ball's centre of mass is 3/8 r above its flat, so about z = 0 it has 2/5 r^2 + l^2 + 3/4 l r across.
  const double across = radius * (0.4 * radius + 0.75 * half_length) + half_length * half_length;
  MassProperties out = ofCylinder(mass - caps, radius, half_length);
  out.mass = mass;
  out.inertia_O += caps * Vec3(across, across, 0.4 * radius * radius).asDiagonal().toDenseMatrix();
  return out;
}

bool MassProperties::valid() const HD_RT {
  if (!std::isfinite(mass) || !isFinite(com_O) || !inertia_O.allFinite() || !(mass > 0)) return false;
  if ((inertia_O - inertia_O.transpose()).cwiseAbs().maxCoeff() > 1e-9 * inertia_O.cwiseAbs().maxCoeff()) return false;
  const Vec3 m = Eigen::SelfAdjointEigenSolver<Mat3>(inertia_O, Eigen::EigenvaluesOnly).eigenvalues();
  return m[0] > 0 && m[2] <= (m[0] + m[1]) * (1 + 1e-9);
}

RigidBody::RigidBody(const MassProperties& properties) HD_RT : mass_(properties.mass), com_O_(properties.com_O) {
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(properties.inertia_O);
  Mat3 axes = solver.eigenvectors();
  if (axes.determinant() < 0) axes.col(0) *= -1;
  q_OP_ = Quat(axes).normalized();
  moments_ = solver.eigenvalues();
}

Mat3 RigidBody::inertia() const HD_RT {
  const Mat3 R = (q_WO_ * q_OP_).toRotationMatrix();
  return R * moments_.asDiagonal() * R.transpose();
}

Vec3 RigidBody::angularMomentum() const HD_RT {
  const Quat q_WP = q_WO_ * q_OP_;
  return q_WP * moments_.cwiseProduct(q_WP.conjugate() * V_WC_.w);
}

double RigidBody::kineticEnergy() const HD_RT {
  return 0.5 * (mass_ * V_WC_.v.squaredNorm() + V_WC_.w.dot(angularMomentum()));
}

void RigidBody::place(const Pose& X_WO) HD_RT {
  q_WO_ = X_WO.q.normalized();
  p_WC_ = X_WO.p + q_WO_ * com_O_;
  V_WC_ = Twist{};
}

void RigidBody::drift(double dt) HD_RT {
  p_WC_ += dt * V_WC_.v;
  if (V_WC_.w.isZero(0)) return;
  Quat q_WP = q_WO_ * q_OP_;
  Vec3 momentum = moments_.cwiseProduct(q_WP.conjugate() * V_WC_.w);
  const double before = spin(momentum, moments_);
  turnAbout(0, dt / 2, moments_, momentum, q_WP);
  turnAbout(1, dt / 2, moments_, momentum, q_WP);
  turnAbout(2, dt, moments_, momentum, q_WP);
  turnAbout(1, dt / 2, moments_, momentum, q_WP);
  turnAbout(0, dt / 2, moments_, momentum, q_WP);
  restoreEnergy(before, moments_, momentum, q_WP);
  const double after = spin(momentum, moments_);
  if (after > before) momentum *= std::sqrt(before / after);
  q_WP.normalize();
  q_WO_ = (q_WP * q_OP_.conjugate()).normalized();
  V_WC_.w = q_WP * momentum.cwiseQuotient(moments_);
}

}  // namespace hapticd
