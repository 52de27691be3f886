/** @file
 * Two fingers of a simulated hand, each on a device of its own, hold a block: the cycle stepped by hand, with its guard
 * as the daemon sets it. What a hand wants is a place; what it gets, and the force, are for the devices and the block
 * to say. Deterministic.
 */
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <random>

#include "drivers/sim/sim_device.h"
#include "rt/cycle/cycle.h"

namespace haptic_bench::grasp {

using hapticd::Vec3;

inline constexpr double kPeriod_s = 1e-3;
inline constexpr double kReaction_s = 0.2;  ///< From what is seen to what the fingers do.
inline constexpr double kGravity = 9.81;    ///< [m/s^2]

struct Block {
  Vec3 half = Vec3::Constant(0.03);  ///< Of its edges [m]; the fingers press on the faces at x = + and - half.x.
  double lever = 0;                  ///< Of its centre of mass from the line between the fingers, along y [m].
  double mass = 0.2;                 ///< [kg]
  hd_material material{1000, 1, 0.8, 0.6};

  /** How hard each finger must press a block that cannot turn [N]. */
  [[nodiscard]] double slips() const { return mass * kGravity / (2 * material.friction_static); }
};

/** Of whoever grasps. */
struct Hand {
  double stiffness = 1000;  ///< With which a finger goes where it wants [N/m].
  double unsteady = 2e-4;   ///< How far it is from there, root mean square, half of it drift and half tremor [m].
  std::uint64_t seed = 1;
};

/** A finger's own unrest: drift below 1.1 Hz, tremor of 8 to 12 Hz (Elble and Koller, Tremor, 1990). */
class Unrest {
 public:
  Unrest(double rms, std::mt19937_64& random);
  [[nodiscard]] double at(double t_s) const;

 private:
  static constexpr int kTones = 3;  ///< Of each.
  double amplitude_;
  std::array<double, 2L * kTones> rate_hz_, phase_;
};

class Rig {
 public:
  /** The fingers are soft ones by `finger` (its device is not read), or points. */
  Rig(const Block& block, const Hand& hand, const hapticd::SetFinger& finger = {});

  /** Presses with about so much, then takes the ground away, and waits until the block hangs still. */
  void grasp(double force);
  /** How deep in the block each finger wants to be, beyond its face [m]. */
  void want(double depth) { depth_ = depth; }
  [[nodiscard]] double wanted() const { return depth_; }
  /** The depth at which it presses with about so much. */
  [[nodiscard]] double depthFor(double force) const;
  void tick();

  [[nodiscard]] double time() const { return static_cast<double>(input_->now_ns) * 1e-9; }  ///< [s]
  [[nodiscard]] double grip() const;  ///< Force along the normal, mean of both fingers [N].
  /** How far the block has slid across the fingertips since it was grasped [m]. */
  [[nodiscard]] double slid() const { return (middle() - start_).norm(); }
  [[nodiscard]] double turned() const;  ///< About the line between the fingers, from -pi to pi [rad].
  [[nodiscard]] bool slips() const;     ///< Friction bears it no longer: it slides or turns on a finger.
  [[nodiscard]] bool held() const;      ///< By both.
  [[nodiscard]] hapticd::Pose place() const;

 private:
  template <class T>
  void send(hapticd::CommandKind kind, const T& payload) {
    input_->command[input_->command_count++] = makeCommand(kind, payload);
  }
  [[nodiscard]] Vec3 middle() const;  ///< Of both places of contact, in the block's frame.

  Block block_;
  Hand hand_;
  std::array<hapticd::SimDevice, 2> device_;
  std::mt19937_64 random_;
  std::array<Unrest, 2> unrest_;
  double depth_ = 0;
  Vec3 start_ = Vec3::Zero();  ///< middle() when it was grasped.
  std::unique_ptr<hapticd::MeshTable> meshes_;
  std::unique_ptr<hapticd::Cycle> cycle_;
  std::unique_ptr<hapticd::CycleInput> input_;
  std::unique_ptr<hapticd::CycleOutput> output_;
};

}  // namespace haptic_bench::grasp
