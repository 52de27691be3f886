/** @file
 * What one query of the sphere descent carries from step to step. Included by its sources alone.
 */
#pragma once

#include "rt/contact/field_query.h"
#include "rt/contact/sphere_descent.h"
#include "rt/volume/tight_sphere.h"

namespace hapticd {

inline constexpr float kHalfDiagonal = 0.8660254F;  // sqrt(3) / 2

inline constexpr std::uint32_t kFieldBuffer = 2048;  ///< Voxels looked up at once.

struct SphereDescentDetector::Sphere {
  float x, y, z, r;
};

/** Offsets of all places of a level from its node's centre, once for all nodes. */
struct SphereDescentDetector::Offsets {
  float x[512] = {}, y[512] = {}, z[512] = {};
};

struct SphereDescentDetector::Pair {
  std::uint32_t a, b;   ///< Nodes of the levels at hand.
  std::uint32_t group;  ///< Of A.
  float ca[3], cb[3];  ///< Centres of the nodes. Of spheres against spheres in B's lattice, one-sided in A's frame [m].
};

/** One body's octree, and how far down it has been walked. Lengths are in a unit of the caller's. */
struct SphereDescentDetector::Tree {
  /** The body's pose is `X`; lengths from `origin`, in `unit` metres. */
  Tree(const VolumeView& v, const Pose& X, const Vec3& origin, double unit, bool tight_) HD_RT
      : view(v),
        tree(v.octree),
        offsets(X.q.toRotationMatrix()),
        scale(static_cast<float>(v.voxel / unit)),
        tight(tight_) {
    // The root's lower corner is lattice point 0.
    const double half = 0.5 * v.voxel * static_cast<double>(1u << tree.side_log2);
    root = (X * Vec3(v.originPoint() + Vec3::Constant(half)) - origin) / unit;
  }
  [[nodiscard]] bool atVoxels() const HD_RT { return level == tree.levels; }
  /** Words of the masks of the last level's nodes. */
  [[nodiscard]] std::size_t voxelMasks() const HD_RT {
    const OctreeLevel& l = tree.level[tree.levels - 1];
    return std::size_t{l.node_count} * maskWords(l.split);
  }
  [[nodiscard]] float side() const HD_RT {
    return atVoxels() ? scale : scale * static_cast<float>(1u << tree.level[level].side_log2);
  }
  [[nodiscard]] std::uint8_t octantsOf(std::uint32_t node) const HD_RT { return octants(tree.level[level], node); }
  /** About a node of the level at hand whose centre is given. */
  [[nodiscard]] Sphere sphere(std::uint32_t node, const float (&c)[3]) const HD_RT {
    const float s = side();
    if (atVoxels() || !tight) return {c[0], c[1], c[2], s * kHalfDiagonal};
    const std::uint8_t mask = octantsOf(node);
    const TightSphere& t = tightSphere(mask);
    const Turned& o = turned[mask];
    const float half = s / 2;
    return {c[0] + half * o.x, c[1] + half * o.y, c[2] + half * o.z, half * t.radius};
  }
  /** Once per query. */
  void turnTightCentres() HD_RT {
    for (unsigned mask = 0; mask < 256; ++mask) {
      const TightSphere& t = tightSphere(static_cast<std::uint8_t>(mask));
      const Vec3 v = offsets.turned(Vec3(t.center[0], t.center[1], t.center[2]));
      turned[mask] = {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
    }
  }
  void placesOf(Offsets& out) const HD_RT {
    const OctreeLevel& l = tree.level[level];
    for (std::uint32_t p = 0; p < 1u << (3 * l.split); ++p) {
      const Vec3 v = offsets.offset(l.split, p) * side();
      out.x[p] = static_cast<float>(v.x());
      out.y[p] = static_cast<float>(v.y());
      out.z[p] = static_cast<float>(v.z());
    }
  }
  [[nodiscard]] const hd_octree_sensation* sensation(std::uint32_t node) const HD_RT {
    if (atVoxels() || tree.sensation == nullptr) return nullptr;
    return &tree.sensation[tree.first_sensation[level] + node];
  }

  struct Turned {
    float x, y, z;
  };
  const VolumeView& view;
  const OctreeView& tree;
  TurnedOffsets offsets;
  Vec3 root;
  std::uint32_t level = 0;
  float scale;  ///< Side of a voxel.
  bool tight;
  Turned turned[256];
};

struct SphereDescentDetector::Run {
  const DetectorQuery& query;
  DetectorReport& report;
  Tree& a;
  Tree& b;
  std::uint32_t pairs = 0;  ///< In now_.
  std::uint64_t tests = 0;
  double voxel_area = 0;       ///< Of A's surface, for each of its voxels [m^2].
  double unit = 1;             ///< Of the trees' lengths [m].
  std::uint32_t last_a = ~0u;  ///< Voxel of A that touched last: it is counted once.
  // One-sided.
  FieldQuery* field = nullptr;      ///< Of A's places in B.
  const FieldTable* own = nullptr;  ///< Of A.
  Placement own_place{};            ///< Of A's places in A's lattice.
  std::uint32_t waiting = 0;        ///< Of the group `waiting_group`, in x_, y_, z_.
  std::uint32_t waiting_group = 0;
  float waiting_side = 0;  ///< Of the nodes or voxels that wait [m].

  [[nodiscard]] std::uint32_t unitsLeft() const HD_RT {
    const auto used = static_cast<std::uint32_t>((tests + 15) / 16);
    return query.budget.units > used ? query.budget.units - used : 0;
  }
  [[nodiscard]] bool limited() const HD_RT { return query.budget.units != 0; }
  [[nodiscard]] bool late() const HD_RT {
    const WorkBudget& w = query.budget;
    return w.clock != nullptr && w.deadline_ns != 0 && w.clock->now() >= w.deadline_ns;
  }
  /** The same, asked at every 256th pair. */
  [[nodiscard]] bool lateAt(std::uint32_t i) const HD_RT {
    if (i % 256 != 0 || !late()) return false;
    report.exhausted = true;
    return true;
  }
};

/** To the next level's pairs, if there is room. */
inline void SphereDescentDetector::push(Run& run, const Pair& q, std::uint32_t& made) HD_RT {
  if (made < next_.size()) {
    next_[made++] = q;
    return;
  }
  ++run.report.dropped;
  run.report.exhausted = true;
}

}  // namespace hapticd
