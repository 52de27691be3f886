// The check that stands between a volume and the collide thread: whoever wrote it, what passes here is safe to walk.
#include <atomic>
#include <cmath>
#include <vector>

#include "rt/scene/block_check.h"
#include "rt/volume/inertia.h"
#include "rt/volume/volume_view.h"

namespace hapticd {
namespace {

bool within(float x, float low, float high) { return low <= x && x <= high; }
bool isPlace(float x) { return std::fabs(x) <= HD_MAX_COORDINATE; }
/** Of the lattice and its nodes, which reach beyond the surface by a margin and what makes whole brick cells. */
bool isAbout(float x) { return std::fabs(x) <= 2 * HD_MAX_COORDINATE; }

constexpr std::uint64_t padded(std::uint64_t points) {
  return (points + HD_POINT_PADDING - 1) / HD_POINT_PADDING * HD_POINT_PADDING;
}

/** One pass per section, each relying on those before it. */
class VolumeValidator : private BlockCheck {
 public:
  explicit VolumeValidator(std::span<const std::byte> bytes) : BlockCheck("volume"), bytes_(bytes) {}

  Result<VolumeView> run() {
    for (const auto check :
         {&VolumeValidator::checkHeader, &VolumeValidator::checkNumbers, &VolumeValidator::checkLevels,
          &VolumeValidator::checkSections, &VolumeValidator::checkCells, &VolumeValidator::checkPoints,
          &VolumeValidator::checkOctree, &VolumeValidator::checkPatches, &VolumeValidator::checkSensation})
      if (const Result<void> passed = (this->*check)(); !passed) return passed.error();
    return view_;
  }

 private:
  Result<void> checkHeader() {
    if (auto r = header(bytes_, HD_VOLUME_MAGIC, HD_VOLUME_VERSION, h_); !r) return r;
    if (h_.flags != 0) return bad("header", "a flag is not known");
    return {};
  }

  Result<void> checkNumbers() {
    if (!within(h_.voxel, HD_MIN_VOXEL, HD_MAX_VOXEL)) return bad("header", "the voxel's side is out of range");
    for (const float step : {h_.fine_step, h_.coarse_step, h_.area_step})
      if (!within(step, 1e-30f, 1e6f)) return bad("header", "a step is out of range");
    if (!within(h_.band, 0, HD_MAX_COORDINATE)) return bad("header", "the band is out of range");
    cell_count_ = 1;
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t n = h_.cells[k];
      if (n == 0 || n > 1u << (HD_OCTREE_MAX_SIDE - 3)) return bad("header", "brick cells are out of range");
      cell_count_ *= n;
      corner_count_ *= n + 1;
      if (!isAbout(h_.origin[k]) || !isAbout(h_.origin[k] + static_cast<float>(n * HD_BRICK_EDGE) * h_.voxel))
        return bad("header", "the lattice lies out of range");
      if (!isPlace(h_.lower[k]) || !isPlace(h_.upper[k]) || !(h_.lower[k] <= h_.upper[k]))
        return bad("header", "its box is not a box");
    }
    if (cell_count_ > HD_MAX_BRICK_CELLS) return bad("header", "too many brick cells");
    if (h_.brick_count == 0 || h_.brick_count > HD_MAX_BRICKS || h_.brick_count > cell_count_)
      return bad("header", "brick count out of range");
    if (h_.point_count == 0 || h_.point_count > HD_MAX_POINTS) return bad("header", "point count out of range");
    if (!(h_.area > 0 && h_.area < 1e12) || !(h_.mass.volume > 0 && h_.mass.volume < 1e12))
      return bad("header", "area or volume is out of range");
    for (const double x : h_.mass.centroid)
      if (!(std::abs(x) <= double{HD_MAX_COORDINATE})) return bad("header", "the centroid is out of range");
    return checkInertia();
  }

  /** Positive definite. Whether a solid can have it MassProperties::valid() tells where it is used. */
  [[nodiscard]] Result<void> checkInertia() const {
    const auto& i = h_.mass.inertia;
    for (const double x : i)
      if (!(std::abs(x) < 1e18)) return bad("header", "the inertia is out of range");
    if (!isPositiveDefinite(i)) return bad("header", "the inertia is not that of a solid");
    return {};
  }

