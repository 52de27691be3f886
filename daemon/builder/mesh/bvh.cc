#include "daemon/builder/mesh/bvh.h"

#include <Eigen/Core>
#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>

namespace hapticd {
namespace {

using Vec4 = Eigen::Array4f;  // one SSE or NEON register; the fourth lane is not used

constexpr int kBins = 16;

struct Box {
  Vec4 lower = Vec4::Constant(std::numeric_limits<float>::infinity());
  Vec4 upper = Vec4::Constant(-std::numeric_limits<float>::infinity());

  void add(const Vec4& l, const Vec4& u) {
    lower = lower.min(l);
    upper = upper.max(u);
  }
  void add(const Box& other) { add(other.lower, other.upper); }
  [[nodiscard]] float halfArea() const {
    const Vec4 d = upper - lower;
    return d[0] * d[1] + d[1] * d[2] + d[2] * d[0];
  }
};

/** A triangle's box, moved about whole while partitioning: reading stays sequential. */
struct Item {
  Vec4 lower, upper;  // the number of the triangle is in the fourth lane of lower

  [[nodiscard]] Vec4 centre() const { return lower + upper; }  // doubled: only compared
  [[nodiscard]] std::uint32_t triangle() const { return std::bit_cast<std::uint32_t>(lower[3]) - kNormal; }
  void setTriangle(std::uint32_t t) { lower[3] = std::bit_cast<float>(t + kNormal); }

 private:
  static constexpr std::uint32_t kNormal =
      0x3f800000;  ///< 1.0f: as denormals, small numbers would slow every addition.
};

struct Range {
  std::uint32_t node, begin, end, depth;
  Box box, centres;
  [[nodiscard]] std::uint32_t size() const { return end - begin; }
};

/** Levels that a median-split tree over n triangles needs below its root. */
std::uint32_t levelsFor(std::uint32_t n) {
  const std::uint32_t leaves = (n + HD_BVH_LEAF_TRIANGLES - 1) / HD_BVH_LEAF_TRIANGLES;
  return static_cast<std::uint32_t>(
      std::bit_width(leaves - 1));  // 8 * 2^k triangles fit under k levels, halves rounded up too
}

class Builder {
 public:
  Builder(const Mesh& mesh, const std::function<bool(float)>& progress) : progress_(progress) {
    items_.resize(mesh.triangles.size());
    bin_.resize(items_.size());
    for (std::uint32_t t = 0; t < items_.size(); ++t) {
      const auto corner = [&](int c) {
        const Float3& p = mesh.vertices[mesh.triangles[t][c]];
        return Vec4(p[0], p[1], p[2], 0);
      };
      const Vec4 a = corner(0), b = corner(1), c = corner(2);
      items_[t].lower = a.min(b).min(c);
      items_[t].upper = a.max(b).max(c);
      items_[t].setTriangle(t);
    }
  }

  Bvh run() {
    Bvh bvh;
    std::vector<BinaryNode> nodes;
    const auto count = static_cast<std::uint32_t>(items_.size());
    nodes.reserve(count);
    nodes.emplace_back();
    Range root{0, 0, count, 1, {}, {}};
    for (const Item& item : items_) grow(root, item);
    std::vector<Range> stack{root};
    std::uint32_t reported = 0;
    while (!stack.empty()) {
      const Range range = stack.back();
      stack.pop_back();
      setBox(nodes[range.node], range.box);
      if (range.size() <= HD_BVH_LEAF_TRIANGLES) {
        nodes[range.node].first = range.begin;
        nodes[range.node].count = range.size();
        if (range.end - reported >= 32768) {
          reported = range.end;
          if (!progress_(static_cast<float>(range.end) / static_cast<float>(count))) return {};
        }
        continue;
      }
      auto [left, right] = split(range);
      left.node = static_cast<std::uint32_t>(nodes.size());
      right.node = left.node + 1;
      nodes[range.node].first = left.node;
      nodes[range.node].count = 0;
      nodes.resize(nodes.size() + 2);
      stack.push_back(right);
      stack.push_back(left);  // next: places are filled from left to right
    }
    bvh.nodes = widen(nodes, bvh.depth);
    bvh.order.reserve(count);
    for (const Item& item : items_) bvh.order.push_back(item.triangle());
    return bvh;
  }

 private:
  static void grow(Range& range, const Item& item) {
    range.box.add(item.lower, item.upper);
    const Vec4 centre = item.centre();
    range.centres.add(centre, centre);
  }

