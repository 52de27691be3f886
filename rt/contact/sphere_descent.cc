#include "rt/contact/sphere_descent.h"

#include <algorithm>
#include <bit>

#include "rt/contact/sphere_descent_run.h"
#include "rt/volume/distance.h"

namespace hapticd {
namespace {

constexpr std::uint32_t kFewPairs = 32;  // Pairs of a level that are followed first when one touch is enough.

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
      area_(kFieldBuffer) {
  for (auto& sphere : sphere_) sphere.resize(options.max_pairs + HD_POINT_PADDING);
}

SphereDescentDetector::~SphereDescentDetector() = default;

void SphereDescentDetector::find(const DetectorQuery& query, ContactSet& contacts) HD_RT {
  contacts.report = DetectorReport{};
  map_.build(*query.a.volume);
  for (std::uint32_t g = 0; g < map_.count(); ++g) groups_[g] = TouchGroup{};
  const bool one_sided = options_.leaf == SphereLeaf::kFieldValue;
  const VolumeView& volume_b = *query.b.volume;
  const Pose X_BA = query.b.X_WO.inverse() * query.a.X_WO;
  const Vec3 origin = one_sided ? Vec3::Zero() : volume_b.originPoint();
  const double unit = one_sided ? 1 : volume_b.voxel;
  Tree a(*query.a.volume, one_sided ? Pose{} : X_BA, origin, unit, options_.tight);
  Tree b(volume_b, Pose{}, origin, unit, options_.tight);
  Run run{query, contacts.report, a, b};
  run.unit = unit;
  run.voxel_area = a.view.header->area / std::max(1u, a.view.header->surface_voxels);
  if (one_sided) {
    walkField(run);
  } else {
    a.turnTightCentres();
    b.turnTightCentres();
    descend(run);
  }
  sum(run, contacts);
  run.report.work = static_cast<std::uint32_t>((run.tests + 15) / 16);
  ages_.follow(contacts);
}

void SphereDescentDetector::descend(Run& run) HD_RT {
  if (run.query.first_only) {
    walk(run, kFewPairs);
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
  // Far apart, or nowhere: what follows may rely on places near one another.
  const float far = kHalfDiagonal * (run.a.side() + run.b.side());
  const Vec3 between = run.a.root - run.b.root;
  if (!(between.squaredNorm() <= double{far} * far)) {
    run.pairs = 0;
    return;
  }
  run.pairs = 1;
  while (run.pairs > 0 && !(run.a.atVoxels() && run.b.atVoxels())) {
    if (options_.threshold <= 0 && windowsFit(run)) {
      meetWindows(run);
      return;
    }
    const bool side_a = !run.a.atVoxels() && (run.b.atVoxels() || run.a.side() >= run.b.side());
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
      urgency_[i] = 1 / (1e-6F + x * x + y * y + z * z);
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
    run.report.coarsest = std::max<double>(run.report.coarsest,
                                           run.unit * std::max(run.a.side(), run.field == nullptr ? run.b.side() : 0));
    if (run.field != nullptr) {
      lookUp(run, now_[i]);
      continue;
    }
    const Sphere sa = run.a.sphere(now_[i].a, now_[i].ca), sb = run.b.sphere(now_[i].b, now_[i].cb);
    const float x = sa.x - sb.x, y = sa.y - sb.y, z = sa.z - sb.z;
    touch(run, now_[i], std::sqrt(x * x + y * y + z * z), sa.r + sb.r);
  }
  run.pairs = kept;
}

inline void SphereDescentDetector::put(std::uint32_t at, const Sphere& s) HD_RT {
  sphere_[0][at] = s.x;
  sphere_[1][at] = s.y;
  sphere_[2][at] = s.z;
  sphere_[3][at] = s.r;
}

/** Bit i: the sphere put at `first` + i meets this one. */
inline std::uint64_t SphereDescentDetector::near(std::uint32_t first, std::uint32_t count,
                                                 const Sphere& s) const HD_RT {
  const SphereTable table{&sphere_[0][first], &sphere_[1][first], &sphere_[2][first], &sphere_[3][first]};
  return pointKernel().near(table, count, {s.x, s.y, s.z}, s.r);
}

/** One level down on one side. */
void SphereDescentDetector::refine(Run& run, bool side_a) HD_RT {
  Tree& fine = side_a ? run.a : run.b;
  const OctreeLevel& level = fine.tree.level[fine.level];
  Offsets offset;
  fine.placesOf(offset);
  ++fine.level;  // Spheres of the children are asked for.
  if (fine.atVoxels()) {
    refineToVoxels(run, side_a, level, offset);
  } else if (side_a) {
    refineA(run, level, offset);
  } else {
    refineB(run, level, offset);
  }
}

/** Pairs of one node of A follow one another, and so do those of its children: one sphere against many. */
void SphereDescentDetector::refineA(Run& run, const OctreeLevel& level, const Offsets& offset) HD_RT {
  const bool regroup = run.a.level < map_.levels();
  if (regroup) findParts(run.a.level);
  std::uint32_t made = 0, end = 0;
  for (std::uint32_t i = 0; i < run.pairs; i = end) {
    const Pair& p = now_[i];
    for (end = i; end < run.pairs && now_[end].a == p.a; ++end) put(end - i, run.b.sphere(now_[end].b, now_[end].cb));
    bool late = false;
    forEachChild(level, p.a, [&](std::uint32_t place, std::uint32_t child) HD_RT {
      late = late || run.late();
      if (late) return;
      const float c[3] = {p.ca[0] + offset.x[place], p.ca[1] + offset.y[place], p.ca[2] + offset.z[place]};
      const Sphere s = run.a.sphere(child, c);
      run.tests += end - i;
      for (std::uint32_t first = i; first < end; first += 64) {
        for (std::uint64_t hits = near(first - i, std::min(64u, end - first), s); hits != 0; hits &= hits - 1) {
          Pair q = now_[first + static_cast<std::uint32_t>(std::countr_zero(hits))];
          q.a = child;
          std::copy_n(c, 3, q.ca);
          if (regroup) q.group = part_[child];
          push(run, q, made);
        }
      }
    });
    if (!late) continue;
    run.report.exhausted = true;
    run.report.dropped += run.pairs - i;
    break;
  }
  std::swap(now_, next_);
  run.pairs = made;
}

/** The children of each pair's node of B, many spheres against one. */
void SphereDescentDetector::refineB(Run& run, const OctreeLevel& level, const Offsets& offset) HD_RT {
  std::uint32_t made = 0;
  for (std::uint32_t i = 0; i < run.pairs; ++i) {
    if (run.lateAt(i)) {
      run.report.dropped += run.pairs - i;
      break;
    }
    Pair q = now_[i];
    const float centre[3] = {q.cb[0], q.cb[1], q.cb[2]};
    const Sphere s = run.a.sphere(q.a, q.ca);
    std::uint32_t count = 0;
    const std::uint32_t first_child = level.first[q.b];
    std::uint16_t places[512];
    forEachChild(level, q.b, [&](std::uint32_t place, std::uint32_t child) HD_RT {
      const float c[3] = {centre[0] + offset.x[place], centre[1] + offset.y[place], centre[2] + offset.z[place]};
      put(count, run.b.sphere(child, c));
      places[count++] = static_cast<std::uint16_t>(place);
    });
    run.tests += count;
    for (std::uint32_t first = 0; first < count; first += 64) {
      for (std::uint64_t hits = near(first, std::min(64u, count - first), s); hits != 0; hits &= hits - 1) {
        const std::uint32_t k = first + static_cast<std::uint32_t>(std::countr_zero(hits));
        q.b = first_child + k;
        q.cb[0] = centre[0] + offset.x[places[k]];
        q.cb[1] = centre[1] + offset.y[places[k]];
        q.cb[2] = centre[2] + offset.z[places[k]];
        push(run, q, made);
      }
    }
  }
  std::swap(now_, next_);
  run.pairs = made;
}

void SphereDescentDetector::touch(Run& run, const Pair& p, float distance, float reach) HD_RT {
  ++run.report.touching;
  TouchGroup& g = groups_[std::min<std::uint32_t>(p.group, kMaxTouchGroups - 1)];
  const double weight = static_cast<double>(reach) - distance;  // t - d of eq. 3.1
  g.weight += weight;
  g.mean += weight * Vec3(p.ca[0], p.ca[1], p.ca[2]);
  if (p.a == run.last_a) return;
  run.last_a = p.a;
  const double cells = run.a.side() / run.a.scale;
  g.area += run.voxel_area * cells * cells;
}

void SphereDescentDetector::findParts(std::uint32_t level) HD_RT {
  const std::uint32_t up = map_.levels() - 1 - level;
  for (std::uint32_t i = map_.count(); i-- > 0;) part_[map_.ancestor(i, up)] = i;
}

void SphereDescentDetector::sum(Run& run, ContactSet& contacts) HD_RT {
  const VolumeView& b = run.b.view;
  // Cells left coarse count for whole faces, and again where pairs of them are left at several levels: all together
  // they stand for no more than there is of A.
  double area = 0;
  for (std::uint32_t g = 0; g < map_.count(); ++g) area += groups_[g].area;
  const double share = std::min(1.0, run.a.view.header->area / std::max(area, 1e-30));
  std::uint32_t count = 0;
  for (std::uint32_t g = 0; g < map_.count(); ++g) {
    TouchGroup group = groups_[g];
    if (group.weight <= 0) continue;
    group.part = g;
    group.area *= share;
    group.integral.force *= share;
    group.integral.torque *= share;
    group.mean /= group.weight;
    if (options_.leaf == SphereLeaf::kSphere) {
      group.mean = b.originPoint() + b.voxel * group.mean;
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
  answer(run.query, map_, groups_, count, contacts);
}

}  // namespace hapticd
