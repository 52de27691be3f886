/** @file
 * All that haptic-bench cost measures of one mesh, round by round.
 */
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "daemon/ipc/snapshot_memory.h"
#include "tools/haptic-bench/bench.h"
#include "tools/haptic-bench/cost/render_stage.h"
#include "tools/haptic-bench/cost/stroke.h"
#include "tools/haptic-bench/cost/tick_times.h"

namespace haptic_bench {

struct CostOptions {
  double seconds = 10;
  double speed = 0.1;  ///< [m/s]
  std::string profile;
  std::vector<std::uint32_t> triangles = {1'000, 16'000, 100'000, 1'000'000};
  std::vector<double> radii_mm = {0, 1};
};

/** A bumpy sphere that is stroked. */
class MeshCost {
 public:
  /** Throws Failure, as all of these. */
  MeshCost(std::uint32_t triangles, const CostOptions& options);

  /**
   * Builds it, chases pointers through as many bytes, and does the stroke with each stage and query. Anew from building
   * on: where in memory a mesh comes to lie would else be the same in all rounds of one run, and other in the next.
   */
  void round();
  /** The stroke of a ball once more, counted; after the first round. */
  [[nodiscard]] Looked count(double radius_mm);

  [[nodiscard]] std::uint32_t triangles() const { return triangles_; }
  [[nodiscard]] std::size_t bytes() const { return bytes_; }
  [[nodiscard]] std::uint32_t depth() const { return depth_; }
  [[nodiscard]] const Series& builds() const { return builds_; }  ///< Processor time of each round [ms].
  [[nodiscard]] const Series& chases() const { return chases_; }  ///< A load of each round [ns].
  /** Ticks of the renderer for each radius, of the servo for each, sweeps for each, nearest points. */
  [[nodiscard]] const std::vector<TickTimes>& times() const { return times_; }

 private:
  void build();

  CostOptions options_;
  std::vector<std::byte> upload_;
  std::uint32_t triangles_ = 0, depth_ = 0;
  std::size_t bytes_ = 0;
  Series builds_{"build", "ms", {}}, chases_{kMachineLatency, "ns", {}};
  std::vector<TickTimes> times_;
  std::unique_ptr<hapticd::SnapshotMemory> memory_;
  std::unique_ptr<MeshStroke> stroke_;
};

}  // namespace haptic_bench
