#include "rt/geometry/vicinity.h"

#include <algorithm>

#include "rt/geometry/box_queries.h"
#include "rt/geometry/tree_walk.h"
#include "rt/geometry/triangle.h"

namespace hapticd {
namespace {

constexpr double kStill = 0x1p-14;       // Of the radius: a way so short is taken for a larger ball.
constexpr std::uint32_t kFewBlocks = 2;  // Not worth a look at their boxes.
constexpr double kNeedle = 1e-9;         // Sine of an angle below which a triangle has no plane worth asking.

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

/** Makes prisms of a block's triangles, at most eight; lanes left over are never met. */
void Vicinity::make(std::uint32_t number) HD_RT {
  const MeshView& mesh = *mesh_;
  PrismBlock& block = block_[number];
  const std::uint32_t used = std::min<std::uint32_t>(count_ - number * kPrismWidth, kPrismWidth);
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
  made_ |= std::uint64_t{1} << number;
}

void Vicinity::begin(const MeshView& mesh, const Vec3& center, double radius) HD_RT {
  for (int i = 0; i < 3; ++i) {
    origin_[i] = static_cast<float>(center[i]);
    center_[i] = origin_[i];
  }
  radius_ = radius;
  mesh_ = &mesh;
  made_ = 0;
  count_ = visited_ = first_ = end_ = 0;
  if (mesh.node_count > 0) node_[end_++] = 0;
  state_ = radius > 0 ? State::kFilling : State::kEmpty;
}

/** Takes a leaf's triangles; the boxes of their blocks grow by that of the leaf. False: they do not fit. */
bool Vicinity::take(const hd_bvh_node& node, std::uint32_t leaf) HD_RT {
  const std::uint32_t end = count_ + node.count[leaf];
  visited_ += node.count[leaf];
  if (end > kMaxTriangles) return false;
  std::uint32_t triangle = node.child[leaf];
  while (count_ < end) {
    const std::uint32_t number = count_ / kPrismWidth, child = number % HD_BVH_WIDTH;
    hd_bvh_node& box = box_[number / HD_BVH_WIDTH];
    const bool first = count_ % kPrismWidth == 0;
    box.used = child + 1;
    for (int k = 0; k < 3; ++k) {
      const float lower = node.lower[k][leaf] - origin_[k], upper = node.upper[k][leaf] - origin_[k];
      box.lower[k][child] = first ? lower : std::min(box.lower[k][child], lower);
      box.upper[k][child] = first ? upper : std::max(box.upper[k][child], upper);
    }
    do {
      block_[number].triangle[count_ % kPrismWidth] = triangle++;
      ++count_;
    } while (count_ < end && count_ % kPrismWidth != 0);
  }
  return true;
}

/** False: what it holds does not fit. */
bool Vicinity::look(const MeshView& mesh, std::uint32_t number) HD_RT {
  ++visited_;
  const hd_bvh_node& node = mesh.nodes[number];
  float key[HD_BVH_WIDTH];
  std::uint32_t mask = boxTests().approach(node, boxPoint(center_), roundedUp(radius_ * radius_), key);
  if (end_ + HD_BVH_WIDTH > kMaxNodes) return false;
  for (; mask != 0; mask &= mask - 1) {
    const auto i = static_cast<std::uint32_t>(std::countr_zero(mask));
    fetch(mesh, node.child[i], node.count[i]);
    if (node.count[i] == 0) {
      node_[end_++] = node.child[i];
    } else if (!take(node, i)) {
      return false;
    }
  }
  return true;
}

Vicinity::State Vicinity::proceed(const MeshView& mesh, std::uint32_t nodes, std::uint32_t& work) HD_RT {
  const std::uint32_t before = visited_;
  bool fits = true;
  for (; state_ == State::kFilling && first_ < end_ && nodes > 0 && fits; --nodes) {
    fits = look(mesh, node_[first_++]) && visited_ <= kMaxVisits;
  }
  work += visited_ - before;
  if (!fits) {
    clear();
  } else if (state_ == State::kFilling && first_ == end_) {
    state_ = State::kFull;
  }
  return state_;
}

std::uint64_t Vicinity::rounded(const Vec3& a, const Vec3& b, double radius, bool behind,
                                PrismSweep& sweep) const HD_RT {
  for (int i = 0; i < 3; ++i) {
    sweep.a[i] = static_cast<float>(a[i] - center_[i]);
    sweep.b[i] = static_cast<float>(b[i] - center_[i]);
  }
  const double way = (b - a).norm();
  sweep.still = way <= kStill * radius_;
  const double grown = radius + kSlack * radius_ + (sweep.still ? way : 0.0);
  sweep.radius_squared = roundedUp(grown * grown);
  sweep.behind = static_cast<float>(behind ? 2 * radius_ : kSlack * radius_);

  const std::uint32_t blocks = (count_ + kPrismWidth - 1) / kPrismWidth;
  if (blocks <= kFewBlocks) return (std::uint64_t{1} << blocks) - 1;
  // What is beyond a ball about the whole way is not met.
  BoxPoint middle;
  for (int i = 0; i < 3; ++i) middle.lower[i] = middle.upper[i] = 0.5F * (sweep.a[i] + sweep.b[i]);
  const double reach = grown + 0.5 * way;
  const float squared = roundedUp(reach * reach);
  std::uint64_t near = 0;
  for (std::uint32_t k = 0; k < blocks; k += HD_BVH_WIDTH) {
    float key[HD_BVH_WIDTH];
    near |= std::uint64_t{boxTests().approach(box_[k / HD_BVH_WIDTH], middle, squared, key)} << k;
  }
  return near;
}

}  // namespace hapticd
