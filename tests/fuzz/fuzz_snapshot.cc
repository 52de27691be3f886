// Built models that went bad: validateSnapshot() on a patched snapshot whose checksum was made to fit, as by somebody
// who means it. What it accepts, a sweep walks within its work limit and its numbers.
#include <fuzzer/FuzzedDataProvider.h>

#include "rt/geometry/sweep/sweep.h"
#include "tests/fuzz/spoilt.h"
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
  const Spoilt<hd_snapshot_header> snapshot(kGood[data.ConsumeBool() ? 1 : 0], data);
  auto view = validateSnapshot(snapshot.bytes());
  if (view.ok()) sweepThrough(*view, data);
  if (view.ok()) moveEach(*view, data);
  if (!view.ok() && view.error().what.empty()) __builtin_trap();
  return 0;
}
