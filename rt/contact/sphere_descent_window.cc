// The descent's last steps on both sides in one: each voxel of a node of A against the voxels of B right about it.
#include <bit>
#include <cmath>
#include <cstring>

#include "rt/contact/sphere_descent_run.h"

namespace hapticd {
namespace {

/**
 * Calls visit(word, w, x, y, z) for the words of the masks of all last nodes below a node whose lower corner is (x, y,
 * z) [voxel]; of those alone for which wanted(x, y, z, side) holds.
 */
template <class Wanted, class Visit>
void forEachMask(const OctreeView& tree, std::uint32_t level, std::uint32_t node, int x, int y, int z,
                 const Wanted& wanted, const Visit& visit) HD_RT {
  const OctreeLevel& l = tree.level[level];
  if (!wanted(x, y, z, 1 << l.side_log2)) return;
  if (level + 1 == tree.levels) {
    for (std::uint32_t w = 0; w < maskWords(l.split); ++w) {
      const std::uint64_t word = maskWord(l, OctreeMask::kSurface, node, w);
      if (word != 0) visit(word, w, x, y, z);
    }
    return;
  }
  const int side = 1 << (l.side_log2 - l.split);
  forEachChild(l, node, [&](std::uint32_t place, std::uint32_t child) HD_RT {
    const ChildPlace k = childPlace(l.split, place);
    forEachMask(tree, level + 1, child, x + side * static_cast<int>(k.x), y + side * static_cast<int>(k.y),
                z + side * static_cast<int>(k.z), wanted, visit);
  });
}

/** The voxels of B about a node of A, one bit each: x along a word, then y, then z. */
struct Window {
  static constexpr int kEdge = static_cast<int>(kWindow);
  std::uint32_t row[kWindow * kWindow];