  Result<void> checkLevels() {
    if (h_.level_count == 0 || h_.level_count > HD_OCTREE_MAX_LEVELS || h_.patch_level >= h_.level_count)
      return bad("header", "octree levels are out of range");
    std::uint32_t side = 0;
    for (std::uint32_t l = 0; l < h_.level_count; ++l) {
      const hd_octree_level& level = h_.level[l];
      if (level.split_log2 < 1 || level.split_log2 > 3) return bad("level", l, "its split is not known");
      side += level.split_log2;
      if (level.node_count == 0 || level.node_count > HD_MAX_POINTS) return bad("level", l, "nodes out of range");
      if (level.mask_offset != (mask_bytes_ + 7) / 8 * 8) return bad("level", l, "its masks are not in their place");
      mask_bytes_ = level.mask_offset + std::uint64_t{level.node_count} * maskBytes(level.split_log2);
      nodes_ += level.node_count;
      if (l + 1 == h_.level_count) continue;
      if (level.first_offset != first_count_) return bad("level", l, "its entries are not in their place");
      first_count_ += level.node_count;
    }
    mask_bytes_ = (mask_bytes_ + 7) / 8 * 8;
    if (h_.level[0].node_count != 1) return bad("level", 0, "there must be one root");
    if (side != h_.side_log2 || side > HD_OCTREE_MAX_SIDE) return bad("header", "the root's side is not its levels'");
    for (const std::uint32_t n : h_.cells)
      if (n * HD_BRICK_EDGE > 1u << side) return bad("header", "the root does not hold all brick cells");
    if (h_.patch_count != h_.level[h_.patch_level].node_count)
      return bad("header", "patches are not as many as nodes of their level");
    return {};
  }

  Result<void> checkSections() {
    const std::uint64_t points = padded(h_.point_count);
    const std::uint64_t sensation = h_.section[HD_VOLUME_SENSATION].bytes;
    const std::uint64_t expected[HD_VOLUME_SECTIONS] = {cell_count_ * 4,
                                                        corner_count_ * 2,
                                                        std::uint64_t{h_.brick_count} * HD_BRICK_STRIDE * 2,
                                                        points * 4,
                                                        points * 4,
                                                        points * 4,
                                                        points * 4,
                                                        points * 2,
                                                        std::uint64_t{h_.patch_count} * sizeof(hd_volume_patch),
                                                        mask_bytes_,
                                                        mask_bytes_,
                                                        first_count_ * 4,
                                                        sensation == 0 ? 0 : nodes_ * sizeof(hd_octree_sensation)};
    if (auto r = sections(h_, expected); !r) return r;
    fillView();
    return {};
  }

  void fillView() {
    static std::atomic<std::uint64_t> made{0};
    view_.number = made.fetch_add(1, std::memory_order_relaxed) + 1;
    view_.header = reinterpret_cast<const hd_volume_header*>(bytes_.data());
    view_.voxel = h_.voxel;
    view_.cell = at<std::uint32_t>(HD_VOLUME_CELLS);
    view_.coarse = at<std::int16_t>(HD_VOLUME_COARSE);
    view_.bricks = at<std::int16_t>(HD_VOLUME_BRICKS);
    view_.brick_count = h_.brick_count;
    view_.fine_step = h_.fine_step;
    view_.coarse_step = h_.coarse_step;
    view_.band = h_.band;
    for (std::size_t k = 0; k < 3; ++k) {
      view_.origin[k] = h_.origin[k];
      view_.cells[k] = h_.cells[k];
      view_.point[k] = at<float>(static_cast<hd_volume_section>(HD_VOLUME_POINT_X + k));
    }
    view_.normal = at<std::uint32_t>(HD_VOLUME_NORMALS);
    view_.area = at<std::uint16_t>(HD_VOLUME_AREAS);
    view_.area_step = h_.area_step;
    view_.point_count = h_.point_count;
    view_.patches = {at<hd_volume_patch>(HD_VOLUME_PATCHES), h_.patch_count};
    view_.patch_level = h_.patch_level;
    view_.mass = h_.mass;
    OctreeView& tree = view_.octree;
    tree.levels = h_.level_count;
    tree.side_log2 = h_.side_log2;
    std::uint32_t side = h_.side_log2, first = 0;
    for (std::uint32_t l = 0; l < h_.level_count; ++l) {
      const hd_octree_level& level = h_.level[l];
      tree.level[l] = {at<std::uint8_t>(HD_VOLUME_OCCUPIED) + level.mask_offset,
                       at<std::uint8_t>(HD_VOLUME_SURFACE) + level.mask_offset,
                       l + 1 < h_.level_count ? at<std::uint32_t>(HD_VOLUME_FIRST) + level.first_offset : nullptr,
                       level.node_count,
                       static_cast<std::uint8_t>(level.split_log2),
                       static_cast<std::uint8_t>(side)};
      side -= level.split_log2;
      tree.first_sensation[l] = first;
      first += level.node_count;
    }
    if (h_.section[HD_VOLUME_SENSATION].bytes > 0) tree.sensation = at<hd_octree_sensation>(HD_VOLUME_SENSATION);
  }

