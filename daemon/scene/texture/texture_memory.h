/** @file
 * A texture in the daemon's memory as one servo reads it.
 */
#pragma once

#include "daemon/ipc/memfd.h"
#include "daemon/scene/texture/texture.h"
#include "rt/scene/texture.h"

namespace hapticd {

/** Owns the memory that the view lies in and points into. The servo must have passed before it goes. */
struct TextureMemory {
  Mapping mapping;
  [[nodiscard]] const TextureView* view() const noexcept { return mapping.as<const TextureView>(); }
};

/** Lays it out for a servo of that period; models of vibration are resampled to it. If `lock`, the pages are locked. */
[[nodiscard]] Result<TextureMemory> layOut(const Texture& texture, std::int64_t period_ns, bool lock);

/** Bytes that layOut() takes. */
[[nodiscard]] std::size_t layOutBytes(const Texture& texture) noexcept;

}  // namespace hapticd