  /** A word of the masks of a node of 2^split voxels a side; its corner may lie outside. */
  void paint(std::uint64_t word, std::uint32_t w, std::uint32_t split, int x, int y, int z) HD_RT {
    if (split == 2) {
      // Aligned: all of it is inside. Two rows at a time.
      std::uint32_t* at = row + y + kEdge * z;
      for (int k = 0; k < 4; ++k, word >>= 16, at += kEdge) {
        const std::uint64_t rows[2] = {(word & 0xf) | (word & 0xf0) << 28, (word >> 8 & 0xf) | (word >> 8 & 0xf0)
                                                                                                   << 28};
        for (int j = 0; j < 2; ++j) {
          std::uint64_t both;
          std::memcpy(&both, at + 2 * j, sizeof both);
          both |= rows[j] << x;
          std::memcpy(at + 2 * j, &both, sizeof both);
        }
      }
      return;
    }
    for (; word != 0; word &= word - 1) {
      const ChildPlace k = childPlace(split, 64 * w + static_cast<std::uint32_t>(std::countr_zero(word)));
      const int i = x + static_cast<int>(k.x), j = y + static_cast<int>(k.y), l = z + static_cast<int>(k.z);
      if (std::min({i, j, l}) < 0 || std::max({i, j, l}) >= kEdge) continue;
      row[j + kEdge * l] |= 1u << i;
    }
  }
};

constexpr float kSpan = 12;  // Of a node of A from the window's middle: two voxels of aligning and two about it remain.
constexpr std::uint32_t kTestsAVoxel = 64;

}  // namespace

/** Whether what is left can be done so: nodes small enough, parts of A told apart, enough budget. */
bool SphereDescentDetector::windowsFit(const Run& run) const HD_RT {
  const Tree &a = run.a, &b = run.b;
  if (a.atVoxels() || b.atVoxels() || a.level + 1 < map_.levels()) return false;
  if (a.tree.level[a.level].side_log2 > 3 || b.tree.level[b.level].side_log2 > 3) return false;
  if (kHalfDiagonal * (a.scale + b.scale) >= 2 || kHalfDiagonal * a.side() > kSpan) return false;
  if (!run.limited()) return true;
  std::uint64_t tests = 0;
  for (std::uint32_t i = 0; i < run.pairs; ++i) {
    if (i > 0 && now_[i].a == now_[i - 1].a) continue;
    forEachMask(
        a.tree, a.level, now_[i].a, 0, 0, 0, [](int, int, int, int) HD_RT { return true; },
        [&](std::uint64_t word, std::uint32_t, int, int, int)
            HD_RT { tests += kTestsAVoxel * static_cast<std::uint32_t>(std::popcount(word)); });
  }
  return tests <= std::uint64_t{16} * run.unitsLeft();
}

void SphereDescentDetector::meetWindows(Run& run) HD_RT {
  const OctreeView &tree_a = run.a.tree, &tree_b = run.b.tree;
  const std::uint32_t split_a = tree_a.level[tree_a.levels - 1].split, split_b = tree_b.level[tree_b.levels - 1].split;
  const int side_a = 1 << tree_a.level[run.a.level].side_log2;
  const float half_b = 0.5F * run.b.side();
  // Voxels of A from the lower corner of a node, by x + 8 (y + 8 z); those of a last node from its own.
  alignas(16) Eigen::Array4f place[512];
  std::uint16_t within[512];
  for (std::uint32_t p = 0; p < 512; ++p) {
    const ChildPlace k = childPlace(3, p);
    const Vec3 v = run.a.offsets.turned(Vec3(k.x + 0.5, k.y + 0.5, k.z + 0.5)) * run.a.scale;
    place[p] << v.cast<float>().array(), 0.0F;
    const ChildPlace q = childPlace(split_a, p);
    within[p] = static_cast<std::uint16_t>(q.x + 8 * (q.y + 8 * q.z));
  }
  const Vec3 corner = run.a.offsets.turned(Vec3::Constant(-0.5 * side_a)) * run.a.scale;
  const PointKernel& kernel = pointKernel();
  alignas(64) Window window;
  std::uint32_t end = 0;
  for (std::uint32_t i = 0; i < run.pairs; i = end) {
    if (run.late()) {
      run.report.exhausted = true;
      run.report.dropped += run.pairs - i;
      break;
    }
    const Pair& p = now_[i];
    int origin[3];
    Eigen::Array4f from = Eigen::Array4f::Zero();
    for (int k = 0; k < 3; ++k) {
      origin[k] = 4 * static_cast<int>(std::floor(0.25F * (p.ca[k] - 14)));
      from[k] = p.ca[k] - static_cast<float>(origin[k]) + static_cast<float>(corner[k]);
    }
    Eigen::Array4f low = Eigen::Array4f::Constant(1e9F), high = -low;
    std::uint32_t count = 0;
    forEachMask(
        tree_a, run.a.level, p.a, 0, 0, 0, [](int, int, int, int) HD_RT { return true; },
        [&](std::uint64_t word, std::uint32_t w, int x, int y, int z) HD_RT {
          const int base = x + 8 * (y + 8 * z);
          for (; word != 0; word &= word - 1) {
            const int at = base + within[64 * w + static_cast<std::uint32_t>(std::countr_zero(word))];
            const Eigen::Array4f v = from + place[at];
            low = low.min(v);
            high = high.max(v);
            x_[count] = v[0];
            y_[count] = v[1];
            z_[count++] = v[2];
          }
        });
    int first[3], last[3];  // Voxels of B that any of these may meet.
    for (int k = 0; k < 3; ++k) {
      first[k] = static_cast<int>(low[k] - 2);
      last[k] = std::min(static_cast<int>(high[k] + 2), Window::kEdge - 1);
    }
    std::fill_n(window.row, kWindow * kWindow, 0u);
    for (end = i; end < run.pairs && now_[end].a == p.a; ++end) {
      const Pair& q = now_[end];
      const auto at = [&](int k) HD_RT { return static_cast<int>(q.cb[k] - half_b) - origin[k]; };
      forEachMask(
          tree_b, run.b.level, q.b, at(0), at(1), at(2),
          [&](int x, int y, int z, int side) HD_RT {
            return x <= last[0] && y <= last[1] && z <= last[2] && x + side > first[0] && y + side > first[1] &&
                   z + side > first[2];
          },
          [&](std::uint64_t word, std::uint32_t w, int x, int y, int z)
              HD_RT { window.paint(word, w, split_b, x, y, z); });
    }
    WindowSums sums{};
    kernel.meetWindow({window.row, x_.data(), y_.data(), z_.data(), kHalfDiagonal * (run.a.scale + run.b.scale)}, count,
                      run.query.first_only, sums);
    run.tests += std::uint64_t{kTestsAVoxel} * count;
    if (sums.pairs == 0) continue;
    float s[4];
    kernel.reduceBalls(sums.balls, s);
    TouchGroup& g = groups_[std::min<std::uint32_t>(p.group, kMaxTouchGroups - 1)];
    g.weight += s[0];
    g.mean += s[0] * Vec3(origin[0], origin[1], origin[2]) + Vec3(s[1], s[2], s[3]);
    g.area += run.voxel_area * sums.voxels;
    run.report.touching += sums.pairs;
    if (run.query.first_only) break;
  }
  run.a.level = run.a.tree.levels;
  run.b.level = run.b.tree.levels;
  run.pairs = 0;
}

}  // namespace hapticd