  static void setBox(BinaryNode& node, const Box& box) {
    std::memcpy(node.lower, box.lower.data(), sizeof node.lower);
    std::memcpy(node.upper, box.upper.data(), sizeof node.upper);
  }

  std::pair<Range, Range> split(const Range& range) {
    const Vec4 extent = range.centres.upper - range.centres.lower;
    int axis = extent[0] >= extent[1] ? 0 : 1;
    if (extent[2] > extent[axis]) axis = 2;
    if (extent[axis] > 0) {
      auto halves = splitByBins(range, axis, extent[axis]);
      if (fits(halves.first) && fits(halves.second)) return halves;
    }
    return splitAtMedian(range, axis);
  }

  static bool fits(const Range& half) {
    return half.size() > 0 && half.depth + levelsFor(half.size()) <= HD_BVH_MAX_DEPTH;
  }

  std::pair<Range, Range> splitByBins(const Range& range, int axis, float extent) {
    Box box[kBins];
    std::uint32_t count[kBins] = {};
    const float scale = kBins / extent, origin = range.centres.lower[axis];
    if (!(scale <= std::numeric_limits<float>::max())) return {};
    for (std::uint32_t i = range.begin; i < range.end; ++i) {
      const Item& item = items_[i];
      const float x = (item.lower[axis] + item.upper[axis] - origin) * scale;
      const int b = std::min(static_cast<int>(x), kBins - 1);  // x >= 0, and finite as scale is
      bin_[i] = static_cast<std::uint8_t>(b);
      box[b].add(item.lower, item.upper);
      ++count[b];
    }
    // Cost of a cut after bin k: area times count on both sides.
    Box right, right_of[kBins];
    float right_cost[kBins] = {};
    std::uint32_t right_count = 0;
    for (int k = kBins - 1; k > 0; --k) {
      if (count[k] != 0) right.add(box[k]);
      right_count += count[k];
      right_of[k - 1] = right;
      right_cost[k - 1] = right_count == 0 ? 0 : right.halfArea() * static_cast<float>(right_count);
    }
    Box left, left_of_cut;
    std::uint32_t left_count = 0;
    int cut = -1;
    float least = std::numeric_limits<float>::infinity();
    for (int k = 0; k + 1 < kBins; ++k) {
      if (count[k] == 0) continue;  // the same cut as the one before
      left.add(box[k]);
      left_count += count[k];
      if (left_count == range.size()) break;
      const float cost = left.halfArea() * static_cast<float>(left_count) + right_cost[k];
      if (cost < least) {
        least = cost;
        cut = k;
        left_of_cut = left;
      }
    }
    if (cut < 0) return {};
    auto halves = partition(range, cut);
    halves.first.box = left_of_cut;
    halves.second.box = right_of[cut];
    return halves;
  }

  /** Bins up to `cut` go left. Leaves the halves' own boxes to the caller, who knows them from the bins. */
  std::pair<Range, Range> partition(const Range& range, int cut) {
    Range left{0, range.begin, range.begin, range.depth + 1, {}, {}};
    Range right{0, range.end, range.end, range.depth + 1, {}, {}};
    while (left.end < right.begin) {
      Item& item = items_[left.end];
      const Vec4 centre = item.centre();
      if (bin_[left.end] <= cut) {
        left.centres.add(centre, centre);
        ++left.end;
      } else {
        right.centres.add(centre, centre);
        std::swap(item, items_[--right.begin]);
        bin_[left.end] = bin_[right.begin];
      }
    }
    return {left, right};
  }

  std::pair<Range, Range> splitAtMedian(const Range& range, int axis) {
    const auto begin = items_.begin() + range.begin, end = items_.begin() + range.end;
    const auto middle = begin + range.size() / 2;
    std::nth_element(begin, middle, end, [axis](const Item& a, const Item& b) {
      const float x = a.lower[axis] + a.upper[axis], y = b.lower[axis] + b.upper[axis];
      return x != y ? x < y : a.triangle() < b.triangle();
    });
    Range left{0, range.begin, range.begin + range.size() / 2, range.depth + 1, {}, {}};
    Range right{0, left.end, range.end, range.depth + 1, {}, {}};
    for (auto i = begin; i != middle; ++i) grow(left, *i);
    for (auto i = middle; i != end; ++i) grow(right, *i);
    return {left, right};
  }

  const std::function<bool(float)>& progress_;
  std::vector<Item> items_;
  std::vector<std::uint8_t> bin_;  ///< Of each item, while its range is split.
};

}  // namespace

Bvh buildBvh(const Mesh& mesh, const std::function<bool(float)>& progress) { return Builder(mesh, progress).run(); }

}  // namespace hapticd
