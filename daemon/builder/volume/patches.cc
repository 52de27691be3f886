#include "daemon/builder/volume/patches.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hapticd {
namespace {

/** Ritter's two passes ("An efficient bounding sphere", 1990) about the points as they are stored, rounded up. */
void boundPoints(std::span<const SurfaceSample> points, hd_volume_patch& patch) {
  const auto farthest = [&](const Vec3& from) {
    Vec3 far = from;
    for (const SurfaceSample& p : points)
      if ((asFloat(p.x) - from).squaredNorm() > (far - from).squaredNorm()) far = asFloat(p.x);
    return far;
  };
  const Vec3 a = farthest(asFloat(points[0].x)), b = farthest(a);
  Vec3 center = (a + b) / 2;
  double radius = (a - b).norm() / 2;
  for (const SurfaceSample& p : points) {
    const Vec3 out = asFloat(p.x) - center;
    const double distance = out.norm();
    if (distance <= radius) continue;
    const double grown = (radius + distance) / 2;
    center += out * ((grown - radius) / distance);
    radius = grown;
  }
  center = asFloat(center);
  radius = 0;
  for (const SurfaceSample& p : points) radius = std::max(radius, (asFloat(p.x) - center).norm());
  for (int k = 0; k < 3; ++k) patch.center[k] = static_cast<float>(center[k]);
  patch.radius = std::nextafter(static_cast<float>(radius), std::numeric_limits<float>::infinity());
}

}  // namespace

std::uint32_t patchLevel(const std::vector<BuiltLevel>& levels, std::size_t points, std::size_t wanted) {
  std::uint32_t best = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::uint32_t l = 0; l < levels.size(); ++l) {
    const double mean = static_cast<double>(points) / static_cast<double>(levels[l].prefix.size());
    const double off = std::abs(std::log(mean / static_cast<double>(std::max<std::size_t>(wanted, 1))));
    if (off < least) {
      least = off;
      best = l;
    }
  }
  return best;
}

std::vector<hd_volume_patch> makePatches(const VolumeLattice& lattice, const OctreeKeys& keys, std::uint32_t level,
                                         const std::vector<std::uint64_t>& prefixes, std::vector<SurfaceSample>& points,
                                         BuildMonitor& monitor) {
  struct Placed {
    std::uint64_t node;
    std::uint32_t point;
  };
  std::vector<Placed> placed;
  placed.reserve(points.size());
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const Vec3 u = (points[i].x - lattice.origin) / lattice.voxel;
    const Lattice3 voxel{static_cast<std::int32_t>(u.x()), static_cast<std::int32_t>(u.y()),
                         static_cast<std::int32_t>(u.z())};
    const std::uint64_t prefix = keys.prefix(keys.keyOf(voxel), level);
    const auto node = std::lower_bound(prefixes.begin(), prefixes.end(), prefix);
    placed.push_back({static_cast<std::uint64_t>(node - prefixes.begin()), i});
  }
  std::stable_sort(placed.begin(), placed.end(), [](const auto& a, const auto& b) { return a.node < b.node; });

  std::vector<SurfaceSample> sorted;
  sorted.reserve(points.size());
  std::vector<hd_volume_patch> patches(prefixes.size());
  const double node_side = lattice.voxel * (1u << keys.sideLog2(level));
  std::size_t next = 0;
  for (std::size_t n = 0; n < patches.size(); ++n) {
    hd_volume_patch& patch = patches[n];
    patch.first = static_cast<std::uint32_t>(sorted.size());
    for (; next < placed.size() && placed[next].node == n; ++next) sorted.push_back(points[placed[next].point]);
    patch.count = static_cast<std::uint32_t>(sorted.size()) - patch.first;
    const std::span<SurfaceSample> own(sorted.data() + patch.first, patch.count);
    if (own.empty()) {
      const Vec3 middle = lattice.at(keys.cornerOf(prefixes[n], level)) + Vec3::Constant(node_side / 2);
      for (int k = 0; k < 3; ++k) patch.center[k] = static_cast<float>(middle[k]);
      continue;
    }
    const float done = static_cast<float>(patch.first) / static_cast<float>(placed.size());
    const auto spread = orderByCoverage(own, [&] { return monitor.progress(0.95f + 0.05f * done, "making patches"); });
    if (!spread) return {};
    patch.spread = static_cast<float>(*spread);
    boundPoints(own, patch);
    double area = 0;
    for (const SurfaceSample& p : own) area += p.area;
    patch.area = static_cast<float>(area);
  }
  points = std::move(sorted);
  return patches;
}

}  // namespace hapticd
