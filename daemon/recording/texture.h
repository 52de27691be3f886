/** @file
 * Textures of a recording: between recording.capnp, the servo's views and memory of one's own.
 */
#pragma once

#include <optional>

#include "daemon/recording/recording.h"
#include "proto/recording.capnp.h"

namespace hapticd {

inline constexpr std::uint32_t kReliefPartPixels = 1u << 19;  ///< A megabyte.

/** Parts of a texture: 1, or as many as a relief's pixels need. */
[[nodiscard]] std::uint32_t partsOf(const TextureView& texture);
void writePart(std::uint32_t entry, const TextureView& texture, std::uint32_t part, proto::TexturePart::Builder out);

/**
 * Puts parts together. What it gives is safe to read by a servo: counts, indices and numbers are checked as those of an
 * upload, whoever wrote the file.
 */
class TextureParts {
 public:
  /** A relief is not whole yet. */
  [[nodiscard]] bool pending() const { return relief_.has_value(); }
  /** The texture, once its last part is there. kInvalidArgument says what is wrong with the part. */
  [[nodiscard]] Result<std::optional<RecordedTexture>> take(proto::TexturePart::Reader part);

 private:
  Result<std::optional<RecordedTexture>> takeRelief(std::uint32_t entry, proto::ReliefPart::Reader part);

  std::optional<RecordedTexture> relief_;
};

}  // namespace hapticd