  Result<void> checkCells() {
    std::vector<bool> used(h_.brick_count, false);
    std::uint32_t count = 0;
    for (std::size_t i = 0; i < cell_count_; ++i) {
      const std::uint32_t brick = view_.cell[i];
      if (brick == HD_NO_INDEX) continue;
      if (brick >= h_.brick_count) return bad("cell", i, "its brick is past the last one");
      if (used[brick]) return bad("brick", brick, "is in two cells");
      used[brick] = true;
      ++count;
    }
    if (count != h_.brick_count) return bad("bricks", "one is in no cell");
    return {};
  }

  Result<void> checkPoints() {
    const std::uint64_t end = padded(h_.point_count);
    for (std::size_t k = 0; k < 3; ++k) {
      const float* x = view_.point[k];
      for (std::size_t i = 0; i < end; ++i)
        if (!within(x[i], h_.lower[k], h_.upper[k])) return bad("point", i, "lies outside the box of the header");
    }
    for (std::size_t i = h_.point_count; i < end; ++i)
      if (view_.area[i] != 0) return bad("point", i, "is padding and has an area");
    return {};
  }

  Result<void> checkOctree() {
    for (std::uint32_t l = 0; l < h_.level_count; ++l) {
      const OctreeLevel& level = view_.octree.level[l];
      std::uint64_t children = 0;
      for (std::uint32_t n = 0; n < level.node_count; ++n) {
        const std::uint32_t count = childCount(level, n);
        if (count == 0) return bad("octree", "a node of level " + std::to_string(l) + " holds no surface");
        for (std::uint32_t w = 0; w < maskWords(level.split); ++w) {
          if ((maskWord(level, OctreeMask::kSurface, n, w) & ~maskWord(level, OctreeMask::kOccupied, n, w)) != 0)
            return bad("octree", "a child of level " + std::to_string(l) + " is surface and not occupied");
        }
        if (level.first != nullptr && level.first[n] != children)
          return bad("octree", "a node of level " + std::to_string(l) + " has its children elsewhere");
        children += count;
      }
      const std::uint64_t expected = l + 1 < h_.level_count ? view_.octree.level[l + 1].node_count : h_.surface_voxels;
      if (children != expected) {
        return bad("octree", "level " + std::to_string(l) + " has " + std::to_string(children) + " children, not " +
                                 std::to_string(expected));
      }
    }
    return {};
  }

  Result<void> checkPatches() {
    std::uint64_t first = 0;
    for (std::size_t i = 0; i < view_.patches.size(); ++i) {
      const hd_volume_patch& p = view_.patches[i];
      if (p.first != first || p.count > h_.point_count - first) return bad("patch", i, "its points are not in place");
      first += p.count;
      if (!isAbout(p.center[0]) || !isAbout(p.center[1]) || !isAbout(p.center[2]) ||
          !within(p.radius, 0, 2 * HD_MAX_COORDINATE) || !within(p.spread, 0, 2 * HD_MAX_COORDINATE) ||
          !within(p.area, 0, 1e12f))
        return bad("patch", i, "a number of it is out of range");
      const double slack = 1e-6 * (h_.voxel + p.radius) + 1e-6 * p.radius;
      for (std::uint32_t q = p.first; q < p.first + p.count; ++q) {
        const Vec3 from = view_.pointAt(q) - Vec3(p.center[0], p.center[1], p.center[2]);
        if (!(from.norm() <= p.radius + slack)) return bad("patch", i, "its ball does not hold its points");
      }
    }
    if (first != h_.point_count) return bad("patches", "a point is in none");
    return {};
  }

  Result<void> checkSensation() {
    if (view_.octree.sensation == nullptr) return {};
    for (std::size_t i = 0; i < nodes_; ++i) {
      const hd_octree_sensation& s = view_.octree.sensation[i];
      if (!within(s.support_area, 0, 1e12f) || !within(s.empty, 0, 1))
        return bad("sensation", i, "a number of it is out of range");
    }
    return {};
  }

  template <class T>
  const T* at(hd_volume_section section) const {
    return reinterpret_cast<const T*>(bytes_.data() + h_.section[section].offset);
  }

  std::span<const std::byte> bytes_;
  hd_volume_header h_{};
  VolumeView view_;
  std::uint64_t cell_count_ = 1, corner_count_ = 1, mask_bytes_ = 0, first_count_ = 0, nodes_ = 0;
};

}  // namespace

Result<VolumeView> validateVolume(std::span<const std::byte> bytes) { return VolumeValidator(bytes).run(); }

}  // namespace hapticd
