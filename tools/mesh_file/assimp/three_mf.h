/** @file
 * What assimp (5.2) takes for the model in 3MF packages: supports, and what else is not to be made.
 */
#pragma once

#include <string_view>

namespace hapticd_mesh_file {

/**
 * Throws MeshError if a package shows an object that its type says is no part of the model: a support, or what a slicer
 * keeps for itself. Of bytes that are no package it says nothing. Any bytes can be given.
 */
void requireModelsOnly(std::string_view bytes);

}  // namespace hapticd_mesh_file
