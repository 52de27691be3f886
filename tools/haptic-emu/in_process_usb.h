/** @file
 * A played device before a driver in the same process. With a clock moved by hand nothing depends on the machine and
 * runs repeat to the bit; with a real one it keeps pace.
 */
#pragma once

#include "drivers/usb/transport.h"
#include "rt/base/clock.h"
#include "tools/haptic-emu/usb_model.h"

namespace haptic_emu {

/**
 * Opens `model` as a driver would open the device; kDeviceGone while it is unplugged, kDeviceBusy while it is open. The
 * transport's poll() waits on `clock`, and moves the model, until a transfer ends. Both outlive it. On a clock that
 * does not begin at zero the model is to be told so before, by startAt().
 */
[[nodiscard]] hapticd::UsbOpener openInProcess(UsbModel& model, hapticd::Clock& clock);

}  // namespace haptic_emu
