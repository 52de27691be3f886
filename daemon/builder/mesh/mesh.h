/** @file
 * A mesh while it is checked, repaired and built.
 */
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "proto/snapshot.h"
#include "proto/volume.h"
#include "rt/base/error.h"

namespace hapticd {

using Float3 = std::array<float, 3>;
using Index3 = std::array<std::uint32_t, 3>;

/** An upload as it stands in shared memory, its header checked. */
struct MeshSource {
  std::span<const Float3> vertices;
  std::span<const Index3> triangles;
  float weld_m = 0;
  bool deformable = false;
  bool as_volume = false;  ///< `request` says how.
  bool fill_holes = false;
  hd_volume_request request{};
};

/** The working copy: welded, cleaned, oriented. */
struct Mesh {
  std::vector<Float3> vertices;
  std::vector<Index3> triangles;
  std::vector<Index3> neighbours;              ///< Across edges 01, 12, 20; HD_NO_INDEX where there is none.
  std::vector<std::uint32_t> source_triangle;  ///< Number of each triangle in the upload: for messages.
  std::vector<std::uint32_t> source_vertex;    ///< Vertex here for each vertex of the upload.
  bool deformable = false;
  bool closed = false;
};

/**
 * Triangles about one another stand far apart in memory. Loops that go from one to the next ask for what they need of
 * the one so many steps ahead: the time from memory is some hundred nanoseconds, that of a step a few.
 */
inline constexpr std::uint32_t kFetchAhead = 16;

/** What a build tells while it runs. */
struct BuildMonitor {
  /** Called often with 0 to 1 and the stage; false asks the build to stop. */
  std::function<bool(float fraction, const char* stage)> progress = [](float, const char*) { return true; };
  /** Repairs, in words; each names a triangle or vertex of the upload. */
  std::vector<std::string> notes;
};

/** What a build ends with that `progress` has asked to stop. */
[[nodiscard]] inline Error cancelled() { return {ErrorCode::kCancelled, "build", {}, {}}; }

/** Header, sizes and flags. kBadMesh. */
[[nodiscard]] Result<MeshSource> readUpload(std::span<const std::byte> upload);

/** Every number: coordinates finite and within HD_MAX_COORDINATE, indices in range. kBadMesh names the first culprit.
 */
[[nodiscard]] Result<void> checkNumbers(const MeshSource& source);

/**
 * Vertices of equal coordinates become one (zeros of both signs are equal); with a welding distance each vertex becomes
 * the nearest kept one within it, else is kept itself. Triangles that are left without area are dropped.
 */
[[nodiscard]] Mesh weld(const MeshSource& source, BuildMonitor& monitor);

/** Of triangles over the same three vertices the first stays. */
void dropDuplicates(Mesh& mesh, BuildMonitor& monitor);

/** Fills neighbours; edges of more than two triangles get none and a note. */
void connect(Mesh& mesh, BuildMonitor& monitor);

inline constexpr std::int64_t kStitchWork = 200'000'000;  ///< A few seconds.

/**
 * Closes cracks: ends of open edges that floats cannot tell apart become one, and a triangle whose open edge has
 * vertices of other open edges on it, within the rounding of six digits or the welding distance, is cut there. After
 * connect(); connects again what it changes. With its `work` used up, in steps of the search, it leaves the rest, and a
 * note.
 */
void stitch(Mesh& mesh, double weld_m, BuildMonitor& monitor, std::int64_t work = kStitchWork);

/**
 * One winding for each connected part (the majority's); outward for closed parts, but for cavities, which look inward.
 * Sets mesh.closed.
 */
void orient(Mesh& mesh, BuildMonitor& monitor);

/** Of an open mesh: tells how many holes it has, how wide, and where. After orient(). */
void noteHoles(const Mesh& mesh, BuildMonitor& monitor);

}  // namespace hapticd
