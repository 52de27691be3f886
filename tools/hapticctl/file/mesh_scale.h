/** @file
 * The unit of a mesh file, which it does not say or assimp does not read: asked for, told and applied.
 */
#pragma once

#include <string>
#include <string_view>

#include "tools/mesh_file/mesh_file.h"

namespace hapticctl {

using hapticd_mesh_file::MeshFile;

/** Metres per file unit: a unit (um, mm, cm, m, inch, ft) or a positive number. Fails with usage. */
[[nodiscard]] double parseScale(std::string_view text);
/** Why a scale is needed: what the file's format says of its unit. */
[[nodiscard]] std::string whyScale(const MeshFile& mesh);
/** The box in file units, and what each usual unit would make of it: what one needs to choose a scale. */
[[nodiscard]] std::string scaleAdvice(const MeshFile& mesh);

/** Moves the middle of the box to the origin. */
void centre(MeshFile& mesh);
/** Multiplies by metres per file unit. Fails with usage of `option` when the result is too small or large to touch. */
void scale(MeshFile& mesh, double metres_per_unit, const char* option = "--scale");
/** Of a mesh in metres that is larger or smaller than what hands touch, as one in mm that was taken for metres; else
 * "". */
[[nodiscard]] std::string sizeNote(const MeshFile& mesh);

}  // namespace hapticctl
