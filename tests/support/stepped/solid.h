/** @file
 * The order that puts an object into a servo's scene.
 */
#pragma once

#include "rt/scene/scene.h"

namespace hapticd::test {

/** Enabled, directly below the root; `size` as Shape has it. */
[[nodiscard]] inline AddObject solid(std::uint32_t id, ShapeKind kind, const hd_material& material, const Pose& X = {},
                                     const Vec3& size = Vec3::Zero()) {
  AddObject out{};
  out.object = id;
  out.flags = HD_OBJECT_ENABLED;
  out.shape.kind = static_cast<std::uint32_t>(kind);
  store(size, out.shape.size);
  out.material = material;
  store(X.p, out.p);
  store(X.q, out.q);
  return out;
}

}  // namespace hapticd::test
