#include "rt/geometry/tree/vicinity.h"

#include <algorithm>
#include <bit>

#include "rt/geometry/tree/box_queries.h"
#include "rt/geometry/tree/tree_walk.h"
#include "rt/geometry/triangle.h"

namespace hapticd {
namespace {

constexpr double kStill = 0x1p-14;       // Of the radius: a way so short is taken for a larger ball.
constexpr std::uint32_t kFewBlocks = 2;  // Not worth a look at their boxes.
constexpr double kSmallest = 1e-30;      // Radius [m]: its inverse is a number.
constexpr double kNeedle = 1e-9;         // Sine of an angle below which a triangle has no plane worth asking,
                                         // times 1 + its length in units: that far off, rounding tips it away.

void put(const Vec3& n, double offset, float (&normal)[3][kPrismWidth], float* offsets, std::uint32_t lane) HD_RT {
  constexpr double kFar = kPrismFar;
  for (int i = 0; i < 3; ++i) normal[i][lane] = static_cast<float>(n[i]);
  offsets[lane] = static_cast<float>(std::clamp(offset, -kFar, kFar));
}

/** Who slides over the triangles will ask for them. Always inline, as fetch(). */
[[gnu::always_inline]] inline void fetchNeighbours(const MeshView& mesh, std::uint32_t first,
                                                   std::uint32_t count) HD_RT {
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
  const bool needle = !(area > kNeedle * longest * (1 + std::sqrt(longest)));  // Always asked.
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
  const auto count = static_cast<std::uint32_t>(std::bit_width(block.used));
  std::uint32_t rough = boxTests().make(&mesh_->corners[block.first][0][0], count, frame_, block) & block.used;
  for (; rough != 0; rough &= rough - 1) {
    const auto lane = static_cast<std::uint32_t>(std::countr_zero(rough));
    remake(block, block.first + lane, lane);
  }
  made_ |= std::uint64_t{1} << number;
}

void Vicinity::begin(const MeshView& mesh, const Vec3& from, const Vec3& to, double radius) HD_RT {
  center_ = asFloat(Vec3(0.5 * (from + to)));
  half_ = to - center_;
  const double half2 = half_.squaredNorm();
  inverse_half2_ = half2 > kStill * kStill * radius * radius ? 1 / half2 : 0.0;
  radius_ = radius;
  size_ = radius + std::sqrt(half2);
  inverse_size_ = 1 / std::max(size_, kSmallest);
  for (int i = 0; i < 3; ++i) frame_.origin[i] = static_cast<float>(center_[i]);
  frame_.inverse = static_cast<float>(inverse_size_);
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
  const std::uint32_t lane = blocks_ % kPrismWidth;
  PrismBoxes& box = box_[blocks_ / kPrismWidth];
  for (int k = 0; k < 3; ++k) {
    box.lower[k][lane] = (node.lower[k][leaf] - frame_.origin[k]) * frame_.inverse;
    box.upper[k][lane] = (node.upper[k][leaf] - frame_.origin[k]) * frame_.inverse;
  }
  block_[blocks_].first = node.child[leaf];
  block_[blocks_].used = (1u << node.count[leaf]) - 1;
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

PrismSweep Vicinity::rounded(const Vec3& a, const Vec3& b, double radius, double behind) const HD_RT {
  PrismSweep sweep;
  for (int i = 0; i < 3; ++i) {
    sweep.a[i] = static_cast<float>((a[i] - center_[i]) * inverse_size_);
    sweep.b[i] = static_cast<float>((b[i] - center_[i]) * inverse_size_);
  }
  const double still = kStill * size_;
  sweep.still = (b - a).squaredNorm() <= still * still;
  const double grown = radius * inverse_size_ + kSlack + (sweep.still ? kStill : 0.0);
  sweep.radius_squared = roundedUp(grown * grown);
  const double back = std::min(behind * inverse_size_ + kSlack, 2.0);  // Nothing asked for is farther behind.
  sweep.behind_squared = roundedUp(back * back);
  return sweep;
}

void Vicinity::reach(const Vec3& a, const Vec3& b, double radius, double behind, Reached& reached) HD_RT {
  const PrismSweep sweep = rounded(a, b, radius, behind);
  const std::uint64_t near =
      blocks_ <= kFewBlocks ? (std::uint64_t{1} << blocks_) - 1 : boxTests().near(box_, blocks_, sweep);
  for (std::uint64_t rest = near & ~made_; rest != 0; rest &= rest - 1)
    make(static_cast<std::uint32_t>(std::countr_zero(rest)));
  const PrismsReached met = boxTests().reach(block_, near, sweep, reached.triangle);
  reached.blocks = met.blocks;
  reached.count = met.triangles;
}

}  // namespace hapticd
