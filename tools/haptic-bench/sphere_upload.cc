#include "tools/haptic-bench/sphere_upload.h"

#include "tools/haptic-bench/model/shapes.h"

namespace haptic_bench {

std::vector<std::byte> sphereUpload(std::uint32_t triangles, double radius) {
  int stacks = 3;
  while (4 * stacks * (stacks - 1) < static_cast<int>(triangles)) ++stacks;
  return upload(sphere(radius, stacks));
}

}  // namespace haptic_bench
