// Textures as clients upload them: whatever the bytes, refused with a reason or laid out so that the servo stays sane.
#include <cmath>
#include <cstdlib>
#include <vector>

#include "daemon/scene/texture/texture_memory.h"
#include "rt/render/surface/relief.h"
#include "rt/render/surface/vibration.h"
#include "tests/support/shape/texture_upload.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace hapticd;  // NOLINT(google-build-using-namespace)
  // Most inputs change bytes of a good upload: two of position, one of value.
  std::vector<std::byte> upload;
  if (size > 0 && data[0] < 8) {
    upload.assign(reinterpret_cast<const std::byte*>(data + 1), reinterpret_cast<const std::byte*>(data + size));
  } else {
    upload = size > 0 && data[0] % 2 == 0 ? test::vibrationUpload() : test::reliefUpload(2, 2, {1, 2, 3, 4});
    for (std::size_t i = 1; i + 2 < size; i += 3)
      upload[(data[i] * 256u + data[i + 1]) % upload.size()] = static_cast<std::byte>(data[i + 2]);
  }
  const auto texture = parseTexture(upload);
  if (!texture.ok()) {
    if (texture.error().where.empty() || texture.error().what.empty()) std::abort();
    return 0;
  }
  const auto memory = layOut(*texture, 1'000'000, false);
  if (!memory.ok()) std::abort();
  if (texture->isRelief()) {
    SurfaceParameters surface{};
    surface.relief_depth = surface.relief_size[0] = surface.relief_size[1] = 0.01;
    const ReliefPoint point = reliefAt(memory->view()->relief, surface, {0.1, -0.2, 0.3}, Vec3(1, 2, 3).normalized());
    if (!std::isfinite(point.height) || !isFinite(point.gradient)) std::abort();
    return 0;
  }
  Vibration vibration;
  for (int i = 0; i < 50; ++i) {
    if (!std::isfinite(vibration.step(memory->view()->vibration, 0.01 * i, 0.1 * i))) std::abort();
  }
  return 0;
}
