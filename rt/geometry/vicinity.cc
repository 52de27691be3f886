#include "rt/geometry/vicinity.h"

#include <algorithm>

#include "rt/geometry/box_queries.h"
#include "rt/geometry/tree_walk.h"
#include "rt/geometry/triangle.h"

namespace hapticd {
namespace {

constexpr double kStill = 0x1p-14;  // Of the radius: a way so short is taken for a larger ball.
constexpr double kNeedle = 1e-9;    // Sine of an angle below which a triangle has no plane worth asking.

void put(const Vec3& n, double offset, double far, float (&normal)[3][kPrismWidth], float* offsets,
         std::uint32_t lane) HD_RT {
  for (int i = 0; i < 3; ++i) normal[i][lane] = static_cast<float>(n[i]);
  offsets[lane] = static_cast<float>(std::clamp(offset, -far, far));
}

}  // namespace

/** One prism in double precision. */
void Vicinity::remake(const MeshView& mesh, PrismBlock& block, std::uint32_t lane) const HD_RT {
  const std::uint32_t triangle = block.triangle[lane];
  const Vec3 v[3] = {mesh.vertex(triangle, 0) - center_, mesh.vertex(triangle, 1) - center_,
                     mesh.vertex(triangle, 2) - center_};
  const Vec3 edge[3] = {v[1] - v[0], v[2] - v[1], v[0] - v[2]};
  const Vec3 up = edge[0].cross(edge[1]);
  const double area = up.norm(), far = kPrismFar * radius_;
  const double longest = std::max({edge[0].squaredNorm(), edge[1].squaredNorm(), edge[2].squaredNorm()});
  const bool needle = !(area > kNeedle * longest);  // Always asked.
  const Vec3 n = needle ? Vec3(Vec3::Zero()) : Vec3(up / area);
  put(n, n.dot(v[0]), far, block.normal, block.offset, lane);
  for (int k = 0; k < 3; ++k) {
    const Vec3 side = needle ? Vec3(Vec3::Zero()) : edge[k].cross(n).normalized();
    put(side, side.dot(v[k]), far, block.side[k], block.side_offset[k], lane);
  }
}

/** Makes prisms of the last triangles taken, at most eight; lanes left over are never met. */
void Vicinity::make(const MeshView& mesh) HD_RT {
  PrismBlock& block = block_[(count_ - 1) / kPrismWidth];
  const std::uint32_t used = (count_ - 1) % kPrismWidth + 1;
  PrismCorners corners{};
  for (std::uint32_t lane = 0; lane < used; ++lane) {
    const auto& v = mesh.corners[block.triangle[lane]];
    for (int c = 0; c < 3; ++c) {
      for (int k = 0; k < 3; ++k) corners.v[c][k][lane] = v[c][k] - origin_[k];
    }
  }
  std::uint32_t rough = boxTests().make(corners, static_cast<float>(radius_), block);
  rough &= (1u << used) - 1;
  for (; rough != 0; rough &= rough - 1) remake(mesh, block, static_cast<std::uint32_t>(std::countr_zero(rough)));
  const double far = kPrismFar * radius_;
  for (std::uint32_t lane = used; lane < kPrismWidth; ++lane) {
    block.triangle[lane] = HD_NO_INDEX;
    put(Vec3::Zero(), -far, far, block.normal, block.offset, lane);
    for (int k = 0; k < 3; ++k) put(Vec3::Zero(), 0, far, block.side[k], block.side_offset[k], lane);
  }
}

bool Vicinity::fill(const MeshView& mesh, VicinityQuery& query) HD_RT {
  clear();
  for (int i = 0; i < 3; ++i) {
    origin_[i] = static_cast<float>(query.center[i]);
    center_[i] = origin_[i];
  }
  radius_ = query.radius;
  const BoxTests& tests = boxTests();
  const BoxPoint point = boxPoint(center_);
  const float reach = roundedUp(radius_ * radius_);
  bool fits = true;
  const bool finished = walkTree(
      mesh, {query.work, query.limit},
      [&](const hd_bvh_node& node, float* key) {
        const std::uint32_t mask = tests.approach(node, point, reach, key);
        std::fill_n(key, HD_BVH_WIDTH, 0.0F);  // All in reach weigh alike: visited from left to right.
        return mask;
      },
      [&] { return fits ? 0.0F : -1.0F; },
      [&](std::uint32_t first, std::uint32_t in_leaf) {
        for (std::uint32_t t = first; t < first + in_leaf && fits; ++t) {
          fits = count_ < kMaxTriangles;
          if (!fits) return;
          block_[count_ / kPrismWidth].triangle[count_ % kPrismWidth] = t;
          if (++count_ % kPrismWidth == 0) make(mesh);
        }
      });
  if (!finished || !fits) {
    clear();
    return false;
  }
  if (count_ % kPrismWidth != 0) make(mesh);
  return true;
}

PrismSweep Vicinity::rounded(const Vec3& a, const Vec3& b, double radius, bool behind) const HD_RT {
  PrismSweep sweep;
  for (int i = 0; i < 3; ++i) {
    sweep.a[i] = static_cast<float>(a[i] - center_[i]);
    sweep.b[i] = static_cast<float>(b[i] - center_[i]);
  }
  const double way = (b - a).norm();
  sweep.still = way <= kStill * radius_;
  const double grown = radius + kSlack * radius_ + (sweep.still ? way : 0.0);
  sweep.radius_squared = roundedUp(grown * grown);
  sweep.behind = static_cast<float>(behind ? 2 * radius_ : kSlack * radius_);
  return sweep;
}

}  // namespace hapticd
