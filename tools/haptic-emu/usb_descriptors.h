/** @file
 * What a device answers to the standard requests of the USB specification (2.0, chapter 9).
 */
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "tools/haptic-emu/usb_model.h"

namespace haptic_emu {

/** The eight bytes that begin a control transfer. */
struct UsbSetup {
  std::uint8_t request_type = 0, request = 0;
  std::uint16_t value = 0, index = 0, length = 0;
};

/** The data of a standard request, cut to its length, possibly none; nothing at all: not a standard request, or
 * stalled. */
[[nodiscard]] std::optional<std::vector<std::uint8_t>> answerStandard(const UsbIdentity& who, const UsbSetup& setup);

}  // namespace haptic_emu
