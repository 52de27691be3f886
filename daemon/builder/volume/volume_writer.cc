#include "daemon/builder/volume/volume_writer.h"

#include <fmt/core.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "daemon/builder/volume/field_builder.h"
#include "daemon/builder/volume/mass.h"
#include "daemon/builder/volume/octree_builder.h"
#include "daemon/builder/volume/patches.h"
#include "daemon/builder/volume/sensation.h"
#include "daemon/builder/volume/surface_points.h"
#include "rt/scene/snapshot_checksum.h"
#include "rt/volume/inertia.h"
#include "rt/volume/octahedral.h"

namespace hapticd {
namespace {

Error refused(std::string where, std::string what, std::string remedy) {
  return {ErrorCode::kInvalidArgument, "volume " + std::move(where), std::move(what), std::move(remedy)};
}

Result<void> checkSource(const VolumeSource& source) {
  const VolumeOptions& o = source.options;
  const VolumeLattice& l = source.lattice;
  if (!(l.voxel >= HD_MIN_VOXEL && l.voxel <= HD_MAX_VOXEL))
    return refused("voxel", fmt::format("{} m is out of range", l.voxel), "choose 1e-6 to 1 m");
  if (!(o.band_voxels >= 0 && o.band_voxels <= 16))
    return refused("band", fmt::format("{} voxels are out of range", o.band_voxels), "choose 0 to 16");
  if (!(o.point_spacing_m >= 0 && o.point_spacing_m <= HD_MAX_COORDINATE))
    return refused("point spacing", fmt::format("{} m is out of range", o.point_spacing_m), "choose 0 or a length");
  if (source.triangles.empty()) return Error{ErrorCode::kBadMesh, "volume", "there are no triangles", "load a mesh"};
  return checkLattice(l);
}

/** What is written, section by section. */
struct Parts {
  hd_volume_header header{};
  BuiltField field;
  std::vector<SurfaceSample> points;
  std::vector<hd_volume_patch> patches;
  std::vector<BuiltLevel> levels;
  std::vector<std::uint8_t> occupied, surface;
  std::vector<std::uint32_t> first;
  std::vector<hd_octree_sensation> sensation;
};

/** Samples of the surface, the voxels they lie in, the octree over these. */
Result<std::vector<SurfaceSample>> sampleInto(const VolumeSource& source, const OctreeKeys& keys,
                                              std::vector<std::uint64_t>& voxels) {
  const VolumeLattice& lattice = source.lattice;
  std::vector<SurfaceSample> samples;
  bool outside = false;
  const double step = lattice.voxel / kSamplesPerVoxel;
  sampleSurface(source.vertices, source.triangles, step, [&](const SurfaceSample& s) {
    Lattice3 voxel;
    const Vec3 u = (s.x - lattice.origin) / lattice.voxel;
    for (std::size_t k = 0; k < 3; ++k) {
      const double at = u[static_cast<Eigen::Index>(k)], most = lattice.cells[k] * double{HD_BRICK_EDGE};
      outside |= !(at >= 0 && at < most);
      voxel[k] = static_cast<std::int32_t>(std::clamp(at, 0.0, most - 1));
    }
    samples.push_back(s);
    const std::uint64_t key = keys.keyOf(voxel);
    if (voxels.empty() || voxels.back() != key) voxels.push_back(key);
  });
  if (outside) return refused("lattice", "the surface leaves it", "make the lattice about the mesh's box");
  if (samples.empty()) return Error{ErrorCode::kBadMesh, "volume", "no triangle has an area", "check the scale"};
  std::sort(voxels.begin(), voxels.end());
  voxels.erase(std::unique(voxels.begin(), voxels.end()), voxels.end());
  return samples;
}

void flattenOctree(const OctreeKeys& keys, Parts& parts) {
  hd_volume_header& h = parts.header;
  h.level_count = keys.levels();
  h.side_log2 = keys.sideLog2(0);
  for (std::uint32_t l = 0; l < keys.levels(); ++l) {
    const BuiltLevel& level = parts.levels[l];
    parts.occupied.resize((parts.occupied.size() + 7) / 8 * 8, 0);
    parts.surface.resize(parts.occupied.size(), 0);
    h.level[l] = {keys.split(l), static_cast<std::uint32_t>(level.prefix.size()), parts.occupied.size(),
                  l + 1 < keys.levels() ? static_cast<std::uint32_t>(parts.first.size()) : 0, 0};
    parts.occupied.insert(parts.occupied.end(), level.occupied.begin(), level.occupied.end());
    parts.surface.insert(parts.surface.end(), level.surface.begin(), level.surface.end());
    parts.first.insert(parts.first.end(), level.first.begin(), level.first.end());
  }
  parts.occupied.resize((parts.occupied.size() + 7) / 8 * 8, 0);
  parts.surface.resize(parts.occupied.size(), 0);
}

/** Lays sections one after the other; fills them when there is memory. */
class VolumeLayout {
 public:
  explicit VolumeLayout(hd_volume_header& header) : header_(header), end_(sizeof header) {}
  void add(hd_volume_section section, std::uint64_t bytes) {
    end_ = (end_ + 63) / 64 * 64;
    header_.section[section] = {end_, bytes};
    end_ += bytes;
  }
  [[nodiscard]] std::uint64_t total() const { return (end_ + 63) / 64 * 64; }

