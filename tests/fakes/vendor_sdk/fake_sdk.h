/** @file
 * A vendor's SDK played: libdhd and libHD in one library, with a device whose grip tests hold. Its own declarations
 * throughout: it never sees the driver's.
 *
 * What it plays lies in one plain struct: in the file that FAKE_SDK_STATE names when it is loaded (so that a test sees
 * what another process's library does), else in its own memory.
 */
#pragma once

#include <atomic>
#include <cstdint>

namespace fake_sdk {

/** Everything of the device and its faults; scripts know the three that come first. Places in the SDK's own axes and
 * units: m and dhd's, mm and HD's. */
struct State {
  std::atomic<double> place[3];  ///< Of the grip.
  std::atomic<double> force[3];  ///< What the motors push with [N]; zero unless forces are on.
  std::atomic<int> network;      ///< Whether the process that opened it last may have a socket of the network: 1, -1.
  std::atomic<double> torque[3], gripper_force;
  std::atomic<double> rotation[9];  ///< Row by row.
  std::atomic<double> gripper_rad;
  std::atomic<unsigned> buttons;
  std::atomic<int> system_type, version_major;
  std::atomic<bool> calibrated, force_on;
  std::atomic<int> hd_styles;  ///< Ways in which HD can calibrate it: 1 by a reset, 2 by itself, 4 in its inkwell, or
                               ///< several; 0: as 4.
  // Faults.
  std::atomic<bool> unplugged, silent, garbled, failing, jumping, forces_refused, saturating;
  std::atomic<bool> deaf;                ///< It takes no force any more, and keeps the last; reading goes on.
  std::atomic<bool> stuck_on;            ///< Nor is it switched off.
  std::atomic<bool> hangs;               ///< Every call that reads the grip never comes back.
  std::atomic<bool> crashes;             ///< Opening it ends the process.
  std::atomic<unsigned> hd_error;        ///< Put on HD's stack of errors where the next frame begins.
  std::atomic<unsigned> hd_force_error;  ///< Where it ends: that is when the force is sent.
  // What was seen.
  std::atomic<int> opened, closed, force_calls, closed_pushing, frames_outside, gravity_on;
  std::atomic<int> hd_calibrated_by;  ///< Style that HD was told last; 0: none.
  std::atomic<int> owner;             ///< Process that has it open; the kernel takes it from one that is dead.
  std::atomic<std::uint64_t> calls;
};

/** Whether a process that lives has it open. */
bool held();
/** Takes or leaves it for this process. */
void hold(bool on);

}  // namespace fake_sdk

extern "C" {
/** Found by dlsym. */
fake_sdk::State* fake_sdk_state();
/** One tick of HD's scheduler by hand; the library's own thread ticks only if FAKE_SDK_THREAD is set. */
void fake_sdk_tick();
}
