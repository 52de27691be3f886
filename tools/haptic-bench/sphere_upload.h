/** @file
 * A sphere as a client uploads it, for benchmarks.
 */
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace haptic_bench {

/** S stacks by 2 S slices about the origin, with at least `triangles` triangles of radius `radius` [m]. */
[[nodiscard]] std::vector<std::byte> sphereUpload(std::uint32_t triangles, double radius);

}  // namespace haptic_bench
