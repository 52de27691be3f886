// Vertices that clients move.
#include <algorithm>

#include "rt/scene/refit.h"
#include "rt/scene/scene.h"

namespace hapticd {

ErrorCode Scene::moveVertices(const hd_object_vertices& order) HD_RT {
  SceneObject* object = findMutable(order.object);
  if (!object) return ErrorCode::kNotFound;
  if (order.count > HD_VERTEX_MOVES) return ErrorCode::kInvalidArgument;
  if (object->shape.kind != ShapeKind::kMesh) return ErrorCode::kUnsupported;
  MeshView* mesh = object->shape.mesh;
  for (std::uint32_t i = 0; i < order.count; ++i) {
    const ErrorCode refused = mayMoveVertex(*mesh, order.move[i].index, order.move[i].p);
    if (refused != ErrorCode::kOk) return refused;
  }
  Refit refit(*mesh);
  for (std::uint32_t i = 0; i < order.count; ++i) {
    const hd_vertex_move& move = order.move[i];
    const MeshView::Deform& d = mesh->deform;
    const std::uint32_t vertex = d.motion && move.index < d.source_count ? d.source_vertex[move.index] : HD_NO_INDEX;
    float from[3] = {};
    if (vertex < mesh->vertex_count) std::copy_n(mesh->vertices[vertex], 3, from);
    const std::uint32_t noted = moves_are_new_ ? move_count_ : 0;
    noteTriangles(*mesh, move);
    if (moves_are_new_ && move_count_ > noted) mesh->deform.noted = advances_ + 1;
    moveVertex(*mesh, move.index, move.p, refit);
    if (vertex < mesh->vertex_count) noteMotion(*mesh, vertex, from, time_ + dt_, dt_);  // In the tick that comes.
  }
  refit.finish();
  for (std::uint32_t i = 0; i < order_count_; ++i) {  // Others may show the same mesh.
    SceneObject& other = objects_[order_[i]];
    if (other.shape.mesh == mesh) other.placeBall();
  }
  return ErrorCode::kOk;
}

/** Keeps what the triangles about a vertex are like before it moves. */
void Scene::noteTriangles(const MeshView& mesh, const hd_vertex_move& move) HD_RT {
  const MeshView::Deform& d = mesh.deform;
  if (!d.vertices || move.index >= d.source_count) return;
  const std::uint32_t v = d.source_vertex[move.index];
  if (v >= mesh.vertex_count) return;
  if (!moves_are_new_) move_count_ = 0;
  moves_are_new_ = true;
  for (std::uint32_t i = d.vertex_first[v]; i < d.vertex_first[v + 1] && move_count_ < kMaxTriangleMoves; ++i) {
    TriangleMove& note = moves_[move_count_++];
    note.mesh = &mesh;
    note.triangle = d.vertex_triangles[i];
    for (std::uint32_t c = 0; c < 3; ++c) {
      const std::uint32_t corner = mesh.triangles[note.triangle][c];
      std::copy_n(mesh.vertices[corner], 3, note.before[c]);
      if (corner == v) note.corner = c;
    }
    std::copy_n(move.p, 3, note.after);
  }
}

}  // namespace hapticd
