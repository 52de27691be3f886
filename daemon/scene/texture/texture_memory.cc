#include "daemon/scene/texture/texture_memory.h"

#include <memory>
#include <new>

#include "daemon/scene/texture/ar_model.h"

namespace hapticd {

std::size_t layOutBytes(const Texture& texture) noexcept {
  return sizeof(TextureView) + texture.relief.pixels.size() * sizeof(std::uint16_t) +
         texture.vibration.models.size() * sizeof(VibrationModel) +
         texture.vibration.triangles.size() * sizeof(VibrationView::Corners);
}

Result<TextureMemory> layOut(const Texture& texture, std::int64_t period_ns, bool lock) {
  auto file = Memfd::create("hapticd-texture", layOutBytes(texture));
  if (!file) return file.error();
  auto mapping = file->map(Memfd::Access::kWrite);
  if (!mapping) return mapping.error();
  TextureMemory memory{std::move(*mapping)};
  auto* view = new (memory.mapping.data()) TextureView;
  std::byte* next = memory.mapping.data() + sizeof(TextureView);
  if (texture.isRelief()) {
    const Relief& relief = texture.relief;
    auto* pixel = reinterpret_cast<std::uint16_t*>(next);
    std::uninitialized_copy(relief.pixels.begin(), relief.pixels.end(), pixel);
    view->relief = {pixel, relief.width, relief.height};
  } else {
    const RecordedVibration& vibration = texture.vibration;
    VibrationView& out = view->vibration;
    auto* model = reinterpret_cast<VibrationModel*>(next);
    out.model = model;
    for (const RecordedModel& recorded : vibration.models) {
      const LatticeModel lattice =
          resample(recorded.a, recorded.variance, vibration.rate_hz, 1e9 / static_cast<double>(period_ns));
      new (model++) VibrationModel{recorded.speed, recorded.force, lattice.power, lattice.reflection};
    }
    auto* triangle = reinterpret_cast<VibrationView::Corners*>(model);
    std::uninitialized_copy(vibration.triangles.begin(), vibration.triangles.end(), triangle);
    out.triangle = triangle;
    out.triangles = static_cast<std::uint32_t>(vibration.triangles.size());
    out.findBounds();
  }
  if (lock) {
    if (auto r = memory.mapping.lock(); !r) return r.error();
  }
  return memory;
}

}  // namespace hapticd
