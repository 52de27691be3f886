// Meshes as clients upload them: whatever the bytes, the builder refuses with a reason or makes a snapshot that passes.
#include <fuzzer/FuzzedDataProvider.h>

#include "rt/scene/mesh_view.h"
#include "tests/unit/builder/meshes.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace hapticd;  // NOLINT(google-build-using-namespace)
  FuzzedDataProvider data(bytes, size);
  static const std::vector<std::byte> kGood = test::upload(test::torus(5, 4), HD_MESH_DEFORMABLE);
  std::vector<std::byte> upload = kGood;
  if (data.ConsumeBool()) {
    const auto raw = data.ConsumeRemainingBytes<std::uint8_t>();
    upload.assign(reinterpret_cast<const std::byte*>(raw.data()),
                  reinterpret_cast<const std::byte*>(raw.data()) + raw.size());
  } else {
    while (data.remaining_bytes() > 4) {
      const auto at = data.ConsumeIntegralInRange<std::size_t>(0, upload.size() / 4 - 1) * 4;
      const auto small = data.ConsumeIntegralInRange<std::uint32_t>(0, 40);
      const auto coordinate = static_cast<float>(small) * 0.01f;
      const auto any = data.ConsumeIntegral<std::uint32_t>();
      const void* const words[] = {&small, &coordinate, &any};
      std::memcpy(upload.data() + at, words[data.ConsumeIntegralInRange<std::size_t>(0, 2)], 4);
    }
  }
  BuildMonitor monitor;
  const auto snapshot = buildSnapshot(upload, monitor);
  if (!snapshot.ok()) {
    if (snapshot.error().what.empty()) __builtin_trap();
    return 0;
  }
  const auto mapping = snapshot.value().memfd.map(Memfd::Access::kRead);
  if (!mapping.ok() || !validateSnapshot(mapping.value().bytes()).ok()) __builtin_trap();
  return 0;
}
