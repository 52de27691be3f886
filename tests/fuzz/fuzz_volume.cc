// Built volumes that went bad: validateVolume() on a patched volume whose checksum was made to fit, as by somebody who
// means it. What it accepts is looked up and walked within its arrays.
#include <fuzzer/FuzzedDataProvider.h>

#include "daemon/builder/volume/mesh_volume.h"
#include "rt/volume/distance.h"
#include "rt/volume/octahedral.h"
#include "tests/fuzz/spoilt.h"
#include "tests/unit/builder/meshes.h"

namespace {

using namespace hapticd;  // NOLINT(google-build-using-namespace)

std::vector<std::byte> built(OctreeShape shape, bool sensation) {
  VolumeOptions options;
  options.octree = shape;
  options.sensation = sensation;
  BuildMonitor monitor;
  const test::UploadMesh torus = test::torus(6, 5);
  const auto image = buildMeshVolume(torus.vertices, torus.triangles, 0.01, options, monitor);
  if (!image.ok()) __builtin_trap();
  const auto bytes = bytesOf(*image);
  return {bytes.begin(), bytes.end()};
}

void lookAbout(const VolumeView& volume, FuzzedDataProvider& data) {
  for (int n = 0; n < 8; ++n) {
    Vec3 x;
    for (int i = 0; i < 3; ++i) x[i] = data.ConsumeFloatingPointInRange<double>(-0.2, 0.2);
    const DistanceSample sample = distanceAt(volume, x);
    if (!std::isfinite(sample.value) || !isFinite(sample.gradient)) __builtin_trap();
    (void)voxelState(volume.octree, data.ConsumeIntegralInRange(-20, 300), data.ConsumeIntegralInRange(-20, 300),
                     data.ConsumeIntegralInRange(-20, 300));
  }
  double sum = 0;
  for (const hd_volume_patch& patch : volume.patches)
    for (std::uint32_t i = patch.first; i < patch.first + patch.count; ++i)
      sum += octahedralNormal(volume.normal[i]).dot(volume.pointAt(i)) * volume.area[i];
  if (!std::isfinite(sum)) __builtin_trap();
  for (std::uint32_t l = 0; l < volume.octree.levels; ++l) {
    const OctreeLevel& level = volume.octree.level[l];
    const std::uint32_t next =
        l + 1 < volume.octree.levels ? volume.octree.level[l + 1].node_count : volume.header->surface_voxels;
    for (std::uint32_t node = 0; node < level.node_count; ++node) {
      forEachChild(level, node, [&](std::uint32_t place, std::uint32_t child) {
        if (place >= 8u << (3 * level.split - 3) || child >= next) __builtin_trap();
      });
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  static const std::vector<std::byte> kGood[] = {built(OctreeShape::kMixed, true),
                                                 built(OctreeShape::kFiveTwelve, false)};
  FuzzedDataProvider data(bytes, size);
  const Spoilt<hd_volume_header> volume(kGood[data.ConsumeBool() ? 1 : 0], data);
  const auto view = validateVolume(volume.bytes());
  if (view.ok()) lookAbout(*view, data);
  if (!view.ok() && view.error().what.empty()) __builtin_trap();
  return 0;
}
