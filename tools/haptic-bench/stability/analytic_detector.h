/** @file
 * Detectors in closed form: a tool of balls (radius 0: points) against a solid whose signed distance is a formula.
 */
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "rt/contact/detector.h"

namespace haptic_bench {

using namespace hapticd;  // NOLINT(google-build-using-namespace)

/** Signed distance and outward direction at a place, in B's frame. */
struct Distance {
  double d = 0;
  Vec3 n = Vec3::UnitZ();
};
using Field = std::function<Distance(const Vec3&)>;

inline Distance nearer(const Distance& x, const Distance& y) { return x.d < y.d ? x : y; }

inline Field halfSpace() {
  return [](const Vec3& p) { return Distance{p.z(), Vec3::UnitZ()}; };
}
inline Field ball(double radius) {
  return [radius](const Vec3& p) { return Distance{p.norm() - radius, p.normalized()}; };
}
/** The inside of a sphere. */
inline Field bowl(double radius) {
  return [radius](const Vec3& p) { return Distance{radius - p.norm(), -p.normalized()}; };
}
/** The quarter space z < 0, s > 0, where `side` is the direction in which s grows. */
inline Distance quarter(double z, double s, const Vec3& side) {
  if (z > 0 && s < 0) {
    const double d = std::hypot(z, s);
    return {d, (z * Vec3::UnitZ() + s * side) / d};
  }
  if (s >= 0 && z > 0) return {z, Vec3::UnitZ()};
  if (z <= 0 && s < 0) return {-s, -side};
  return z > -s ? Distance{z, Vec3::UnitZ()} : Distance{-s, -side};
}
/** A block below z = 0 with a slot along x. */
inline Field slot(double half_width, double depth) {
  return [=](const Vec3& p) {
    const Distance walls =
        nearer(quarter(p.z(), p.y() - half_width, Vec3::UnitY()), quarter(p.z(), -p.y() - half_width, -Vec3::UnitY()));
    return nearer(walls, {p.z() + depth, Vec3::UnitZ()});
  };
}
/** A block below z = 0 with a round hole along z. */
inline Field hole(double radius, double depth) {
  return [=](const Vec3& p) {
    const double rho = std::hypot(p.x(), p.y());
    const Vec3 out = rho > 1e-12 ? Vec3(Vec3(p.x(), p.y(), 0) / rho) : Vec3(Vec3::UnitX());
    return nearer(quarter(p.z(), rho - radius, out), {p.z() + depth, Vec3::UnitZ()});
  };
}

/** Points of a tool, in its frame. */
struct Points {
  std::vector<Vec3> p;
  double radius = 0;
};
inline Points boxCorners(const Vec3& size) {
  Points out;
  for (int i = 0; i < 8; ++i) {
    out.p.emplace_back(size.x() * ((i & 1) - 0.5), size.y() * ((i >> 1 & 1) - 0.5), size.z() * ((i >> 2 & 1) - 0.5));
  }
  return out;
}
/** A cylinder along z: rings of `around` points each, closed by the outermost. */
inline Points peg(double radius, double length, int rings, int around) {
  Points out;
  for (int k = 0; k < rings; ++k) {
    for (int i = 0; i < around; ++i) {
      const double a = 2 * EIGEN_PI * i / around;
      out.p.emplace_back(radius * std::cos(a), radius * std::sin(a), length * (double(k) / (rings - 1) - 0.5));
    }
  }
  return out;
}

/** Every point within the margin is a contact, the deepest first if there are too many. Knows nothing of volumes. */
class AnalyticDetector final : public Detector {
 public:
  AnalyticDetector(Points tool, Field field) : tool_(std::move(tool)), field_(std::move(field)) {}

  [[nodiscard]] const char* name() const noexcept override { return "analytic"; }
  void find(const DetectorQuery& query, ContactSet& out) HD_RT override {
    const Pose X_BW = query.b.X_WO.inverse();
    out.count = 0;
    out.integral = Wrench{};
    out.deepest = 0;
    found_.clear();
    for (std::size_t i = 0; i < tool_.p.size(); ++i) {
      const Vec3 p_WA = query.a.X_WO * tool_.p[i];
      const Distance at = field_(X_BW * p_WA);
      const double gap = at.d - tool_.radius;
      if (gap > query.margin) continue;
      Contact c;
      c.n_W = query.b.X_WO.q * at.n;
      c.p_WA = p_WA - tool_.radius * c.n_W;
      c.p_WB = p_WA - at.d * c.n_W;
      c.depth = -gap;
      c.area = 1e-6;
      c.feature_a = static_cast<std::uint32_t>(i + 1);
      found_.push_back(c);
      if (gap >= 0) continue;
      out.integral.force += c.n_W * (c.depth * c.area);
      out.integral.torque += (c.p_WA - query.a.X_WO.p).cross(c.n_W) * (c.depth * c.area);
      out.deepest = std::max(out.deepest, c.depth);
    }
    std::stable_sort(found_.begin(), found_.end(),
                     [](const Contact& x, const Contact& y) { return x.depth > y.depth; });
    for (const Contact& c : found_) {
      if (out.count < std::min(query.max_contacts, kMaxContacts)) out.contact[out.count++] = c;
    }
  }
  void reset() HD_RT override {}

 private:
  Points tool_;
  Field field_;
  std::vector<Contact> found_;
};

}  // namespace haptic_bench
