#include "tools/haptic-bench/load/built_surface.h"

#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/model/built_mesh.h"

namespace haptic_bench {

BuiltSurface::BuiltSurface(const Model& model) : snapshot_(buildMesh(model)), client_(clientMesh(model)) {
  meshes_.publish(0, &snapshot_.view);
}

haptic::SurfaceMesh clientMesh(const Model& model) {
  auto made = haptic::SurfaceMesh::make({model.vertices.data()->data(), 3 * model.vertices.size()},
                                        {model.triangles.data()->data(), 3 * model.triangles.size()});
  if (!made) throw Failure(model.name, made.error().what, made.error().remedy);
  return std::move(*made);
}

}  // namespace haptic_bench
