/** @file
 * The servo's whole tick on a mesh: read the device, advance the scene, render, guard, write, publish.
 */
#pragma once

#include <cstddef>
#include <memory>

#include "rt/cycle/servo.h"
#include "tools/haptic-bench/cost/stroke.h"

namespace haptic_bench {

/** A servo with one mesh and one device whose hand follows the stroke; its ticks come without the waiting between. */
class ServoStage {
 public:
  ServoStage(hapticd::MeshView& mesh, const MeshStroke& stroke);
  ~ServoStage();

  /** A new servo, armed, its ball above the start of the stroke. Throws Failure. */
  void begin(double radius);
  void tick(std::size_t i);
  /** Whether since begin() the device has been given a force in every tick. */
  [[nodiscard]] bool touched() const { return touched_; }

 private:
  class Hand;
  class NoWait;

  const MeshStroke& stroke_;
  hapticd::MeshTable meshes_;
  std::unique_ptr<NoWait> clock_;
  std::unique_ptr<Hand> hand_;
  std::unique_ptr<hapticd::Servo> servo_;
  double radius_ = 0;
  bool touched_ = true;
};

}  // namespace haptic_bench
