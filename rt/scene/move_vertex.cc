#include <algorithm>
#include <atomic>
#include <cmath>

#include "rt/scene/mesh_view.h"
#include "rt/scene/refit.h"

namespace hapticd {

ErrorCode mayMoveVertex(const MeshView& mesh, std::uint32_t vertex, const float (&p)[3]) HD_RT {
  if (mesh.deform.vertices == nullptr) return ErrorCode::kUnsupported;
  if (vertex >= mesh.deform.source_count) return ErrorCode::kNotFound;
  for (const float x : p)
    if (!(std::fabs(x) <= HD_MAX_COORDINATE)) return ErrorCode::kInvalidArgument;
  return ErrorCode::kOk;
}

ErrorCode moveVertex(MeshView& mesh, std::uint32_t vertex, const float (&p)[3], Refit& refit) HD_RT {
  if (const ErrorCode refused = mayMoveVertex(mesh, vertex, p); refused != ErrorCode::kOk) return refused;
  MeshView::Deform& d = mesh.deform;
  const std::uint32_t v = d.source_vertex[vertex];
  if (v == HD_NO_INDEX) return ErrorCode::kOk;                             // of no triangle: nothing to move
  std::atomic_ref(d.moves).store(d.moves + 1, std::memory_order_relaxed);  // A recording that begins looks at it.
  std::copy_n(p, 3, d.vertices[v]);
  for (std::uint32_t i = d.vertex_first[v]; i < d.vertex_first[v + 1]; ++i) {
    const std::uint32_t t = d.vertex_triangles[i];
    for (int c = 0; c < 3; ++c)
      if (mesh.triangles[t][c] == v) std::copy_n(p, 3, d.corners[t][c]);
    refit.add(t);
  }
  return ErrorCode::kOk;
}

ErrorCode moveVertex(MeshView& mesh, std::uint32_t vertex, const float (&p)[3]) HD_RT {
  Refit refit(mesh);
  const ErrorCode result = moveVertex(mesh, vertex, p, refit);
  refit.finish();
  return result;
}

}  // namespace hapticd
