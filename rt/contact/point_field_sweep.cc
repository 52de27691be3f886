// Thin walls: what A's points met on the way from the pose before.
#include "rt/contact/point_field.h"
#include "rt/contact/point_field_run.h"

namespace hapticd {
namespace {

constexpr int kMaxSteps = 16;

Pose between(const Pose& from, const Pose& to, double s) HD_RT {
  return {from.p + s * (to.p - from.p), from.q.slerp(s, to.q)};
}

}  // namespace

void PointFieldDetector::sweep(Run& run) HD_RT {
  const Pose before = run.query.b.X_WO_before.inverse() * run.query.a.X_WO_before;
  const double turn = 2 * std::asin(std::min(1.0, (run.X_BA.q * before.q.conjugate()).vec().norm()));
  const double way = (run.X_BA * middle_A_ - before * middle_A_).norm() + turn * reach_;
  if (!(way > run.b.voxel)) return;
  const int steps = static_cast<int>(std::min<double>(kMaxSteps, std::ceil(way / run.b.voxel)));
  const auto count = static_cast<std::uint32_t>(run.a.patches.size());
  const PatchTable table{x_.data(), y_.data(), z_.data(), radius_.data()};
  bool met[kMaxTouchGroups] = {};
  for (int s = 1; s < steps; ++s) {
    const Pose X = between(before, run.X_BA, static_cast<double>(s) / steps);
    run.place(X);
    for (std::uint32_t g = 0; g < map_.count(); ++g) {
      if (met[g]) continue;
      const std::uint32_t first = map_.first(g), end = map_.first(g + 1);
      PointSums sums = noPoints();
      bool placed = false;
      alignas(64) float bound[16];
      std::uint32_t bounded = ~0u;
      for (std::uint32_t i = first; i < end && i < count; ++i) {
        const hd_volume_patch& p = run.a.patches[i];
        const std::uint32_t blocks = p.count == 0 ? 0 : ((p.first + p.count - 1) >> 4) - (p.first >> 4) + 1;
        if (run.late(run.report.work) || (run.limit != 0 && run.report.work + 1 + blocks > run.limit)) {
          run.report.exhausted = true;
          break;
        }
        if (bounded != (i & ~15u)) {
          bounded = i & ~15u;
          ++run.report.work;
          run.kernel.bound(run.field, table, run.placement, bounded, bound);
        }
        if (p.count == 0 || bound[i - bounded] > run.range.margin) continue;
        if (!placed) run.setMiddle(p.center);
        placed = true;
        run.range.first = p.first;
        run.range.count = p.count;
        run.range.weight = 1;
        run.report.work += blocks;
        run.kernel.run(run.field, run.points, run.placement, run.range, sums);
      }
      if (sums.touching == 0) continue;
      met[g] = true;
      entries_[g] = run.read(sums, g, run.a.area_step);
      // Where these points are now, and how far past the face they met.
      TouchGroup& e = entries_[g];
      const Vec3 there = run.X_BA * (X.inverse() * e.mean);
      const double area = std::max(e.area, 1e-30), n = e.normal.norm();
      const Vec3 out = n > 0 ? Vec3(e.normal / n) : Vec3::Zero();
      e.deepest += out.dot(e.mean - there);
      e.mean = there;
      e.integral.force = area * e.deepest * out;
      e.integral.torque = there.cross(e.integral.force);
    }
  }
  run.place(run.X_BA);
  for (std::uint32_t g = 0; g < map_.count(); ++g) {
    if (!met[g] || entries_[g].deepest <= 0) continue;
    if (run.touched[g] && groups_[g].normal.dot(entries_[g].normal) >= 0) continue;
    groups_[g] = entries_[g];
    run.touched[g] = true;
  }
}

}  // namespace hapticd
