/** @file
 * Everything a simulated device is made of, and the one table that sets it from a URI.
 */
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "drivers/parameters.h"
#include "drivers/pose_file.h"
#include "drivers/registry.h"
#include "drivers/sim/motion.h"

namespace hapticd {

/** A simulated device and the hand on it. Units and meaning of each member: see simParameterTable(). */
struct SimParameters : MotionParameters {
  // Device, translation.
  double rate = 4000;
  double mass = 0.2;
  double viscous = 0.5;
  double coulomb = 0.1;
  double resolution = 1e-5;
  double max_force = 12;
  double continuous_force = 0;
  double force_resolution = 0;
  std::uint64_t delay = 1;
  std::uint64_t position_delay = 0;
  Vec3 lower = Vec3::Constant(-0.08), upper = Vec3::Constant(0.08);
  double stop_stiffness = 5000;
  double stop_damping = 20;
  double max_stiffness = 0;
  double max_damping = 0;
  // Device, rotation.
  std::uint64_t dof = 3;
  bool sense_rotation = false;
  double inertia = 2e-4;
  double angular_viscous = 2e-4;
  double angular_coulomb = 0;
  double rotation_resolution = 1e-4;
  double max_torque = 0.2;
  double torque_resolution = 0;
  // Gripper.
  bool gripper = false;
  double gripper_mass = 0.05;
  double gripper_lever = 0.05;
  double gripper_max_angle = 0.5;
  double gripper_resolution = 1e-4;
  double max_gripper_force = 8;
  std::uint64_t buttons = 0;
  // Hand.
  double hand_stiffness = 400;
  double hand_damping = 6;
  double hand_mass = 0.15;
  double hand_angular_stiffness = 2;
  double hand_angular_damping = 0.02;
  double hand_inertia = 2e-4;
  double hand_pinch_stiffness = 500;
  double hand_pinch_damping = 5;
  // Intended motion, by name and file.
  std::string motion = "live";
  std::string file;
  std::string serial;
};

/** Every key of a sim:// URI, in the order of the documentation. */
[[nodiscard]] const std::vector<Parameter<SimParameters>>& simParameterTable();

/** A device class with its published limits. */
struct SimPreset {
  std::string_view name;
  std::string_view model, manufacturer;
  std::string_view source;  ///< Where the figures come from.
  SimParameters parameters;
};
[[nodiscard]] const std::vector<SimPreset>& simPresets();

/** A URI resolved: preset, then query. */
struct SimSetup {
  const SimPreset* preset = nullptr;
  SimParameters parameters;
  std::string uri;  ///< Canonical.
  PoseFile file;    ///< Of a recorded motion.
  DeviceInfo info;
};
/** Errors as makeDevice. */
[[nodiscard]] Result<SimSetup> resolveSim(const DeviceUri& uri);

}  // namespace hapticd
