// The descent's last step on a side: voxels' spheres are all as large, so sixteen are tested at once.
#include <algorithm>
#include <bit>

#include "rt/contact/sphere_descent_run.h"

namespace hapticd {

namespace {

std::uint32_t bitsOf(std::uint64_t mask) HD_RT { return static_cast<std::uint32_t>(std::popcount(mask)); }

}  // namespace

/** What met, kept apart for the group at hand. */
struct SphereDescentDetector::Met {
  explicit Met(std::vector<TouchGroup>& to) HD_RT : groups(to) {}

  /** Those of another group come next: adds up what there is. */
  void turnTo(std::uint32_t next) HD_RT {
    if (next == group) return;
    add();
    group = next;
  }
  void add() HD_RT {
    float s[4];
    kernel.reduceBalls(sums, s);
    here().weight += s[0];
    here().mean += Vec3(s[1], s[2], s[3]);
    sums = BallSums{};
  }
  [[nodiscard]] TouchGroup& here() const HD_RT { return groups[std::min<std::uint32_t>(group, kMaxTouchGroups - 1)]; }

  std::vector<TouchGroup>& groups;
  const PointKernel& kernel = pointKernel();
  std::uint32_t group = 0;
  BallSums sums{};
};

/** Whether a voxel of A touches for the first time: its area counts once, however many of B it meets. */
bool SphereDescentDetector::isNew(const Run& run, std::uint32_t voxel_a) HD_RT {
  const OctreeLevel& level = run.a.tree.level[run.a.tree.levels - 1];
  const std::size_t word = std::size_t{voxel_a >> 9} * maskWords(level.split) + (voxel_a >> 6 & 7);
  const std::uint64_t bit = std::uint64_t{1} << (voxel_a & 63);
  if (word >= seen_.size()) return true;
  const bool fresh = (seen_[word] & bit) == 0;
  seen_[word] |= bit;
  return fresh;
}

void SphereDescentDetector::refineToVoxels(Run& run, bool side_a, const OctreeLevel& level,
                                           const Offsets& offset) HD_RT {
  const Tree& fine = side_a ? run.a : run.b;
  const Tree& other = side_a ? run.b : run.a;
  const bool last = other.atVoxels();
  const float radius = fine.side() * kHalfDiagonal;
  std::uint32_t made = 0;
  Met all(groups_);
  if (last) std::fill_n(seen_.begin(), std::min<std::size_t>(seen_.size(), run.a.voxelMasks()), 0);
  for (std::uint32_t i = 0; i < run.pairs; ++i) {
    if (run.lateAt(i)) {
      run.report.dropped += run.pairs - i;
      break;
    }
    const Pair p = now_[i];
    if (last) all.turnTo(p.group);
    const std::uint32_t node = side_a ? p.a : p.b;
    const Sphere mine = other.sphere(side_a ? p.b : p.a, side_a ? p.cb : p.ca);
    const float(&centre)[3] = side_a ? p.ca : p.cb;
    const float from[3] = {centre[0] - mine.x, centre[1] - mine.y, centre[2] - mine.z};
    std::uint32_t met = 0;
    for (std::uint32_t w = 0; w < maskWords(level.split); ++w) {
      const std::uint64_t mask = maskWord(level, OctreeMask::kSurface, node, w);
      run.tests += bitsOf(mask);
      const BallTable balls{offset.x + 64 * w, offset.y + 64 * w, offset.z + 64 * w, radius + mine.r,
                            side_a ? 1.0F : 0.0F};
      std::uint64_t hits = all.kernel.meet(balls, from, p.ca, mask, last ? &all.sums : nullptr);
      met += bitsOf(hits);
      for (std::uint64_t own = last && side_a ? hits : 0; own != 0; own &= own - 1) {
        const std::uint32_t place = 64 * w + static_cast<std::uint32_t>(std::countr_zero(own));
        if (isNew(run, node << 9 | place)) all.here().area += run.voxel_area;
      }
      for (; !last && hits != 0; hits &= hits - 1) {
        const std::uint32_t place = 64 * w + static_cast<std::uint32_t>(std::countr_zero(hits));
        if (made == next_.size()) {
          ++run.report.dropped;
          run.report.exhausted = true;
          continue;
        }
        Pair& q = next_[made++];
        q = p;
        // Voxels are told apart by their parent and place: the last level has no numbers of its own.
        (side_a ? q.a : q.b) = node << 9 | place;
        float(&c)[3] = side_a ? q.ca : q.cb;
        c[0] += offset.x[place];
        c[1] += offset.y[place];
        c[2] += offset.z[place];
      }
    }
    if (!last || met == 0) continue;
    run.report.touching += met;
    if (!side_a && isNew(run, p.a)) all.here().area += run.voxel_area;
    if (run.query.first_only) break;
  }
  if (last) all.add();
  std::swap(now_, next_);
  run.pairs = made;
}

}  // namespace hapticd
