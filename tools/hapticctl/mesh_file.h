/** @file
 * Triangles out of a mesh file (STL, OBJ, PLY, 3DS, glTF and what else assimp reads), as hapticd wants them.
 */
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace hapticctl {

/** One indexed mesh. Coordinates in the file's own unit until scaled. */
struct MeshFile {
  std::string path;
  std::vector<std::array<float, 3>> vertices;  ///< Equal positions are one vertex.
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::array<double, 3> lower{}, upper{};  ///< Box of the vertices.
  std::size_t meshes = 0;   ///< How many of the file's meshes were merged, each through its node transforms.
  std::size_t skipped = 0;  ///< Points and lines left out.
};

/**
 * Reads and merges. Throws Failure (kExitFile) that names the file and what is wrong: unreadable, unknown format, no
 * triangles (points or lines only), a vertex that is not finite (and which).
 */
[[nodiscard]] MeshFile readMesh(const std::string& path);

/** Metres per file unit: a unit (um, mm, cm, m, inch, ft) or a positive number. Fails with usage. */
[[nodiscard]] double parseScale(std::string_view text);
/** The box in file units, and what each usual unit would make of it: what one needs to choose a scale. */
[[nodiscard]] std::string scaleAdvice(const MeshFile& mesh);

/** Moves the middle of the box to the origin. */
void centre(MeshFile& mesh);
/** Multiplies by metres per file unit. Fails with usage when the result is too small or too large to touch. */
void scale(MeshFile& mesh, double metres_per_unit);

}  // namespace hapticctl
