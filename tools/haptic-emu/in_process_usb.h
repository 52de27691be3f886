/** @file
 * A played device before a driver in the same process, in virtual time: nothing depends on the machine, runs repeat to
 * the bit.
 */
#pragma once

#include "drivers/usb/transport.h"
#include "rt/base/clock.h"
#include "tools/haptic-emu/usb_model.h"

namespace haptic_emu {

/**
 * Opens `model` as a driver would open the device; kDeviceGone while it is unplugged, kDeviceBusy while it is open. The
 * transport's poll() moves `clock`, and with it the model, until a transfer ends. Both outlive it.
 */
[[nodiscard]] hapticd::UsbOpener openInProcess(UsbModel& model, hapticd::ManualClock& clock);

}  // namespace haptic_emu
