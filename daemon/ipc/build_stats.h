/** @file
 * What a build of a snapshot came to.
 */
#pragma once

#include <cstdint>

namespace hapticd {

/** Figures of a finished build. */
struct BuildStats {
  std::uint32_t vertices = 0;
  std::uint32_t triangles = 0;
  std::uint32_t nodes = 0;
  std::uint32_t depth = 0;
  std::uint32_t flags = 0;  ///< hd_snapshot_flag
  std::uint64_t bytes = 0;  ///< Of the snapshot.
  float lower[3] = {}, upper[3] = {};
  std::int64_t build_ns = 0;
  std::uint64_t peak_bytes = 0;  ///< Resident memory of the builder at its highest.
};

}  // namespace hapticd
