/** @file
 * What a file of the volume cache begins with: written and read by the daemon, read by hapticd-builder-vdb. And what
 * the file is called that this makes of it.
 */
#pragma once

#include <cstdint>

#include "proto/volume.h"

namespace hapticd {

/**
 * Part of each cached volume's name: raise it with every change of what the builder makes of the same upload (builder/,
 * builder/volume/), a mended fault too. What was built before is then built anew, and goes as longest unused.
 */
inline constexpr std::uint32_t kBuilderVersion = 5;

/**
 * How the OpenVDB file beside a cached volume is named, instead of .hvol. The number is the version of what is written
 * into it: raise it with every change of grids, metadata or checksum (builder/vdb), and files of before are made anew.
 */
inline constexpr const char* kCachedVdbEnding = ".v3.vdb";

/**
 * Snapshot, volume and notes follow, each note ended by a newline. The first two carry checksums of their own, which
 * leave out their headers. A snapshot's header says nothing that the rest does not; a volume's does.
 */
struct CachedBuildHead {
  static constexpr std::uint64_t kMagic = UINT64_C(0x3245484341434448);  ///< "HDCACHE2"
  static constexpr std::uint64_t kMostPart = UINT64_C(1) << 34;
  static constexpr std::uint64_t kMostNotes = 1 << 16;

  std::uint64_t magic = kMagic;
  std::uint32_t snapshot_version = HD_SNAPSHOT_VERSION;
  std::uint32_t volume_version = HD_VOLUME_VERSION;
  std::uint64_t snapshot_bytes = 0, volume_bytes = 0, notes_bytes = 0;
  std::uint64_t volume_header = 0;  ///< snapshotChecksum() of the volume's header.

  /** Whether it is of this version and speaks of a file of that size. */
  [[nodiscard]] constexpr bool fits(std::uint64_t file_bytes) const {
    return magic == kMagic && snapshot_version == HD_SNAPSHOT_VERSION && volume_version == HD_VOLUME_VERSION &&
           snapshot_bytes > 0 && snapshot_bytes <= kMostPart && volume_bytes > 0 && volume_bytes <= kMostPart &&
           notes_bytes <= kMostNotes &&
           sizeof(CachedBuildHead) + snapshot_bytes + volume_bytes + notes_bytes == file_bytes;
  }
};

}  // namespace hapticd
