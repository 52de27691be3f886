#include "daemon/ipc/snapshot_memory.h"

#include <algorithm>
#include <cstring>

#include "rt/scene/snapshot_checksum.h"
#include "rt/scene/vertex_motion.h"

namespace hapticd {

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
  auto motion = addMotion(*view);
  if (!motion) return motion.error();
  for (Mapping* const memory : {&*mapping, &*motion}) {
    if (!lock || !*memory) continue;
    if (const auto locked = memory->lock(); !locked) return locked.error();
  }
  return SnapshotMemory{std::move(*mapping), std::move(*motion), *view};
}

Result<Mapping> addMotion(MeshView& view) {
  if (view.deform.vertices == nullptr) return Mapping{};
  auto file = Memfd::create("hapticd-motion", view.vertex_count * sizeof(VertexMotion));
  if (!file) return file.error();
  auto memory = file->map(Memfd::Access::kWrite);
  if (memory) view.deform.motion = memory->as<VertexMotion>();  // All zero: none has moved.
  return memory;
}

std::vector<std::byte> copyDeformed(std::span<const std::byte> snapshot) {
  std::vector<std::byte> copy(snapshot.begin(), snapshot.end());
  hd_snapshot_header header;
  std::memcpy(&header, copy.data(), sizeof header);
  hd_bvh_node root;
  std::memcpy(&root, copy.data() + header.section[HD_SECTION_NODES].offset, sizeof root);
  for (int axis = 0; axis < 3; ++axis) {
    header.lower[axis] = *std::min_element(root.lower[axis], root.lower[axis] + root.used);
    header.upper[axis] = *std::max_element(root.upper[axis], root.upper[axis] + root.used);
  }
  header.checksum = snapshotChecksum(std::span<const std::byte>(copy).subspan(sizeof header));
  std::memcpy(copy.data(), &header, sizeof header);
  return copy;
}

}  // namespace hapticd
