/** @file
 * A sphere with bumps, of any number of triangles, whose surface has a closed form: for strokes over fine meshes.
 */
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "rt/base/math.h"

namespace haptic_bench {

/** Distance of the surface from the centre in the (unit) direction given [m]: 50 mm and waves of 0.5 mm. */
[[nodiscard]] double bumpyRadius(const hapticd::Vec3& direction);

/**
 * An octahedron's faces divided into n x n triangles each, blown up onto that surface; as a client uploads it. 8 n^2
 * triangles, the fewest that are not less than `triangles`.
 */
[[nodiscard]] std::vector<std::byte> bumpySphereUpload(std::uint32_t triangles);
/** How many it has then. */
[[nodiscard]] std::uint32_t bumpySphereTriangles(std::uint32_t triangles);

}  // namespace haptic_bench
