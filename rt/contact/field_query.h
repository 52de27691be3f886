/** @file
 * A query of points against B's field as the kernels want it, and back. Servo-safe. Included by detectors' sources.
 */
#pragma once

#include <algorithm>

#include "rt/contact/detector.h"
#include "rt/contact/point_kernel.h"
#include "rt/contact/touch_group.h"

namespace hapticd {

/** The largest margin that B's bricks can answer for [m]. */
[[nodiscard]] inline double usableMargin(double margin, const VolumeView& b) HD_RT {
  return std::clamp<double>(margin, 0, std::min(b.voxel, b.band));
}

[[nodiscard]] inline FieldTable fieldOf(const VolumeView& v) HD_RT {
  FieldTable field{};
  for (std::size_t k = 0; k < 3; ++k) {
    field.cells[k] = v.cells[k];
    field.top[k] = std::nextafter(static_cast<float>(HD_BRICK_EDGE * v.cells[k]), 0.0F);
  }
  field.cell = v.cell;
  field.coarse = v.coarse;
  field.bricks = v.bricks;
  field.fine_step = v.fine_step / v.voxel;
  field.coarse_step = v.coarse_step / v.voxel;
  return field;
}

/** From the frame whose pose in the volume's is `X` to the volume's lattice. */
[[nodiscard]] inline Placement placementIn(const VolumeView& v, const Pose& X) HD_RT {
  Placement placement{};
  const Mat3 R = X.q.toRotationMatrix();
  const Vec3 t = (X.p - v.originPoint()) / v.voxel;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) placement.row[i][j] = static_cast<float>(R(i, j) / v.voxel);
    placement.shift[i] = static_cast<float>(t[i]);
  }
  return placement;
}

/** One query of points of A, in A's frame, against B. */
struct FieldQuery {
  FieldQuery(const DetectorQuery& q, double margin) HD_RT : query(q),
                                                            a(*q.a.volume),
                                                            b(*q.b.volume),
                                                            X_BA(q.b.X_WO.inverse() * q.a.X_WO),
                                                            kernel(pointKernel()) {
    field = fieldOf(b);
    points = {a.point[0], a.point[1], a.point[2], a.area};
    range.margin = static_cast<float>(margin / b.voxel);
    range.weight = 1;
    place(X_BA);
  }

  /** Puts A's points where `X` says in B. */
  void place(const Pose& X) HD_RT {
    placement = placementIn(b, X);
    now = X;
  }

  /** Sums of a group are taken about a place of A near it: small numbers. */
  void setMiddle(const float (&at_A)[3]) HD_RT {
    const Vec3 at = (now * Vec3(at_A[0], at_A[1], at_A[2]) - b.originPoint()) / b.voxel;
    for (int k = 0; k < 3; ++k) range.middle[k] = static_cast<float>(at[k]);
  }

  /** What sums come to; `area` in m^2 for one of the points' steps. */
  [[nodiscard]] TouchGroup read(const PointSums& sums, std::uint32_t part, double area) const HD_RT {
    float s[PointSums::kCount + 1];
    kernel.reduce(sums, s);
    const auto vec = [&](int i) HD_RT { return Vec3(s[i], s[i + 1], s[i + 2]); };
    const double voxel = b.voxel;
    const Vec3 middle = b.originPoint() + voxel * Vec3(range.middle[0], range.middle[1], range.middle[2]);
    TouchGroup g;
    g.part = part;
    g.area = area * s[PointSums::kArea];
    g.weight = area * voxel * s[PointSums::kWeight];
    g.mean = middle;
    if (s[PointSums::kWeight] > 0) g.mean += voxel / s[PointSums::kWeight] * vec(PointSums::kMean);
    g.normal = area * voxel * vec(range.margin > 0 ? PointSums::kNormal : PointSums::kForce);
    g.deepest = voxel * s[PointSums::kCount];
    g.integral.force = area * voxel * vec(PointSums::kForce);
    g.integral.torque = area * voxel * voxel * vec(PointSums::kTorque) + middle.cross(g.integral.force);
    g.face = faceOf(X_BA.q.conjugate() * g.normal);
    return g;
  }

  const DetectorQuery& query;
  const VolumeView& a;
  const VolumeView& b;
  Pose X_BA;
  Pose now;  ///< Of the placement.
  const PointKernel& kernel;
  FieldTable field{};
  PointTable points{};
  Placement placement{};
  PointRange range{};
};

/** Sums to add to. */
[[nodiscard]] inline PointSums noPoints() HD_RT {
  PointSums sums{};
  std::fill_n(sums.deepest, 16, -1e9F);
  return sums;
}

}  // namespace hapticd
