// Volumes that went bad: each lie of the header or the arrays is refused, and says where.
#include <gmock/gmock.h>

#include "rt/scene/snapshot_checksum.h"
#include "tests/support/shape/test_volume.h"

namespace hapticd::test {
namespace {

class Damaged : public ::testing::Test {
 protected:
  hd_volume_header& header() { return *reinterpret_cast<hd_volume_header*>(volume_.image.data()); }
  template <class T>
  T* section(hd_volume_section s) {
    return reinterpret_cast<T*>(reinterpret_cast<std::byte*>(volume_.image.data()) + header().section[s].offset);
  }
  /** Whether what was done to the image is refused, with a checksum that fits, and with which words. */
  std::string refusal() {
    header().checksum = snapshotChecksum(bytesOf(volume_.image).subspan(sizeof(hd_volume_header)));
    const auto view = validateVolume(bytesOf(volume_.image));
    return view.ok() ? "" : view.error().where + ": " + view.error().what;
  }

  TestVolume volume_ = torusVolume(0.03, 0.01, 0.002, [] {
    VolumeOptions options;
    options.sensation = true;
    return options;
  }());
};

TEST_F(Damaged, anyFlippedWordIsSeen) {
  auto* const words = reinterpret_cast<std::uint64_t*>(volume_.image.data());
  const std::size_t count = volume_.image.size() * 8, first = sizeof(hd_volume_header) / 8;
  for (std::size_t i = first; i < count; i += 997) {
    words[i] ^= 1;
    const auto view = validateVolume(bytesOf(volume_.image));
    EXPECT_FALSE(view.ok());
    if (!view.ok()) {
      EXPECT_EQ(view.error().code, ErrorCode::kBadSnapshot);
    }
    words[i] ^= 1;
  }
  EXPECT_EQ(refusal(), "");
}

TEST_F(Damaged, anyShorterPieceIsRefused) {
  const auto whole = bytesOf(volume_.image);
  for (std::size_t n = 0; n < whole.size(); n += 64 * 37) EXPECT_FALSE(validateVolume(whole.first(n)).ok());
}

TEST_F(Damaged, numbersOfTheHeaderAreChecked) {
  const hd_volume_header good = header();
  const auto lie = [&](auto change) {
    header() = good;
    change(header());
    EXPECT_NE(refusal(), "");
    header() = good;
  };
  lie([](auto& h) { h.magic ^= 1; });
  lie([](auto& h) { h.version = HD_VOLUME_VERSION + 1; });
  lie([](auto& h) { h.flags = 1; });
  lie([](auto& h) { h.voxel = NAN; });
  lie([](auto& h) { h.fine_step = 0; });
  lie([](auto& h) { h.coarse_step = INFINITY; });
  lie([](auto& h) { h.area_step = -1; });
  lie([](auto& h) { h.cells[1] = 0; });
  lie([](auto& h) { h.cells[2] += 1; });
  lie([](auto& h) { h.cells[0] = 4000000000u; });
  lie([](auto& h) { h.brick_count += 1; });
  lie([](auto& h) { h.point_count = 0; });
  lie([](auto& h) { h.point_count += 16; });
  lie([](auto& h) { h.patch_level = h.level_count; });
  lie([](auto& h) { h.patch_count -= 1; });
  lie([](auto& h) { h.level_count = 14; });
  lie([](auto& h) { h.side_log2 += 1; });
  lie([](auto& h) { h.surface_voxels += 1; });
  lie([](auto& h) { h.level[1].split_log2 = 4; });
  lie([](auto& h) { h.level[1].mask_offset += 8; });
  lie([](auto& h) { h.level[1].first_offset += 1; });
  lie([](auto& h) { h.level[2].node_count = 0xffffffffu; });
  lie([](auto& h) { h.origin[0] = 1e9f; });
  lie([](auto& h) { h.lower[0] = h.upper[0]; });
  lie([](auto& h) { h.mass.volume = -1; });
  lie([](auto& h) { h.mass.inertia[0] = -1; });
  lie([](auto& h) { h.mass.inertia[3] = 1; });
  lie([](auto& h) { h.mass.centroid[2] = NAN; });
  for (auto& i : good.section) {
    const std::size_t n = static_cast<std::size_t>(&i - good.section);
    lie([n](auto& h) { h.section[n].offset += 64; });
    lie([n](auto& h) { h.section[n].offset = ~std::uint64_t{63}; });
    lie([n](auto& h) { h.section[n].bytes += 64; });
  }
  EXPECT_EQ(refusal(), "");
}

TEST_F(Damaged, indicesAndPlacesAreChecked) {
  const auto lie = [&](auto& place, auto value, const char* words) {
    const auto before = place;
    place = value;
    EXPECT_THAT(refusal(), ::testing::HasSubstr(words));
    place = before;
  };
  auto* const cells = section<std::uint32_t>(HD_VOLUME_CELLS);
  std::uint32_t with_brick = 0;
  while (cells[with_brick] == HD_NO_INDEX) ++with_brick;
  lie(cells[with_brick], header().brick_count, "past the last");
  lie(cells[with_brick], HD_NO_INDEX, "in no cell");
  lie(cells[with_brick], (cells[with_brick] + 1) % header().brick_count, "two cells");
  lie(section<float>(HD_VOLUME_POINT_Y)[3], NAN, "outside the box");
  lie(section<float>(HD_VOLUME_POINT_X)[5], header().lower[0], "does not hold its points");
  lie(section<std::uint32_t>(HD_VOLUME_FIRST)[1], 0x7fffffffu, "elsewhere");
  lie(section<std::uint8_t>(HD_VOLUME_SURFACE)[0], std::uint8_t{0}, "no surface");
  auto* const patches = section<hd_volume_patch>(HD_VOLUME_PATCHES);
  lie(patches[1].first, 0u, "not in place");
  lie(patches[0].count, 0xffffff00u, "not in place");
  lie(patches[0].radius, -1.0f, "out of range");
  lie(patches[0].area, -1.0f, "out of range");
  lie(section<hd_octree_sensation>(HD_VOLUME_SENSATION)[0].empty, NAN, "out of range");
  // Surface that is not occupied: on the root, where the lowest bit of a free place is taken.
  std::uint8_t& root = section<std::uint8_t>(HD_VOLUME_OCCUPIED)[0];
  lie(root, std::uint8_t{0}, "not occupied");
  EXPECT_EQ(refusal(), "");
}

}  // namespace
}  // namespace hapticd::test
