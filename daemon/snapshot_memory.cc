#include "daemon/snapshot_memory.h"

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
  if (lock)
    if (const auto locked = mapping->lock(); !locked) return locked.error();
  return SnapshotMemory{std::move(*mapping), *view};
}

}  // namespace hapticd
