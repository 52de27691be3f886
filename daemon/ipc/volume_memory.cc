#include "daemon/ipc/volume_memory.h"

namespace hapticd {

Result<VolumeMemory> openVolume(UniqueFd fd, bool lock) {
  auto memfd = Memfd::adopt(std::move(fd));
  if (!memfd) return memfd.error();
  if (const auto sealed = memfd->requireSeals(Seals::kFrozen); !sealed) return sealed.error();
  auto mapping = memfd->map(Memfd::Access::kRead);
  if (!mapping) return mapping.error();
  auto view = validateVolume(mapping->bytes());
  if (!view) return view.error();
  if (lock)
    if (const auto locked = mapping->lock(); !locked) return locked.error();
  return VolumeMemory{std::move(*mapping), *view};
}

}  // namespace hapticd
