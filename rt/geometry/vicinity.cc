#include "rt/geometry/vicinity.h"

#include <algorithm>

#include "rt/geometry/box_queries.h"
#include "rt/geometry/tree_walk.h"
#include "rt/geometry/triangle.h"

namespace hapticd {
namespace {

constexpr double kStill = 0x1p-14;       // Of the radius: a way so short is taken for a larger ball.
constexpr std::uint32_t kFewBlocks = 2;  // Not worth a look at their boxes.
constexpr double kSmallest = 1e-30;      // Radius [m]: its inverse is a number.
constexpr double kNeedle = 1e-9;         // Sine of an angle below which a triangle has no plane worth asking.

void put(const Vec3& n, double offset, float (&normal)[3][kPrismWidth], float* offsets, std::uint32_t lane) HD_RT {
  constexpr double kFar = kPrismFar;
  for (int i = 0; i < 3; ++i) normal[i][lane] = static_cast<float>(n[i]);
  offsets[lane] = static_cast<float>(std::clamp(offset, -kFar, kFar));
}

/** Who slides over the triangles will ask for them. */
void fetchNeighbours(const MeshView& mesh, std::uint32_t first, std::uint32_t count) HD_RT {
  if (mesh.neighbours == nullptr) return;
  __builtin_prefetch(&mesh.neighbours[first]);
  __builtin_prefetch(&mesh.neighbours[first + count - 1]);
}

}  // namespace

/** One prism in double precision. */
void Vicinity::remake(PrismBlock& block, std::uint32_t triangle, std::uint32_t lane) const HD_RT {
  Vec3 v[3];
  for (int c = 0; c < 3; ++c) v[c] = (mesh_->vertex(triangle, c) - center_) / size_;
  const Vec3 edge[3] = {v[1] - v[0], v[2] - v[1], v[0] - v[2]};
  const Vec3 up = edge[0].cross(edge[1]);
  const double area = up.norm();
  const double longest = std::max({edge[0].squaredNorm(), edge[1].squaredNorm(), edge[2].squaredNorm()});
  const bool needle = !(area > kNeedle * longest);  // Always asked.
  const Vec3 n = needle ? Vec3(Vec3::Zero()) : Vec3(up / area);
  put(n, n.dot(v[0]), block.normal, block.offset, lane);
  block.squared[lane] = 1;
  for (int k = 0; k < 3; ++k) {
    const Vec3 side = needle ? Vec3(Vec3::Zero()) : edge[k].cross(n).normalized();
    put(side, side.dot(v[k]), block.side[k], block.side_offset[k], lane);
    block.side_squared[k][lane] = 1;
  }
}

/** Makes prisms of a block's triangles. */
void Vicinity::make(std::uint32_t number) HD_RT {
  PrismBlock& block = block_[number];
  const std::uint32_t first = first_of_[number], count = count_of_[number];
  PrismFrame frame;
  for (int i = 0; i < 3; ++i) frame.origin[i] = origin_[i];
  frame.inverse = static_cast<float>(1 / size_);
  std::uint32_t rough = boxTests().make(&mesh_->corners[first][0][0], count, frame, block) & ((1u << count) - 1);
  for (; rough != 0; rough &= rough - 1) {
    const auto lane = static_cast<std::uint32_t>(std::countr_zero(rough));
    remake(block, first + lane, lane);
  }
  made_ |= std::uint64_t{1} << number;
}

void Vicinity::begin(const MeshView& mesh, const Vec3& from, const Vec3& to, double radius) HD_RT {
  center_ = asFloat(Vec3(0.5 * (from + to)));
  for (int i = 0; i < 3; ++i) origin_[i] = static_cast<float>(center_[i]);
  half_ = to - center_;
  const double half2 = half_.squaredNorm();
  inverse_half2_ = half2 > kStill * kStill * radius * radius ? 1 / half2 : 0.0;
  radius_ = radius;
  size_ = radius + std::sqrt(half2);
  way_ = boxPoint(center_ - half_);
  const BoxPoint end = boxPoint(center_ + half_);
  for (int i = 0; i < 3; ++i) {
    way_.lower[i] = std::min(way_.lower[i], end.lower[i]);
    way_.upper[i] = std::max(way_.upper[i], end.upper[i]);
  }
  mesh_ = &mesh;
  made_ = 0;
  count_ = blocks_ = visited_ = first_ = end_ = 0;
  if (mesh.node_count > 0) node_[end_++] = 0;
  state_ = radius > kSmallest ? State::kFilling : State::kEmpty;
}

/** Takes a leaf's triangles as the next eight. False: they do not fit. */
bool Vicinity::take(const hd_bvh_node& node, std::uint32_t leaf) HD_RT {
  visited_ += node.count[leaf];
  if (blocks_ == kBlocks) return false;
  const std::uint32_t child = blocks_ % HD_BVH_WIDTH;
  hd_bvh_node& box = box_[blocks_ / HD_BVH_WIDTH];
  for (int k = 0; k < 3; ++k) {
    box.lower[k][child] = node.lower[k][leaf] - origin_[k];
    box.upper[k][child] = node.upper[k][leaf] - origin_[k];
  }
  box.used = child + 1;
  first_of_[blocks_] = node.child[leaf];
  count_of_[blocks_] = node.count[leaf];
  ++blocks_;
  count_ += node.count[leaf];
  return true;
}

/** False: what it holds does not fit. */
bool Vicinity::look(const MeshView& mesh, std::uint32_t number) HD_RT {
  ++visited_;
  const hd_bvh_node& node = mesh.nodes[number];
  float key[HD_BVH_WIDTH];
  std::uint32_t mask = boxTests().approach(node, way_, roundedUp(radius_ * radius_), key);
  if (end_ + HD_BVH_WIDTH > kMaxNodes) return false;
  for (; mask != 0; mask &= mask - 1) {
    const auto i = static_cast<std::uint32_t>(std::countr_zero(mask));
    fetch(mesh, node.child[i], node.count[i]);
    if (node.count[i] == 0) {
      node_[end_++] = node.child[i];
    } else {
      fetchNeighbours(mesh, node.child[i], node.count[i]);
      if (!take(node, i)) return false;
    }
  }
  return true;
}

Vicinity::State Vicinity::proceed(const MeshView& mesh, std::uint32_t visits, std::uint32_t& work) HD_RT {
  const std::uint32_t before = visited_;
  bool fits = true;
  while (state_ == State::kFilling && first_ < end_ && visited_ - before < visits && fits) {
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

std::uint64_t Vicinity::rounded(const Vec3& a, const Vec3& b, double radius, double behind,
                                PrismSweep& sweep) const HD_RT {
  const double inverse = 1 / size_;
  for (int i = 0; i < 3; ++i) {
    sweep.a[i] = static_cast<float>((a[i] - center_[i]) * inverse);
    sweep.b[i] = static_cast<float>((b[i] - center_[i]) * inverse);
  }
  const double way = (b - a).norm();
  sweep.still = way <= kStill * size_;
  const double grown = radius + kSlack * size_ + (sweep.still ? way : 0.0);
  sweep.radius_squared = roundedUp(grown * inverse * (grown * inverse));
  const double back = std::min(behind * inverse + kSlack, 2.0);  // Nothing asked for is farther behind.
  sweep.behind_squared = roundedUp(back * back);

  if (blocks_ <= kFewBlocks) return (std::uint64_t{1} << blocks_) - 1;
  // What is beyond a ball about the whole way is not met.
  BoxPoint middle;
  for (int i = 0; i < 3; ++i) middle.lower[i] = middle.upper[i] = static_cast<float>(0.5 * (a[i] + b[i]) - center_[i]);
  const double reach = grown + 0.5 * way;
  const float squared = roundedUp(reach * reach);
  std::uint64_t near = 0;
  for (std::uint32_t k = 0; k < blocks_; k += HD_BVH_WIDTH) {
    float key[HD_BVH_WIDTH];
    near |= std::uint64_t{boxTests().approach(box_[k / HD_BVH_WIDTH], middle, squared, key)} << k;
  }
  return near;
}

}  // namespace hapticd
