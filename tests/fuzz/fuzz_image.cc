// Projects of InVesalius: any bytes; what is read has a surface that is drawn. And where headers say that values lie.
#include <cmath>
#include <cstdint>

#include "tools/hapticctl-import/format/image_file.h"
#include "tools/hapticctl-import/header/data_files.h"
#include "tools/hapticctl-import/header/data_place.h"
#include "tools/hapticctl-import/isosurface.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace hapticctl_import;  // NOLINT(google-build-using-namespace)
  const std::string_view text(reinterpret_cast<const char*>(bytes), size);
  for (const DataPlace& place : {metaImagePlace(text), nrrdPlace(text)})
    if (place.countable && place.in_several) __builtin_trap();
  if (const DataPlace place = nrrdPlace(text); place.in_several) {
    for (const std::string& name : nrrdFiles(place.several, text.substr(place.list)))
      if (name.empty()) __builtin_trap();
  }
  try {
    for (const std::string& name : metaImageFiles(text))
      if (name.empty()) __builtin_trap();
  } catch (const ImportError& error) {
    if (*error.what() == '\0') __builtin_trap();
  }
  try {
    const Image image = parseInvesalius(text);
    if (image.values.size() != std::size_t{image.size[0]} * image.size[1] * image.size[2]) __builtin_trap();
    for (const float v : image.values)
      if (!std::isfinite(v)) __builtin_trap();
    if (image.values.size() > 4096) return 0;
    const Surface surface = isosurface(image, image.values[0]);
    for (const auto& t : surface.triangles)
      for (const std::uint32_t v : t)
        if (v >= surface.vertices.size()) __builtin_trap();
  } catch (const ImportError& error) {
    if (*error.what() == '\0') __builtin_trap();
  }
  return 0;
}
