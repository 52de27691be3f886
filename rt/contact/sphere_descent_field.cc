// The one-sided descent: A's nodes against what B's field says, down to A's voxels, each a point of its surface.
#include <algorithm>
#include <bit>

#include "rt/contact/sphere_descent_run.h"

namespace hapticd {

constexpr float kOutside = 0.4F;  // A point is half a diagonal from its voxel's centre, a node's sphere half a side.

/** One-sided: A's nodes against what B's field says at their centres, sixteen at a time, all in A's frame. */
void SphereDescentDetector::walkField(Run& run) HD_RT {
  const OctreeView& tree = run.a.tree;
  FieldQuery field(run.query, usableMargin(run.query.margin, run.b.view));
  const FieldTable own = fieldOf(run.a.view);
  run.own_place = placementIn(run.a.view, {});
  run.field = &field;
  run.own = &own;
  // A voxel's point may lie a little outside it, and so outside its nodes' spheres.
  const float margin = field.range.margin + kOutside * run.a.view.voxel / run.b.view.voxel;
  now_[0] = Pair{};
  for (int k = 0; k < 3; ++k) now_[0].ca[k] = static_cast<float>(run.a.root[k]);
  run.pairs = 1;
  run.a.turnTightCentres();
  Offsets offset;
  for (; !run.a.atVoxels() && run.pairs > 0;) {
    // Nodes whose spheres are clear of B go.
    std::uint32_t kept = 0;
    alignas(64) float x[16], y[16], z[16], r[16], bound[16];
    for (std::uint32_t i = 0; i < run.pairs; i += 16) {
      const std::uint32_t n = std::min(run.pairs - i, 16u);
      for (std::uint32_t k = 0; k < 16; ++k) {
        const Pair& p = now_[i + std::min(k, n - 1)];
        const Sphere s = run.a.sphere(p.a, p.ca);
        x[k] = s.x;
        y[k] = s.y;
        z[k] = s.z;
        r[k] = s.r / run.b.view.voxel;
      }
      run.tests += n;
      field.kernel.bound(field.field, {x, y, z, r}, field.placement, 0, bound);
      for (std::uint32_t k = 0; k < n; ++k)
        if (bound[k] <= margin) now_[kept++] = now_[i + k];
    }
    run.pairs = kept;
    choose(run, true);
    const OctreeLevel& level = tree.level[run.a.level];
    run.a.placesOf(offset);
    ++run.a.level;
    const bool regroup = run.a.level < map_.levels();
    if (regroup) findParts(run.a.level);
    std::uint32_t made = 0;
    for (std::uint32_t i = 0; i < run.pairs; ++i) {
      if (run.lateAt(i)) {
        run.report.dropped += run.pairs - i;
        break;
      }
      const Pair p = now_[i];
      if (run.a.atVoxels()) {
        lookUpVoxels(run, p, level, offset);
        if (run.query.first_only && run.report.touching > 0) return;
        continue;
      }
      forEachChild(level, p.a, [&](std::uint32_t place, std::uint32_t child) HD_RT {
        Pair q = p;
        q.a = child;
        q.ca[0] += offset.x[place];
        q.ca[1] += offset.y[place];
        q.ca[2] += offset.z[place];
        if (regroup) q.group = part_[child];
        push(run, q, made);
      });
    }
    std::swap(now_, next_);
    run.pairs = made;
  }
  flush(run);
}

/** Those that wait together are of one group and size. */
void SphereDescentDetector::makeRoom(Run& run, std::uint32_t count, std::uint32_t group) HD_RT {
  const float side = run.a.side();
  if (run.waiting + count > kFieldBuffer || group != run.waiting_group || side != run.waiting_side) flush(run);
  run.waiting_group = group;
  run.waiting_side = side;
}

/** Puts a node's centre with those that wait for the fields. All that waits is counted already. */
void SphereDescentDetector::lookUp(Run& run, const Pair& p) HD_RT {
  makeRoom(run, 1, p.group);
  x_[run.waiting] = p.ca[0];
  y_[run.waiting] = p.ca[1];
  z_[run.waiting++] = p.ca[2];
}

/** The centres of a last node's voxels. */
void SphereDescentDetector::lookUpVoxels(Run& run, const Pair& p, const OctreeLevel& level,
                                         const Offsets& offset) HD_RT {
  makeRoom(run, 1u << (3 * level.split), p.group);
  std::uint32_t at = run.waiting;
  for (std::uint32_t w = 0; w < maskWords(level.split); ++w) {
    for (std::uint64_t word = maskWord(level, OctreeMask::kSurface, p.a, w); word != 0; word &= word - 1) {
      const std::uint32_t place = 64 * w + static_cast<std::uint32_t>(std::countr_zero(word));
      x_[at] = p.ca[0] + offset.x[place];
      y_[at] = p.ca[1] + offset.y[place];
      z_[at++] = p.ca[2] + offset.z[place];
    }
  }
  run.tests += at - run.waiting;
  run.waiting = at;
}

/** Each of those that wait becomes a point of A's surface, which B's field is asked for. */
void SphereDescentDetector::flush(Run& run) HD_RT {
  if (run.waiting == 0) return;
  FieldQuery& field = *run.field;
  for (std::uint32_t i = run.waiting; i % HD_POINT_PADDING != 0; ++i) {
    x_[i] = x_[i - 1];
    y_[i] = y_[i - 1];
    z_[i] = z_[i - 1];
  }
  const float voxel = run.a.view.voxel;
  const PlaceTable places{x_.data(), y_.data(), z_.data(), area_.data(), voxel, run.waiting_side / voxel};
  field.kernel.settle(*run.own, run.own_place, places, run.waiting);
  field.points = {x_.data(), y_.data(), z_.data(), area_.data()};
  field.range.first = 0;
  field.range.count = run.waiting;
  field.setMiddle({x_[0], y_[0], z_[0]});
  PointSums sums = noPoints();
  field.kernel.run(field.field, field.points, field.placement, field.range, sums);
  run.report.touching += sums.touching;
  run.waiting = 0;
  if (sums.touching == 0) return;
  const double face = run.waiting_side * run.waiting_side;
  const TouchGroup got = field.read(sums, run.waiting_group, face / kShareSteps);
  TouchGroup& g = groups_[run.waiting_group];
  g.deepest = g.weight > 0 ? std::max(g.deepest, got.deepest) : got.deepest;
  g.area += got.area;
  g.weight += got.weight;
  g.mean += got.weight * got.mean;
  g.normal += got.normal;
  g.integral.force += got.integral.force;
  g.integral.torque += got.integral.torque;
}

}  // namespace hapticd
