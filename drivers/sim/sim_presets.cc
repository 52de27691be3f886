/** @file
 * Device classes by their published limits. Each figure here is published; what is not published stays at the value of
 * `default`, and docs/devices.md says which. Workspaces are the boxes around what the data sheet gives, in the
 * canonical frame: depth along x, width along y, height along z. Stiffness and damping limits are those with which
 * CHAI3D 3.2.0 describes the device to its programs (src/devices/CDeltaDevices.cpp, CPhantomDevices.cpp).
 */
#include "drivers/sim/sim_parameters.h"

namespace hapticd {
namespace {

constexpr double kDegree = EIGEN_PI / 180;

void setBox(SimParameters& p, double depth, double width, double height) {
  p.upper = Vec3(depth, width, height) / 2;
  p.lower = -p.upper;
}

/** Product sheet of Novint: 4 in cube, more than 400 dpi, more than 2 lbf; 1 kHz over USB. */
SimParameters novintFalcon() {
  SimParameters p;
  p.rate = 1000;
  setBox(p, 0.1016, 0.1016, 0.1016);
  p.resolution = 0.0254 / 400;
  p.max_force = 8.9;
  p.max_stiffness = 3000;
  p.max_damping = 20;
  p.buttons = 4;
  return p;
}

/** Data sheet omega.3: diameter 160 mm by length 110 mm, 12 N, 0.01 mm, up to 4 kHz. */
SimParameters omega3() {
  SimParameters p;
  setBox(p, 0.110, 0.160, 0.160);
  p.resolution = 1e-5;
  p.max_force = p.continuous_force = 12;
  p.max_stiffness = 5000;
  p.max_damping = 30;
  p.buttons = 1;
  return p;
}

/** Data sheet omega.6: the omega.3 with a passive wrist sensed to 0.09 deg. */
SimParameters omega6() {
  SimParameters p = omega3();
  p.sense_rotation = true;
  p.rotation_resolution = 0.09 * kDegree;
  return p;
}

/** Data sheet omega.7: the omega.6 with a gripper of 8 N. */
SimParameters omega7() {
  SimParameters p = omega6();
  p.gripper = true;
  p.max_gripper_force = 8;
  p.gripper_max_angle = 30 * kDegree;
  return p;
}

/** Data sheet delta.3: diameter 400 mm by length 260 mm, 20 N. */
SimParameters delta3() {
  SimParameters p;
  setBox(p, 0.260, 0.400, 0.400);
  p.max_force = p.continuous_force = 20;
  p.max_stiffness = 5000;
  p.max_damping = 30;
  p.buttons = 1;
  return p;
}

/** Data sheet sigma.7: diameter 190 mm by length 130 mm, 20 N, 0.0015 mm; 0.4 N m, 0.013 deg; gripper 8 N. */
SimParameters sigma7() {
  SimParameters p;
  setBox(p, 0.130, 0.190, 0.190);
  p.resolution = 1.5e-6;
  p.max_force = p.continuous_force = 20;
  p.max_stiffness = 4000;
  p.max_damping = 30;
  p.dof = 6;
  p.rotation_resolution = 0.013 * kDegree;
  p.max_torque = 0.4;
  p.gripper = true;
  p.max_gripper_force = 8;
  p.gripper_max_angle = 30 * kDegree;
  return p;
}

/** Data sheet Touch (PHANTOM Omni): 160 x 120 x 70 mm, 450 dpi, 3.3 N, 0.88 N continuous, 0.26 N friction, 45 g. */
SimParameters touch() {
  SimParameters p;
  p.rate = 1000;
  setBox(p, 0.070, 0.160, 0.120);
  p.resolution = 5.5e-5;
  p.max_force = 3.3;
  p.continuous_force = 0.88;
  p.coulomb = 0.26;
  p.mass = 0.045;
  p.max_stiffness = 400;
  p.max_damping = 4;
  p.sense_rotation = true;
  p.buttons = 2;
  return p;
}

/** Data sheet Touch X (PHANTOM Desktop): 160 x 120 x 120 mm, 1100 dpi, 7.9 N, 1.75 N continuous, 0.06 N, 45 g. */
SimParameters touchX() {
  SimParameters p = touch();
  setBox(p, 0.120, 0.160, 0.120);
  p.resolution = 2.3e-5;
  p.max_force = 7.9;
  p.continuous_force = 1.75;
  p.coulomb = 0.06;
  p.max_stiffness = 1000;
  p.max_damping = 5;
  return p;
}

/** Data sheet PHANTOM Premium 1.5: 381 x 267 x 191 mm, 860 dpi, 8.5 N, 1.4 N continuous, 0.04 N, 75 g. */
SimParameters phantomPremium() {
  SimParameters p;
  p.rate = 1000;
  setBox(p, 0.191, 0.381, 0.267);
  p.resolution = 3e-5;
  p.max_force = 8.5;
  p.continuous_force = 1.4;
  p.coulomb = 0.04;
  p.mass = 0.075;
  p.max_stiffness = 800;
  p.max_damping = 5;
  p.buttons = 1;
  return p;
}

/** The Premium 1.5 with the active wrist, by the limits CHAI3D gives it. */
SimParameters phantomPremium6() {
  SimParameters p = phantomPremium();
  p.dof = 6;
  p.max_torque = 0.188;
  return p;
}

}  // namespace

const std::vector<SimPreset>& simPresets() {
  static const std::vector<SimPreset> kPresets = {
      {"default", "desktop", "hapticd", "ours: a good desktop device", SimParameters{}},
      {"falcon", "Falcon", "Novint", "Novint product sheet", novintFalcon()},
      {"omega3", "omega.3", "Force Dimension", "omega.3 data sheet", omega3()},
      {"omega6", "omega.6", "Force Dimension", "omega.6 data sheet", omega6()},
      {"omega7", "omega.7", "Force Dimension", "omega.7 data sheet", omega7()},
      {"delta3", "delta.3", "Force Dimension", "delta.3 data sheet", delta3()},
      {"sigma7", "sigma.7", "Force Dimension", "sigma.7 data sheet", sigma7()},
      {"touch", "Touch", "3D Systems", "PHANTOM Omni and Touch data sheets", touch()},
      {"touchx", "Touch X", "3D Systems", "PHANTOM Desktop and Touch X data sheets", touchX()},
      {"phantom_premium", "PHANTOM Premium 1.5", "SensAble", "PHANTOM Premium data sheet", phantomPremium()},
      {"phantom_premium6", "PHANTOM Premium 1.5 6DOF", "SensAble", "PHANTOM Premium data sheet, CHAI3D",
       phantomPremium6()},
  };
  return kPresets;
}

}  // namespace hapticd
