/** @file
 * The two sides of haptic-bench servo: a thread that only sleeps, and the daemon's whole real-time side. Same stack,
 * rights, processor and memory lock.
 */
#pragma once

#include <memory>
#include <string>

#include "daemon/device/device_group.h"
#include "tools/haptic-bench/load/wakes.h"

namespace haptic_bench {

/** One slice of a side. */
struct Slice {
  double rate_hz = 1000;
  double seconds = 1.5;
  std::uint32_t cpu = 0;  ///< Where all its threads run.
};

/** Why a side does not run as it should; empty when it does. */
using Note = std::string;

/** Sleeps to absolute deadlines and does nothing else: what cyclictest does. Throws Failure. */
[[nodiscard]] Wakes runBare(const Slice& slice, hapticd::Clock& clock, Note& note);

/** The daemon's real-time side with one simulated hand that strokes a mesh of 50 mm radius. */
class House {
 public:
  /** Armed, in contact and warm. Throws Failure. */
  House(const Slice& slice, hapticd::MeshView& mesh, hapticd::Clock& clock, Note& note);
  ~House();

  /** Lets the slice pass; gives the wake-ups in it. */
  [[nodiscard]] Wakes run();
  [[nodiscard]] hapticd::Servo& servo();

 private:
  class Watched;
  Slice slice_;
  Watched* watched_ = nullptr;
  hapticd::MeshTable meshes_;
  std::unique_ptr<hapticd::DeviceGroup> group_;
};

}  // namespace haptic_bench
