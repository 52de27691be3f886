/** @file
 * Trajectories from files of columns: CSV with a header, the .traj family with columns named on the command line.
 */
#pragma once

#include <string>

#include "tools/haptic-bench/model/model.h"
#include "tools/haptic-bench/trajectory/table.h"
#include "tools/haptic-bench/trajectory/trajectory.h"

namespace CLI {
class App;
}

namespace haptic_bench {

/** How a file is to be read. */
struct FileOptions {
  std::string columns;   ///< Names parted by commas, for a file without a header.
  bool out = false;      ///< Its positions are on the surface.
  double rate_hz = 0;    ///< Where it has no times.
  double max_gap_s = 0;  ///< 0: ten times the middle step.
  unsigned device = 0;   ///< Of a recording or its export.
};

/** --columns, --out, --rate, --max-gap and --device. */
void addFileOptions(CLI::App& sub, FileOptions& options);

/**
 * Columns t; x, y, z (or px, hip_x ...); of rows of several devices those of one; optionally proxy_x ..., fx ... as
 * truth; others are passed over. With options.out the position is on the surface and is pressed in for `surface`: the
 * force is fn, or that part of fx ... along the normal; the normal is nx ..., or that of the model at its nearest
 * point. Throws Failure with the line.
 */
[[nodiscard]] Trajectory readColumns(Table table, const FileOptions& options, const Model& model,
                                     const Surface& surface);

/** `x`, or where a ball of `radius` [m] there is inside of the model, as far outside: a place to come from. */
[[nodiscard]] Vec3 outside(const Vec3& x, const Model& model, double radius);

}  // namespace haptic_bench
