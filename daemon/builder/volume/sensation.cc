#include "daemon/builder/volume/sensation.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace hapticd {
namespace {

constexpr double kSameWay = 0.5;  // Cosine of 60 degrees: beyond it surface supports nothing.

std::size_t indexOf(const std::vector<std::uint64_t>& sorted, std::uint64_t key) {
  const auto found = std::lower_bound(sorted.begin(), sorted.end(), key);
  return found != sorted.end() && *found == key ? static_cast<std::size_t>(found - sorted.begin()) : sorted.size();
}

/** Samples by voxel, with each voxel's mean normal. */
struct ByVoxel {
  std::vector<std::uint32_t> first;   ///< Per voxel and one more.
  std::vector<std::uint32_t> sample;  ///< In the voxels' order.
  std::vector<Vec3> vector_area;
};

ByVoxel sortByVoxel(const VolumeLattice& lattice, const OctreeKeys& keys, const std::vector<std::uint64_t>& voxels,
                    const std::vector<SurfaceSample>& samples) {
  ByVoxel by;
  by.first.assign(voxels.size() + 1, 0);
  by.vector_area.assign(voxels.size(), Vec3::Zero());
  std::vector<std::uint32_t> voxel_of(samples.size());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Vec3 u = (samples[i].x - lattice.origin) / lattice.voxel;
    const Lattice3 at{static_cast<std::int32_t>(u.x()), static_cast<std::int32_t>(u.y()),
                      static_cast<std::int32_t>(u.z())};
    const std::size_t v = indexOf(voxels, keys.keyOf(at));
    voxel_of[i] = static_cast<std::uint32_t>(v);
    ++by.first[v + 1];
    by.vector_area[v] += samples[i].area * samples[i].normal;
  }
  for (std::size_t v = 0; v < voxels.size(); ++v) by.first[v + 1] += by.first[v];
  by.sample.resize(samples.size());
  std::vector<std::uint32_t> fill(by.first.begin(), by.first.end() - 1);
  for (std::uint32_t i = 0; i < samples.size(); ++i) by.sample[fill[voxel_of[i]]++] = i;
  return by;
}

double supportArea(const OctreeKeys& keys, const std::vector<std::uint64_t>& voxels, const ByVoxel& by,
                   const std::vector<SurfaceSample>& samples, std::size_t v) {
  if (!(by.vector_area[v].norm() > 0)) return 0;
  const Vec3 n = by.vector_area[v].normalized();
  const Lattice3 at = keys.cornerOf(voxels[v], keys.levels());
  const std::int32_t side = 1 << keys.sideLog2(0);
  double area = 0;
  for (int i = 0; i < 27; ++i) {
    const Lattice3 other{at[0] + i % 3 - 1, at[1] + i / 3 % 3 - 1, at[2] + i / 9 - 1};
    if (std::any_of(other.begin(), other.end(), [&](std::int32_t x) { return x < 0 || x >= side; })) continue;
    const std::size_t w = indexOf(voxels, keys.keyOf(other));
    if (w == voxels.size()) continue;
    for (std::uint32_t s = by.first[w]; s < by.first[w + 1]; ++s) {
      const double cosine = n.dot(samples[by.sample[s]].normal);
      if (cosine > kSameWay) area += cosine * samples[by.sample[s]].area;
    }
  }
  return area;
}

std::uint64_t bitsOf(const std::vector<std::uint8_t>& masks, std::size_t begin, std::size_t bytes) {
  std::uint64_t count = 0;
  for (std::size_t i = begin; i < begin + bytes; ++i) count += static_cast<std::uint64_t>(std::popcount(masks[i]));
  return count;
}

}  // namespace

std::vector<hd_octree_sensation> sensationOf(const VolumeLattice& lattice, const OctreeKeys& keys,
                                             const std::vector<BuiltLevel>& levels,
                                             const std::vector<std::uint64_t>& voxels,
                                             const std::vector<SurfaceSample>& samples) {
  const ByVoxel by = sortByVoxel(lattice, keys, voxels, samples);
  std::vector<double> support(voxels.size()), count(voxels.size(), 1);
  for (std::size_t v = 0; v < voxels.size(); ++v) support[v] = supportArea(keys, voxels, by, samples, v);

  std::vector<std::vector<hd_octree_sensation>> result(levels.size());
  for (std::size_t l = levels.size(); l-- > 0;) {
    const BuiltLevel& level = levels[l];
    const std::size_t nodes = level.prefix.size(),
                      bytes = std::size_t{1} << (3 * keys.split(static_cast<std::uint32_t>(l)) - 3);
    const double child_voxels = std::ldexp(1.0, static_cast<int>(3 * keys.sideLog2(static_cast<std::uint32_t>(l + 1))));
    std::vector<double> node_support(nodes), node_count(nodes);
    std::size_t child = 0;
    for (std::size_t n = 0; n < nodes; ++n) {
      const std::uint64_t surface = bitsOf(level.surface, n * bytes, bytes);
      node_count[n] = child_voxels * static_cast<double>(bitsOf(level.occupied, n * bytes, bytes) - surface);
      node_support[n] = std::numeric_limits<double>::infinity();
      for (const std::size_t end = child + surface; child < end; ++child) {
        node_count[n] += count[child];
        node_support[n] = std::min(node_support[n], support[child]);
      }
      const double all = std::ldexp(1.0, static_cast<int>(3 * keys.sideLog2(static_cast<std::uint32_t>(l))));
      result[l].push_back(
          {static_cast<float>(node_support[n]), static_cast<float>(std::clamp(1 - node_count[n] / all, 0.0, 1.0))});
    }
    support = std::move(node_support);
    count = std::move(node_count);
  }
  std::vector<hd_octree_sensation> flat;
  for (const auto& level : result) flat.insert(flat.end(), level.begin(), level.end());
  return flat;
}

}  // namespace hapticd