 private:
  hd_volume_header& header_;
  std::uint64_t end_;
};

template <class T>
T* sectionOf(VolumeImage& image, const hd_volume_header& header, std::size_t section) {
  return reinterpret_cast<T*>(reinterpret_cast<std::byte*>(image.data()) + header.section[section].offset);
}

template <class T>
void copyInto(VolumeImage& image, const hd_volume_header& header, hd_volume_section section, const std::vector<T>& v) {
  if (!v.empty()) std::memcpy(sectionOf<T>(image, header, section), v.data(), v.size() * sizeof(T));
}

void fillPoints(VolumeImage& image, const Parts& parts, std::uint64_t padded) {
  const hd_volume_header& h = parts.header;
  auto* const normals = sectionOf<std::uint32_t>(image, h, HD_VOLUME_NORMALS);
  auto* const areas = sectionOf<std::uint16_t>(image, h, HD_VOLUME_AREAS);
  for (std::uint64_t i = 0; i < padded; ++i) {
    const SurfaceSample& p = parts.points[std::min<std::uint64_t>(i, parts.points.size() - 1)];
    for (std::size_t k = 0; k < 3; ++k)
      sectionOf<float>(image, h, HD_VOLUME_POINT_X + k)[i] = static_cast<float>(p.x[static_cast<Eigen::Index>(k)]);
    normals[i] = octahedralBits(p.normal);
    areas[i] = i < parts.points.size() ? static_cast<std::uint16_t>(std::lround(p.area / double{h.area_step})) : 0;
  }
}

VolumeImage assemble(Parts& parts) {
  hd_volume_header& h = parts.header;
  const std::uint64_t padded = (parts.points.size() + HD_POINT_PADDING - 1) / HD_POINT_PADDING * HD_POINT_PADDING;
  VolumeLayout layout(h);
  layout.add(HD_VOLUME_CELLS, parts.field.cells.size() * 4);
  layout.add(HD_VOLUME_COARSE, parts.field.coarse.size() * 2);
  layout.add(HD_VOLUME_BRICKS, parts.field.bricks.size() * 2);
  for (const auto section : {HD_VOLUME_POINT_X, HD_VOLUME_POINT_Y, HD_VOLUME_POINT_Z, HD_VOLUME_NORMALS})
    layout.add(section, padded * 4);
  layout.add(HD_VOLUME_AREAS, padded * 2);
  layout.add(HD_VOLUME_PATCHES, parts.patches.size() * sizeof(hd_volume_patch));
  layout.add(HD_VOLUME_OCCUPIED, parts.occupied.size());
  layout.add(HD_VOLUME_SURFACE, parts.surface.size());
  layout.add(HD_VOLUME_FIRST, parts.first.size() * 4);
  layout.add(HD_VOLUME_SENSATION, parts.sensation.size() * sizeof(hd_octree_sensation));
  h.total_bytes = layout.total();

  VolumeImage image(h.total_bytes / sizeof(VolumeBlock));
  copyInto(image, h, HD_VOLUME_CELLS, parts.field.cells);
  copyInto(image, h, HD_VOLUME_COARSE, parts.field.coarse);
  copyInto(image, h, HD_VOLUME_BRICKS, parts.field.bricks);
  fillPoints(image, parts, padded);
  copyInto(image, h, HD_VOLUME_PATCHES, parts.patches);
  copyInto(image, h, HD_VOLUME_OCCUPIED, parts.occupied);
  copyInto(image, h, HD_VOLUME_SURFACE, parts.surface);
  copyInto(image, h, HD_VOLUME_FIRST, parts.first);
  copyInto(image, h, HD_VOLUME_SENSATION, parts.sensation);
  h.checksum = snapshotChecksum(bytesOf(image).subspan(sizeof h));
  std::memcpy(image.data(), &h, sizeof h);
  return image;
}

void fillHeader(const VolumeSource& source, double band_m, Parts& parts) {
  hd_volume_header& h = parts.header;
  h.magic = HD_VOLUME_MAGIC;
  h.version = HD_VOLUME_VERSION;
  h.voxel = static_cast<float>(source.lattice.voxel);
  h.brick_count = parts.field.brick_count;
  h.fine_step = parts.field.fine_step;
  h.coarse_step = parts.field.coarse_step;
  h.band = static_cast<float>(band_m);
  h.point_count = static_cast<std::uint32_t>(parts.points.size());
  h.patch_count = static_cast<std::uint32_t>(parts.patches.size());
  double largest = 0;
  for (const SurfaceSample& p : parts.points) {
    largest = std::max(largest, p.area);
    h.area += p.area;
  }
  h.area_step = std::max(static_cast<float>(largest / 65535 * (1 + 1e-6)), 1e-29f);
  for (int k = 0; k < 3; ++k) {
    h.origin[k] = static_cast<float>(source.lattice.origin[k]);
    h.cells[k] = source.lattice.cells[static_cast<std::size_t>(k)];
    h.lower[k] = h.upper[k] = static_cast<float>(parts.points.front().x[k]);
    for (const SurfaceSample& p : parts.points) {
      h.lower[k] = std::min(h.lower[k], static_cast<float>(p.x[k]));
      h.upper[k] = std::max(h.upper[k], static_cast<float>(p.x[k]));
    }
  }
}

}  // namespace

Result<void> checkLattice(const VolumeLattice& l) {
  const std::uint32_t most = *std::max_element(l.cells.begin(), l.cells.end());
  if (most * std::uint64_t{HD_BRICK_EDGE} > 1u << HD_OCTREE_MAX_SIDE || l.cellCount() > HD_MAX_BRICK_CELLS) {
    return refused("lattice",
                   fmt::format("{} x {} x {} voxels; at most {} along an axis and {} brick cells in all fit",
                               std::uint64_t{l.cells[0]} * HD_BRICK_EDGE, std::uint64_t{l.cells[1]} * HD_BRICK_EDGE,
                               std::uint64_t{l.cells[2]} * HD_BRICK_EDGE, 1u << HD_OCTREE_MAX_SIDE, HD_MAX_BRICK_CELLS),
                   "choose a larger voxel");
  }
  return {};
}

Result<VolumeImage> writeVolume(const VolumeSource& source, BuildMonitor& monitor) {
  if (const auto checked = checkSource(source); !checked) return checked.error();
  const VolumeLattice& lattice = source.lattice;
  const VolumeOptions& options = source.options;
  Parts parts;
  parts.header.mass = massOf(source.vertices, source.triangles);
  if (!(parts.header.mass.volume > 0)) {
    return Error{ErrorCode::kBadMesh, "volume", fmt::format("its solid has {} m^3", parts.header.mass.volume),
                 "close the surface and turn it outward"};
  }
  if (!isPositiveDefinite(parts.header.mass.inertia)) {
    return Error{ErrorCode::kBadMesh, "volume", "its triangles, with its holes closed, are not those of a solid",
                 "turn all its parts outward, and give what is a sheet a thickness"};
  }

  const double band_m = options.band_voxels * lattice.voxel;
  parts.field = buildField(lattice, *source.field, band_m, monitor, 0, 0.8f);
  if (parts.field.cells.empty()) return cancelled();
  if (parts.field.brick_count == 0)
    return Error{ErrorCode::kBadMesh, "volume", "the distance is nowhere near zero", "check mesh and lattice"};
  if (parts.field.brick_count > HD_MAX_BRICKS) {
    return refused("bricks", fmt::format("{} are needed, {} fit", parts.field.brick_count, HD_MAX_BRICKS),
                   "choose a larger voxel");
  }

  if (!monitor.progress(0.8f, "sampling the surface")) return cancelled();
  const std::uint32_t longest = *std::max_element(lattice.cells.begin(), lattice.cells.end()) * HD_BRICK_EDGE;
  const OctreeKeys keys(splitsOf(options.octree, static_cast<std::uint32_t>(std::bit_width(longest - 1))));
  std::vector<std::uint64_t> voxels;
  auto samples = sampleInto(source, keys, voxels);
  if (!samples) return samples.error();
  if (voxels.size() > HD_MAX_POINTS) {
    return refused("surface", fmt::format("{} voxels hold it, {} fit", voxels.size(), HD_MAX_POINTS),
                   "choose a larger voxel");
  }

  if (!monitor.progress(0.85f, "building the octree")) return cancelled();
  parts.levels = buildOctree(keys, voxels, [&](const Lattice3& corner, std::int32_t side) {
    if (side > 1)
      return parts.field.isInside(lattice, {corner[0] + side / 2, corner[1] + side / 2, corner[2] + side / 2});
    int inside = 0;  // A sliver of surface that no sample met may cut off a corner or an edge.
    for (std::int32_t i = 0; i < 8; ++i)
      inside += parts.field.isInside(lattice, {corner[0] + (i & 1), corner[1] + (i >> 1 & 1), corner[2] + (i >> 2)});
    return inside > 4;
  });
  flattenOctree(keys, parts);
  parts.header.surface_voxels = static_cast<std::uint32_t>(voxels.size());

  if (!monitor.progress(0.9f, "choosing surface points")) return cancelled();
  if (options.sensation) parts.sensation = sensationOf(lattice, keys, parts.levels, voxels, *samples);
  const double spacing = options.point_spacing_m > 0 ? options.point_spacing_m : lattice.voxel;
  parts.points = thinOut(std::move(*samples), lattice.origin, spacing);
  if (parts.points.size() > HD_MAX_POINTS) {
    return refused("points", fmt::format("{} are too many, {} fit", parts.points.size(), HD_MAX_POINTS),
                   "choose a larger point spacing");
  }
  if (!monitor.progress(0.95f, "making patches")) return cancelled();
  parts.header.patch_level = patchLevel(parts.levels, parts.points.size(), options.patch_points);
  parts.patches = makePatches(lattice, keys, parts.header.patch_level, parts.levels[parts.header.patch_level].prefix,
                              parts.points, monitor);
  if (parts.patches.empty()) return cancelled();
  fillHeader(source, band_m, parts);
  return assemble(parts);
}

}  // namespace hapticd
