// The descent's last step on a side: voxels' spheres are all as large, so sixteen are tested at once.
#include <bit>

#include "rt/contact/sphere_descent_run.h"

namespace hapticd {

void SphereDescentDetector::refineToVoxels(Run& run, bool side_a, const OctreeLevel& level,
                                           const Offsets& offset) HD_RT {
  const PointKernel& kernel = pointKernel();
  const Tree& fine = side_a ? run.a : run.b;
  const Tree& other = side_a ? run.b : run.a;
  const bool last = other.atVoxels();
  const float radius = fine.side() * kHalfDiagonal;
  BallSums sums{};
  std::uint32_t group = 0, made = 0;
  const auto add = [&]() HD_RT {
    float s[4];
    kernel.reduceBalls(sums, s);
    TouchGroup& g = groups_[std::min<std::uint32_t>(group, kMaxTouchGroups - 1)];
    g.weight += s[0];
    g.mean += 0.5 * Vec3(s[1], s[2], s[3]);
    sums = BallSums{};
  };
  for (std::uint32_t i = 0; i < run.pairs; ++i) {
    if (run.lateAt(i)) {
      run.report.dropped += run.pairs - i;
      break;
    }
    const Pair p = now_[i];
    if (last && p.group != group) {
      add();
      group = p.group;
    }
    const std::uint32_t node = side_a ? p.a : p.b;
    const Sphere mine = other.sphere(side_a ? p.b : p.a, side_a ? p.cb : p.ca);
    const float(&centre)[3] = side_a ? p.ca : p.cb;
    const float from[3] = {centre[0] - mine.x, centre[1] - mine.y, centre[2] - mine.z};
    const float both[3] = {p.ca[0] + p.cb[0], p.ca[1] + p.cb[1], p.ca[2] + p.cb[2]};
    std::uint32_t met = 0;
    for (std::uint32_t w = 0; w < maskWords(level.split); ++w) {
      const std::uint64_t mask = maskWord(level, OctreeMask::kSurface, node, w);
      run.tests += static_cast<std::uint32_t>(std::popcount(mask));
      const BallTable balls{offset.x + 64 * w, offset.y + 64 * w, offset.z + 64 * w, radius + mine.r};
      std::uint64_t hits = kernel.meet(balls, from, both, mask, last ? &sums : nullptr);
      met += static_cast<std::uint32_t>(std::popcount(hits));
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
    if (p.a != run.last_a) groups_[std::min<std::uint32_t>(p.group, kMaxTouchGroups - 1)].area += run.voxel_area;
    run.last_a = p.a;
    if (run.query.first_only) break;
  }
  if (last) add();
  std::swap(now_, next_);
  run.pairs = made;
}

}  // namespace hapticd
