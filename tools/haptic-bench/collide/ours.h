/** @file
 * Our detectors on a pair of solids: volumes from the models, a detector, its times and its wrench against the truth.
 */
#pragma once

#include <string>
#include <vector>

#include "daemon/builder/volume/mesh_volume.h"
#include "rt/contact/detector.h"
#include "rt/volume/volume_view.h"
#include "tools/haptic-bench/collide/pair.h"
#include "tools/haptic-bench/collide/timing.h"
#include "tools/haptic-bench/collide/truth.h"

namespace haptic_bench {

/** A model as a volume. Throws Failure when the builder refuses it. */
struct BuiltVolume {
  BuiltVolume(const Model& model, double voxel, double point_spacing, std::uint32_t patch_points);
  hapticd::VolumeImage image;
  hapticd::VolumeView view;
  double build_ms = 0;  ///< Of processor time, of all threads.
  [[nodiscard]] double megabytes() const { return static_cast<double>(hapticd::bytesOf(image).size()) * 1e-6; }
};

/** A detector with its volumes. */
struct Subject {
  std::string name;
  const BuiltVolume* base = nullptr;
  const BuiltVolume* tool = nullptr;
  hapticd::Detector* detector = nullptr;
  bool first_only = false;
  std::uint32_t units = 0;  ///< Work that each query may do; 0: all it needs.
};

/** Some poses of a motion with their truth, found by as many threads as there are processors. */
struct TruthTable {
  std::vector<std::size_t> pose;
  std::vector<Penalty> penalty;
  double peak = 0;  ///< Of |F| [m^3].
};
[[nodiscard]] TruthTable makeTruth(const CollidePair& pair, const std::vector<hapticd::Pose>& poses, int count,
                                   int split);

/** What was measured of one subject. */
struct Measures {
  Times times;
  double touching = 0;      ///< Points or pairs, mean of the poses that touch.
  double rate = 0;          ///< Touching a millisecond.
  double work = 0;          ///< Units, mean of the poses that touch.
  std::size_t hits = 0;     ///< Poses that touch.
  double error_force = 0;   ///< Greatest of the truth's poses, as parts of the peak.
  double error_angle = 0;   ///< [rad], where the force is more than a twentieth of the peak.
  double error_torque = 0;  ///< Over `kLever`.
};
inline constexpr double kLever = 0.03;  ///< [m]

[[nodiscard]] Measures measure(const Subject& subject, const std::vector<hapticd::Pose>& poses, std::size_t from,
                               const TimingOptions& timing, const TruthTable& truth);

}  // namespace haptic_bench
