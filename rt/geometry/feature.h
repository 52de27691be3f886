/** @file
 * What a point of a surface belongs to.
 */
#pragma once

#include <cstdint>

namespace hapticd {

enum class FeatureKind : std::uint8_t { kFace, kEdge, kVertex };

}  // namespace hapticd
