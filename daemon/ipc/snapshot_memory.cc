#include "daemon/ipc/snapshot_memory.h"

#include <algorithm>
#include <cstring>

#include "rt/scene/snapshot_checksum.h"
#include "rt/scene/vertex_motion.h"

namespace hapticd {
namespace {

/** The place in `to` that `there` has in `from`. */
template <class T>
T* moved(T* there, const Mapping& from, const Mapping& to) {
  const auto* const at = reinterpret_cast<const std::byte*>(there);
  return reinterpret_cast<T*>(const_cast<std::byte*>(to.data() + (at - from.data())));
}

/** A view of `to`, which holds what `from` held before its servo wrote there: only that is not read. */
MeshView viewIn(const Mapping& to, const MeshView& view, const Mapping& from) {
  static_assert(sizeof(MeshView) == 168 && sizeof(MeshView::Deform) == 104, "a new field belongs here, too");
  MeshView out;
  out.vertices = moved(view.vertices, from, to);
  out.triangles = moved(view.triangles, from, to);
  out.neighbours = moved(view.neighbours, from, to);
  out.nodes = moved(view.nodes, from, to);
  out.corners = moved(view.corners, from, to);
  out.vertex_count = view.vertex_count;
  out.triangle_count = view.triangle_count;
  out.node_count = view.node_count;
  out.depth = view.depth;
  out.flags = view.flags;
  MeshView::Deform& d = out.deform;
  d.vertices = moved(view.deform.vertices, from, to);
  d.corners = moved(view.deform.corners, from, to);
  d.nodes = moved(view.deform.nodes, from, to);
  d.parents = moved(view.deform.parents, from, to);
  d.vertex_first = moved(view.deform.vertex_first, from, to);
  d.vertex_triangles = moved(view.deform.vertex_triangles, from, to);
  d.triangle_leaf = moved(view.deform.triangle_leaf, from, to);
  d.source_vertex = moved(view.deform.source_vertex, from, to);
  d.source_count = view.deform.source_count;
  return out;
}

/** With memory for its motion, locked if `lock`. */
Result<SnapshotMemory> finished(Mapping mapping, MeshView view, bool lock) {
  auto motion = addMotion(view);
  if (!motion) return motion.error();
  for (Mapping* const memory : {&mapping, &*motion}) {
    if (!lock || !*memory) continue;
    if (const auto locked = memory->lock(); !locked) return locked.error();
  }
  return SnapshotMemory{std::move(mapping), std::move(*motion), view};
}

}  // namespace

Result<SnapshotMemory> openSnapshot(UniqueFd fd, bool lock) {
  auto memfd = Memfd::adopt(std::move(fd));
  if (!memfd) return memfd.error();
  if (const auto sealed = memfd->requireSeals(Seals::kFrozen); !sealed) return sealed.error();
  auto mapping = memfd->map(Memfd::Access::kRead);
  if (!mapping) return mapping.error();
  const auto* const header = mapping->as<hd_snapshot_header>();
  if (header != nullptr && (header->flags & HD_MESH_DEFORMABLE) != 0) {
    mapping = memfd->map(Memfd::Access::kPrivate);
    if (!mapping) return mapping.error();
  }
  auto view = validateSnapshot(mapping->bytes());
  if (!view) return view.error();
  return finished(std::move(*mapping), *view, lock);
}

Result<SnapshotMemory> copySnapshot(UniqueFd fd, const SnapshotMemory& checked, bool lock) {
  auto memfd = Memfd::adopt(std::move(fd));
  if (!memfd) return memfd.error();
  if (const auto sealed = memfd->requireSeals(Seals::kFrozen); !sealed) return sealed.error();
  auto mapping = memfd->map(Memfd::Access::kPrivate);
  if (!mapping) return mapping.error();
  const MeshView view = viewIn(*mapping, checked.view, checked.mapping);
  return finished(std::move(*mapping), view, lock);
}

Result<Mapping> addMotion(MeshView& view) {
  if (view.deform.vertices == nullptr) return Mapping{};
  auto file = Memfd::create("hapticd-motion", view.vertex_count * sizeof(VertexMotion));
  if (!file) return file.error();
  auto memory = file->map(Memfd::Access::kWrite);
  if (memory) view.deform.motion = memory->as<VertexMotion>();  // All zero: none has moved.
  return memory;
}

void copyMoved(std::span<const std::byte> snapshot, std::span<std::byte> copy) noexcept {
  hd_snapshot_header header;
  std::memcpy(&header, copy.data(), sizeof header);
  for (const auto section : {HD_SECTION_VERTICES, HD_SECTION_NODES, HD_SECTION_CORNERS}) {
    const hd_section& moves = header.section[section];
    std::memcpy(copy.data() + moves.offset, snapshot.data() + moves.offset, moves.bytes);
  }
}

void closeDeformed(std::span<std::byte> copy) noexcept {
  hd_snapshot_header header;
  std::memcpy(&header, copy.data(), sizeof header);
  hd_bvh_node root;
  std::memcpy(&root, copy.data() + header.section[HD_SECTION_NODES].offset, sizeof root);
  for (int axis = 0; axis < 3; ++axis) {
    header.lower[axis] = *std::min_element(root.lower[axis], root.lower[axis] + root.used);
    header.upper[axis] = *std::max_element(root.upper[axis], root.upper[axis] + root.used);
  }
  header.checksum = snapshotChecksum(copy.subspan(sizeof header));
  std::memcpy(copy.data(), &header, sizeof header);
}

}  // namespace hapticd
