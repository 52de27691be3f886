/** @file
 * What assimp does not say of STL files.
 */
#pragma once

#include <string>

namespace hapticd_mesh_file {

/** Of one that assimp takes for neither kind of STL: what its size says. */
[[nodiscard]] std::string whyNoStl(const std::string& path);

/** Whether it is STL in words whose last facet has no end: assimp leaves that out and is content. */
[[nodiscard]] bool endsInAFacet(const std::string& path);

}  // namespace hapticd_mesh_file
