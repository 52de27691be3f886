// Built models that went bad: validateSnapshot() on a patched snapshot whose checksum was made to fit, as by somebody
// who means it. What it accepts, a sweep walks within its work limit and its numbers.
#include <fuzzer/FuzzedDataProvider.h>

#include "rt/geometry/sweep.h"
#include "rt/scene/snapshot_checksum.h"
#include "tests/unit/builder/meshes.h"

namespace {

using namespace hapticd;  // NOLINT(google-build-using-namespace)

std::vector<std::byte> built(std::uint32_t flags) {
  BuildMonitor monitor;
  const auto snapshot = buildSnapshot(test::upload(test::torus(6, 5), flags), monitor);
  if (!snapshot.ok()) __builtin_trap();
  const auto mapping = snapshot.value().memfd.map(Memfd::Access::kRead);
  if (!mapping.ok()) __builtin_trap();
  return {mapping.value().data(), mapping.value().data() + mapping.value().size()};
}

void sweepThrough(const MeshView& mesh, FuzzedDataProvider& data) {
  for (int n = 0; n < 4; ++n) {
    Sweep sweep;
    for (int i = 0; i < 3; ++i) {
      sweep.a[i] = data.ConsumeFloatingPointInRange<double>(-0.1, 0.1);
      sweep.d[i] = data.ConsumeFloatingPointInRange<double>(-0.1, 0.1);
    }
    sweep.tolerance = 1e-9;
    sweep.radius = n % 2 == 0 ? 0 : 0.01;
    sweep.limit = 200;
    SweepHit hit;
    if (sweepMesh(mesh, sweep, hit) != SweepResult::kHit) continue;
    if (hit.feature >= mesh.triangle_count || !(hit.t >= 0 && hit.t < 1) || !isFinite(hit.normal)) __builtin_trap();
  }
}

/** Moves every vertex that can move; the refit stays within the snapshot and its boxes stay boxes. */
void moveEach(MeshView& mesh, FuzzedDataProvider& data) {
  for (std::uint32_t v = 0; v < mesh.deform.source_count; ++v) {
    const float p[3] = {data.ConsumeFloatingPointInRange(-100.0f, 100.0f), 0.01f * static_cast<float>(v), 0};
    if (moveVertex(mesh, v, p) != ErrorCode::kOk) __builtin_trap();
  }
  for (int k = 0; k < 3; ++k)
    for (std::uint32_t c = 0; c < mesh.nodes[0].used; ++c)
      if (!(mesh.nodes[0].lower[k][c] <= mesh.nodes[0].upper[k][c])) __builtin_trap();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  static const std::vector<std::byte> kGood[] = {built(0), built(HD_MESH_DEFORMABLE)};
  FuzzedDataProvider data(bytes, size);
  const std::vector<std::byte>& good = kGood[data.ConsumeBool() ? 1 : 0];
  // Its own allocation, so that the address sanitizer stands right behind the last byte; snapshots are page aligned.
  const std::unique_ptr<std::byte, decltype(&std::free)> memory(
      static_cast<std::byte*>(std::aligned_alloc(64, good.size())), &std::free);
  std::memcpy(memory.get(), good.data(), good.size());
  for (auto n = data.ConsumeIntegralInRange<int>(0, 8); n > 0; --n) {
    // Half of the patches go to the header, where a word decides most.
    const std::size_t end = data.ConsumeBool() ? sizeof(hd_snapshot_header) : good.size();
    const auto at = data.ConsumeIntegralInRange<std::size_t>(0, end / 4 - 1) * 4;
    const auto word =
        data.ConsumeBool() ? data.ConsumeIntegralInRange<std::uint32_t>(0, 300) : data.ConsumeIntegral<std::uint32_t>();
    std::memcpy(memory.get() + at, &word, sizeof word);
  }
  const std::size_t kept = data.ConsumeBool() ? good.size() : data.ConsumeIntegralInRange<std::size_t>(0, good.size());
  const std::span<const std::byte> snapshot(memory.get(), kept);
  if (kept >= sizeof(hd_snapshot_header) && data.ConsumeBool()) {
    auto& header = *reinterpret_cast<hd_snapshot_header*>(memory.get());
    if (kept % 8 == 0) header.checksum = snapshotChecksum(snapshot.subspan(sizeof header));
  }
  auto view = validateSnapshot(snapshot);
  if (view.ok()) sweepThrough(*view, data);
  if (view.ok()) moveEach(*view, data);
  if (!view.ok() && view.error().what.empty()) __builtin_trap();
  return 0;
}
