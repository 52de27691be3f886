#include "rt/contact/point_field.h"

#include <algorithm>

#include "rt/contact/point_field_run.h"

namespace hapticd {
namespace {

constexpr float kNowhere = -1e9F;         // Radius of a patch without points: it touches nothing.
constexpr float kRoot3 = 1.7320509F;      // An interpolated distance grows no faster than this with the place.
constexpr float kPlaceError = 0.02F;      // Of places in single precision, twice [voxel].
constexpr std::uint32_t kRunPatches = 8;  // Looked at together.

std::uint32_t padded(std::uint32_t n) HD_RT { return (n + 15) & ~15u; }

std::uint32_t blocksOf(const hd_volume_patch& p) HD_RT {
  return p.count == 0 ? 0 : ((p.first + p.count - 1) >> 4) - (p.first >> 4) + 1;
}

/** Points of a patch in its first `blocks` blocks. */
std::uint32_t pointsIn(const hd_volume_patch& p, std::uint32_t blocks) HD_RT {
  return std::min(p.count, 16 * ((p.first >> 4) + blocks) - p.first);
}

}  // namespace

PointFieldDetector::PointFieldDetector(std::uint32_t max_patches, const PointFieldOptions& options)
    : options_(options),
      max_patches_(max_patches),
      x_(padded(max_patches)),
      y_(padded(max_patches)),
      z_(padded(max_patches)),
      radius_(padded(max_patches)),
      lever_(padded(max_patches)),
      clearance_(padded(max_patches)),
      take_(padded(max_patches)),
      groups_(kMaxTouchGroups),
      entries_(kMaxTouchGroups),
      order_(kMaxTouchGroups),
      urgency_(kMaxTouchGroups) {}

void PointFieldDetector::reset() HD_RT {
  known_ = false;
  a_ = b_ = 0;
  ages_.clear();
}

void PointFieldDetector::readPatches(const VolumeView& a) HD_RT {
  map_.build(a);
  const auto count = static_cast<std::uint32_t>(a.patches.size());
  const hd_volume_header& h = *a.header;
  middle_A_ = 0.5 * (Vec3(h.lower[0], h.lower[1], h.lower[2]) + Vec3(h.upper[0], h.upper[1], h.upper[2]));
  reach_ = 0;
  for (std::uint32_t i = 0; i < padded(count); ++i) {
    const hd_volume_patch* const p = i < count && a.patches[i].count > 0 ? &a.patches[i] : nullptr;
    x_[i] = p != nullptr ? p->center[0] : 0;
    y_[i] = p != nullptr ? p->center[1] : 0;
    z_[i] = p != nullptr ? p->center[2] : 0;
    lever_[i] = 0;
    if (p == nullptr) continue;
    const double lever = (Vec3(x_[i], y_[i], z_[i]) - middle_A_).norm() + p->radius;
    lever_[i] = static_cast<float>(lever * (1 + 1e-6));
    reach_ = std::max(reach_, lever);
  }
}

void PointFieldDetector::scaleRadii(const VolumeView& a, float voxel) HD_RT {
  voxel_ = voxel;
  const auto count = static_cast<std::uint32_t>(a.patches.size());
  for (std::uint32_t i = 0; i < padded(count); ++i) {
    radius_[i] = i < count && a.patches[i].count > 0 ? a.patches[i].radius / voxel : kNowhere;
  }
}

void PointFieldDetector::find(const DetectorQuery& query, ContactSet& contacts) HD_RT {
  contacts.count = 0;
  contacts.integral = Wrench{};
  contacts.touching_area = contacts.deepest = 0;
  contacts.report = DetectorReport{};
  const VolumeView& a = *query.a.volume;
  const VolumeView& b = *query.b.volume;
  if (a.patches.size() > max_patches_) {
    contacts.report.dropped = static_cast<std::uint32_t>(a.patches.size());
    contacts.report.dropped_area = a.header->area;
    contacts.report.exhausted = true;
    return;
  }
  if (a_ != a.number) readPatches(a);
  if (a_ != a.number || voxel_ != b.voxel) scaleRadii(a, b.voxel);
  if (a_ != a.number || b_ != b.number) {
    known_ = false;
    ages_.clear();
  }
  a_ = a.number;
  b_ = b.number;
  const double margin = usableMargin(query.margin, b);
  Run run(query, margin, contacts.report);
  const Pose& X_BA = run.X_BA;
  float shift = 0, turn = 0;
  const bool coherent = known_ && options_.coherent && margin == margin_;
  if (coherent) {
    const double angle = 2 * std::asin(std::min(1.0, (X_BA.q * X_BA_.q.conjugate()).vec().norm()));
    shift = static_cast<float>((X_BA * middle_A_ - X_BA_ * middle_A_).norm() * (1 + 1e-6));
    turn = static_cast<float>(angle * (1 + 1e-6) + 1e-12);
  } else {
    std::fill(clearance_.begin(), clearance_.end(), 0.0F);
  }
  X_BA_ = X_BA;
  margin_ = margin;
  known_ = true;
  survey(run, shift, turn);
  share(run);
  press(run);
  if (options_.swept && !query.first_only) sweep(run);
  sum(run, contacts);
}

void PointFieldDetector::survey(Run& run, float shift, float turn) HD_RT {
  const auto count = static_cast<std::uint32_t>(run.a.patches.size());
  const PatchTable table{x_.data(), y_.data(), z_.data(), radius_.data()};
  const auto voxel = static_cast<float>(run.b.voxel);
  const std::uint32_t limit = run.limit / 2;  // The rest is for points.
  std::uint32_t units = 0, reused = 0, untested = 0;
  for (std::uint32_t first = 0; first < count; first += 16) {
    std::uint32_t lanes = run.kernel.expire(&clearance_[first], &lever_[first], shift, turn);
    if (lanes == 0) {
      reused += 16;
      std::fill_n(&take_[first], 16, 0u);
      continue;
    }
    if ((run.limit != 0 && units >= limit) || run.late(units)) {
      untested += static_cast<std::uint32_t>(__builtin_popcount(lanes));
      for (std::uint32_t i = first; i < std::min(first + 16, count); ++i)
        if ((lanes >> (i - first) & 1) != 0) run.drop(run.a.patches[i]);
      std::fill_n(&take_[first], 16, 0u);
      continue;
    }
    ++units;
    alignas(64) float bound[16];
    run.kernel.bound(run.field, table, run.placement, first, bound);
    for (std::uint32_t i = 0; i < 16; ++i) {
      take_[first + i] = 0;
      if ((lanes >> i & 1) == 0) {
        ++reused;
        continue;
      }
      clearance_[first + i] = (bound[i] - run.range.margin - kPlaceError) * voxel;
      if (clearance_[first + i] > 0) continue;
      take_[first + i] = blocksOf(run.a.patches[first + i]);
      run.wanted += take_[first + i];
      run.patches += 1;
    }
  }
  run.report.work = units;
  run.report.reused = std::min(reused, count);
  if (untested > 0) run.report.exhausted = true;
}

void PointFieldDetector::share(Run& run) HD_RT {
  const std::uint32_t groups = map_.count();
  run.order = 0;
  for (std::uint32_t g = 0; g < groups; ++g) {
    float urgent = 1;
    for (std::uint32_t i = map_.first(g); i < map_.first(g + 1); ++i)
      if (take_[i] > 0) urgent = std::min(urgent, clearance_[i]);
    urgency_[g] = urgent;
    if (urgent <= 0) order_[run.order++] = g;
  }
  const bool limited = run.limit != 0 && run.wanted > run.limit - run.report.work;
  if (limited || run.timed() || run.query.first_only) {
    // Those that may be deepest first; where one touched last time before all.
    std::sort(order_.begin(), order_.begin() + run.order, [&](std::uint32_t g, std::uint32_t h) {
      if (run.query.first_only && (g == last_group_) != (h == last_group_)) return g == last_group_;
      return urgency_[g] < urgency_[h] || (urgency_[g] == urgency_[h] && g < h);
    });
  }
  std::fill_n(run.worth, kMaxTouchGroups, 1.0F);
  if (!limited) return;
  run.report.exhausted = true;
  const std::uint32_t left = run.limit - run.report.work;
  if (left < run.patches) {
    pick(run, left);
    return;
  }
  const double more =
      static_cast<double>(left - run.patches) / static_cast<double>(std::max(1u, run.wanted - run.patches));
  std::uint32_t given = 0;
  double owed = 0;  // Of blocks that were shared out in parts.
  for (std::uint32_t o = 0; o < run.order; ++o) {
    const std::uint32_t g = order_[o];
    for (std::uint32_t i = map_.first(g); i < map_.first(g + 1); ++i) {
      if (take_[i] == 0) continue;
      owed += more * (take_[i] - 1);
      const std::uint32_t extra = std::min(static_cast<std::uint32_t>(owed), take_[i] - 1);
      owed -= extra;
      take_[i] = std::min(1 + extra, left - given);
      given += take_[i];
      if (take_[i] == 0) run.drop(run.a.patches[i]);
    }
  }
}

void PointFieldDetector::pick(Run& run, std::uint32_t left) HD_RT {
  // One for each group, and of what is left in parts.
  const std::uint32_t rest = left > run.order ? left - run.order : 0;
  const double part = static_cast<double>(rest) / std::max(1u, run.patches - run.order);
  double owed = 0;
  for (std::uint32_t o = 0; o < run.order; ++o) {
    const std::uint32_t g = order_[o];
    std::uint32_t wanted = 0, all = 0, chosen = 0;
    for (std::uint32_t i = map_.first(g); i < map_.first(g + 1); ++i) wanted += take_[i] > 0 ? 1 : 0;
    owed += part * (wanted - 1);
    const std::uint32_t given = std::min({1 + static_cast<std::uint32_t>(owed), wanted, left});
    owed -= std::max(given, 1u) - 1;
    left -= given;
    float radius = 0;
    std::uint32_t n = 0;
    for (std::uint32_t i = map_.first(g); i < map_.first(g + 1); ++i) {
      if (take_[i] == 0) continue;
      const hd_volume_patch& p = run.a.patches[i];
      ++n;
      all += p.count;
      take_[i] = n * given / wanted > (n - 1) * given / wanted ? 1 : 0;
      chosen += take_[i] > 0 ? p.count : 0;
      radius = std::max(radius, p.radius);
      if (given == 0) run.drop(p);
    }
    if (given == 0) continue;
    run.worth[g] = static_cast<float>(all) / static_cast<float>(chosen);
    if (given < wanted) {
      run.report.coarsest =
          std::max(run.report.coarsest, 2.0 * radius * std::sqrt(static_cast<double>(wanted) / given));
    }
  }
}

void PointFieldDetector::press(Run& run) HD_RT {
  std::fill_n(run.touched, kMaxTouchGroups, false);
  for (std::uint32_t o = 0; o < run.order; ++o) {
    const std::uint32_t g = order_[o];
    if (run.late(run.report.work)) {
      run.report.exhausted = true;
      for (std::uint32_t i = map_.first(g); i < map_.first(g + 1); ++i)
        if (take_[i] > 0) run.drop(run.a.patches[i]);
      continue;
    }
    pressGroup(run, g);
    if (!run.touched[g] || !run.query.first_only) continue;
    last_group_ = g;
    break;
  }
}

void PointFieldDetector::pressGroup(Run& run, std::uint32_t g) HD_RT {
  PointSums sums = noPoints();
  const hd_volume_patch* const patches = run.a.patches.data();
  bool placed = false;
  const std::uint32_t end = map_.first(g + 1);
  for (std::uint32_t i = map_.first(g); i < end;) {
    if (take_[i] == 0) {
      ++i;
      continue;
    }
    if (!placed) run.setMiddle(patches[i].center);
    placed = true;
    // Patches next to each other whose points are all wanted are one range.
    std::uint32_t last = i, points = pointsIn(patches[i], take_[i]);
    run.range.first = patches[i].first;
    run.range.weight = run.worth[g] * (static_cast<float>(patches[i].count) / static_cast<float>(points));
    if (points == patches[i].count) {
      while (last + 1 < end && last + 1 < i + kRunPatches && take_[last + 1] > 0 &&
             pointsIn(patches[last + 1], take_[last + 1]) == patches[last + 1].count)
        points += patches[++last].count;
    } else {
      run.report.coarsest = std::max<double>(run.report.coarsest, patches[i].spread);
    }
    run.range.count = points;
    run.report.work += ((run.range.first + points - 1) >> 4) - (run.range.first >> 4) + 1;
    const float nearest = run.kernel.run(run.field, run.points, run.placement, run.range, sums);
    // Whoever was thinned out knows nothing of the points left out.
    const bool all = run.range.weight == 1;
    const float clear = ((nearest - run.range.margin) / kRoot3 - kPlaceError) * static_cast<float>(run.b.voxel);
    for (std::uint32_t j = i; j <= last; ++j) clearance_[j] = all ? clear : 0;
    i = last + 1;
  }
  run.report.touching += sums.touching;
  run.touched[g] = sums.touching > 0;
  if (run.touched[g]) groups_[g] = run.read(sums, g, run.a.area_step);
}

void PointFieldDetector::sum(const Run& run, ContactSet& contacts) HD_RT {
  std::uint32_t count = 0;
  for (std::uint32_t g = 0; g < map_.count(); ++g) {
    if (!run.touched[g]) continue;
    if (count != g) groups_[count] = groups_[g];
    ++count;
  }
  answer(run.query, map_, groups_, count, contacts);
  ages_.follow(contacts);
  if (count > 0 || contacts.report.exhausted) return;
  float least = std::numeric_limits<float>::max();
  for (std::size_t i = 0; i < run.a.patches.size(); ++i)
    if (run.a.patches[i].count > 0) least = std::min(least, clearance_[i]);
  contacts.report.distance_lower_bound = std::max(0.0F, least);
}

}  // namespace hapticd
