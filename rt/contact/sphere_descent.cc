#include "rt/contact/sphere_descent.h"

#include <algorithm>

#include "rt/contact/sphere_descent_run.h"
#include "rt/volume/distance.h"

namespace hapticd {
namespace {

constexpr std::uint32_t kFew = 32;  // Pairs of a level that are followed first when one touch is enough.

}  // namespace

SphereDescentDetector::SphereDescentDetector(const SphereDescentOptions& options)
    : options_(options),
      now_(options.max_pairs),
      next_(options.max_pairs),
      urgency_(options.max_pairs),
      sorted_(options.max_pairs),
      groups_(kMaxTouchGroups),
      part_(kMaxTouchGroups),
      seen_(options.max_pairs),
      x_(kFieldBuffer),
      y_(kFieldBuffer),
      z_(kFieldBuffer),
      area_(kFieldBuffer) {}

SphereDescentDetector::~SphereDescentDetector() = default;

void SphereDescentDetector::find(const DetectorQuery& query, ContactSet& contacts) HD_RT {
  contacts.report = DetectorReport{};
  map_.build(*query.a.volume);
  for (std::uint32_t g = 0; g < map_.count(); ++g) groups_[g] = TouchGroup{};
  const Vec3 from = query.b.X_WO.p;
  Tree a(*query.a.volume, query.a.X_WO, from, options_.tight), b(*query.b.volume, query.b.X_WO, from, options_.tight);
  Run run{query, contacts.report, a, b};
  run.voxel_area = a.view.header->area / std::max(1u, a.view.header->surface_voxels);
  if (options_.leaf == SphereLeaf::kFieldValue) {
    walkField(run);
  } else {
    a.turnTightCentres();
    b.turnTightCentres();
    std::fill_n(seen_.begin(), std::min<std::size_t>(seen_.size(), a.voxelMasks()), 0);
    descend(run);
  }
  sum(run, contacts);
  run.report.work = static_cast<std::uint32_t>((run.tests + 15) / 16);
  ages_.follow(contacts);
}

void SphereDescentDetector::descend(Run& run) HD_RT {
  if (run.query.first_only) {
    walk(run, kFew);
    if (run.report.touching > 0) return;
    run.a.level = run.b.level = 0;
  }
  walk(run, options_.max_pairs);
}

/** From the roots down, with `most` pairs of each level. */
void SphereDescentDetector::walk(Run& run, std::uint32_t most) HD_RT {
  Pair& root = now_[0];
  root = Pair{};
  for (int k = 0; k < 3; ++k) {
    root.ca[k] = static_cast<float>(run.a.root[k]);
    root.cb[k] = static_cast<float>(run.b.root[k]);
  }
  run.pairs = 1;
  while (run.pairs > 0 && !(run.a.atVoxels() && run.b.atVoxels())) {
    const bool last_b = !run.b.atVoxels() && run.b.level + 1 == run.b.tree.levels;
    const bool side_a = !run.a.atVoxels() && (run.b.atVoxels() || last_b || run.a.side() >= run.b.side());
    if (last_b && side_a && run.a.level + 1 == run.a.tree.levels && most == options_.max_pairs && !run.limited() &&
        options_.threshold <= 0 && !run.late()) {
      meetVoxels(run);
      return;
    }
    choose(run, side_a);
    if (run.pairs > most) keepNearest(run, most);
    refine(run, side_a);
    if (run.query.first_only && run.report.touching > 0) return;
  }
}

/** The pairs whose centres are nearest. */
void SphereDescentDetector::keepNearest(Run& run, std::uint32_t most) HD_RT {
  for (std::uint32_t i = 0; i < run.pairs; ++i) {
    const Pair& p = now_[i];
    const float x = p.ca[0] - p.cb[0], y = p.ca[1] - p.cb[1], z = p.ca[2] - p.cb[2];
    sorted_[i] = urgency_[i] = x * x + y * y + z * z;
  }
  std::nth_element(sorted_.begin(), sorted_.begin() + most, sorted_.begin() + run.pairs);
  const float limit = sorted_[most];
  std::uint32_t kept = 0;
  for (std::uint32_t i = 0; i < run.pairs; ++i)
    if (urgency_[i] < limit) now_[kept++] = now_[i];
  run.pairs = kept > 0 ? kept : most;  // Many alike: the first of them.
}

/** Leaves what need not, or cannot, be refined as contacts of their size. */
void SphereDescentDetector::choose(Run& run, bool side_a) HD_RT {
  const Tree& refined = side_a ? run.a : run.b;
  const std::uint32_t places = 1u << (3 * refined.tree.level[refined.level].split);
  // Each node refined costs at most all its places, each left one test.
  const std::uint64_t tests = std::uint64_t{16} * run.unitsLeft();
  const std::uint64_t room = run.query.budget.units == 0 ? run.pairs
                             : tests > run.pairs         ? (tests - run.pairs) / places
                                                         : 0;
  const std::uint32_t keep = run.late() ? 0 : static_cast<std::uint32_t>(std::min<std::uint64_t>(room, run.pairs));
  std::uint64_t leave = run.query.budget.units == 0 ? run.pairs : tests;  // Of those left, as many are looked at.
  if (keep == run.pairs && options_.threshold <= 0) return;
  for (std::uint32_t i = 0; i < run.pairs; ++i) {
    const Pair& p = now_[i];
    const hd_octree_sensation* const sa = run.a.sensation(p.a);
    const hd_octree_sensation* const sb = run.b.sensation(p.b);
    if (sa != nullptr || sb != nullptr) {
      const float phi = std::max(sa != nullptr ? sa->empty : 0, sb != nullptr ? sb->empty : 0);
      const float area = std::max(sa != nullptr ? sa->support_area : 0, sb != nullptr ? sb->support_area : 0);
      urgency_[i] = phi / std::max(area, 1e-12F);
    } else {
      const float x = p.ca[0] - p.cb[0], y = p.ca[1] - p.cb[1], z = p.ca[2] - p.cb[2];
      urgency_[i] = 1 / (1e-12F + x * x + y * y + z * z);
    }
  }
  auto limit = static_cast<float>(options_.threshold);
  if (keep < run.pairs) {
    run.report.exhausted = true;
    // The keep-th largest: what is equal to it is left as well, so that the bound holds.
    std::copy_n(urgency_.begin(), run.pairs, sorted_.begin());
    std::nth_element(sorted_.begin(), sorted_.begin() + keep, sorted_.begin() + run.pairs, std::greater<>());
    limit = std::max(limit, sorted_[keep]);
  }
  std::uint32_t kept = 0;
  for (std::uint32_t i = 0; i < run.pairs; ++i) {
    if (urgency_[i] > limit) {
      now_[kept++] = now_[i];
      continue;
    }
    if (leave == 0) {
      ++run.report.dropped;
      continue;
    }
    --leave;
    ++run.tests;
    run.report.coarsest =
        std::max<double>({run.report.coarsest, run.a.side(), run.field == nullptr ? run.b.side() : 0});
    if (run.field != nullptr) {
      --run.tests;  // Counted when they are looked up.
      lookUp(run, now_[i]);
      continue;
    }
    const Sphere sa = run.a.sphere(now_[i].a, now_[i].ca), sb = run.b.sphere(now_[i].b, now_[i].cb);
    const float x = sa.x - sb.x, y = sa.y - sb.y, z = sa.z - sb.z;
    touch(run, now_[i], std::sqrt(x * x + y * y + z * z), sa.r + sb.r);
  }
  run.pairs = kept;
}

/** One level down on one side. */
void SphereDescentDetector::refine(Run& run, bool side_a) HD_RT {
  Tree& fine = side_a ? run.a : run.b;
  Tree& other = side_a ? run.b : run.a;
  const OctreeLevel& level = fine.tree.level[fine.level];
  Offsets offset;
  fine.placesOf(offset);
  Tree& below = fine;  // Its spheres are asked for after its level has moved on.
  std::uint32_t made = 0;
  ++below.level;
  const bool last = run.a.atVoxels() && run.b.atVoxels();
  if (below.atVoxels() && !(last && side_a)) {
    refineToVoxels(run, side_a, level, offset);
    return;
  }
  const bool regroup = side_a && run.a.level < map_.levels();
  if (regroup) findParts(run.a.level);
  for (std::uint32_t i = 0; i < run.pairs; ++i) {
    if (run.lateAt(i)) {
      run.report.dropped += run.pairs - i;
      break;
    }
    const Pair p = now_[i];
    const Sphere mine = other.sphere(side_a ? p.b : p.a, side_a ? p.cb : p.ca);
    const float(&centre)[3] = side_a ? p.ca : p.cb;
    std::uint32_t tested = 0;
    forEachChild(level, side_a ? p.a : p.b, [&](std::uint32_t place, std::uint32_t child) HD_RT {
      ++tested;
      Pair q = p;
      float(&c)[3] = side_a ? q.ca : q.cb;
      c[0] = centre[0] + offset.x[place];
      c[1] = centre[1] + offset.y[place];
      c[2] = centre[2] + offset.z[place];
      const Sphere s = below.sphere(child, c);
      const float x = s.x - mine.x, y = s.y - mine.y, z = s.z - mine.z;
      const float squared = x * x + y * y + z * z, reach = s.r + mine.r;
      if (squared > reach * reach) return;
      // Voxels are told apart by their parent and place: the last level has no numbers of its own.
      (side_a ? q.a : q.b) = below.atVoxels() ? (side_a ? p.a : p.b) << 9 | place : child;
      if (regroup) q.group = part_[child];
      if (last) {
        touch(run, q, std::sqrt(squared), reach);
      } else if (made < next_.size()) {
        next_[made++] = q;
      } else {
        ++run.report.dropped;
        run.report.exhausted = true;
      }
    });
    run.tests += tested;
    if (last && run.query.first_only && run.report.touching > 0) return;
  }
  std::swap(now_, next_);
  run.pairs = last ? 0 : made;
}

void SphereDescentDetector::touch(Run& run, const Pair& p, float distance, float reach) HD_RT {
  ++run.report.touching;
  TouchGroup& g = groups_[std::min<std::uint32_t>(p.group, kMaxTouchGroups - 1)];
  const double weight = static_cast<double>(reach) - distance;  // t - d of eq. 3.1
  g.weight += weight;
  g.mean += 0.5 * weight * (Vec3(p.ca[0], p.ca[1], p.ca[2]) + Vec3(p.cb[0], p.cb[1], p.cb[2]));
  if (p.a == run.last_a) return;
  run.last_a = p.a;
  const double cells = run.a.side() / run.a.view.voxel;
  g.area += run.voxel_area * cells * cells;
}

void SphereDescentDetector::findParts(std::uint32_t level) HD_RT {
  const std::uint32_t up = map_.levels() - 1 - level;
  for (std::uint32_t i = map_.count(); i-- > 0;) part_[map_.ancestor(i, up)] = i;
}

void SphereDescentDetector::sum(Run& run, ContactSet& contacts) HD_RT {
  const VolumeView& b = run.b.view;
  const Quat q_BW = run.query.b.X_WO.q.conjugate();
  std::uint32_t count = 0;
  for (std::uint32_t g = 0; g < map_.count(); ++g) {
    TouchGroup group = groups_[g];
    if (group.weight <= 0) continue;
    group.part = g;
    group.mean /= group.weight;
    if (options_.leaf == SphereLeaf::kSphere) {
      group.mean = q_BW * group.mean;
      const DistanceSample s = distanceAt(b, group.mean);
      const double n = s.gradient.norm();
      const Vec3 out = n > 0 ? Vec3(s.gradient / n) : Vec3::UnitZ();
      group.deepest = -s.value;
      group.normal = out * group.weight;
      group.integral.force = group.area * std::max(group.deepest, 0.0) * out;
      group.integral.torque = group.mean.cross(group.integral.force);
    }
    group.face = faceOf(run.query.a.X_WO.q.conjugate() * (run.query.b.X_WO.q * group.normal));
    groups_[count++] = group;
  }
  answer(run.query, map_, groups_, count, Clustering::kOctree, contacts);
}

}  // namespace hapticd
