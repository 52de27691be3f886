// Texture models as XML: whatever the text, refused with a place or usable.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "tools/hapticctl/failure.h"
#include "tools/hapticctl/file/hatt_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace hapticctl;
  const std::string text(reinterpret_cast<const char*>(data), size);
  try {
    const HattFile file = parseHatt(text, "fuzz");
    if (file.models.size() < 3 || file.triangles.empty()) std::abort();
    for (const HattModel& model : file.models) {
      if (model.a.size() != file.models.front().a.size()) std::abort();
      for (const double a : model.a) {
        if (!std::isfinite(a)) std::abort();
      }
    }
    for (const auto& triangle : file.triangles) {
      for (const std::uint32_t corner : triangle) {
        if (corner >= file.models.size()) std::abort();
      }
    }
  } catch (const Failure& failure) {
    if (failure.where.rfind("fuzz", 0) != 0 || failure.what.empty() || failure.exit != kExitFile) std::abort();
  }
  return 0;
}
