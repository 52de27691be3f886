/** @file
 * The device's side of USB/IP (Linux, Documentation/usb/usbip_protocol.rst) for one played device: bytes in, bytes out.
 * vhci.h connects it with the kernel.
 */
#pragma once

#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include "tools/haptic-emu/usb_descriptors.h"
#include "tools/haptic-emu/usb_model.h"

namespace haptic_emu {

/** Takes the kernel's commands for `model`, which outlives it. Fuzzed. */
class UsbIp {
 public:
  explicit UsbIp(UsbModel& model) : model_(model) {}

  /** Bytes from the kernel, in pieces of any size. False: not USB/IP; close the connection. */
  [[nodiscard]] bool feed(std::span<const std::uint8_t> bytes);
  /** The world goes on to t_ns: what the device has to say is matched with what was asked. */
  void advance(std::int64_t t_ns);
  /** Bytes for the kernel since the last call. */
  [[nodiscard]] std::vector<std::uint8_t> take();
  [[nodiscard]] std::size_t waiting() const { return asked_.size(); }

 private:
  static constexpr std::size_t kHeader = 48;
  static constexpr std::uint32_t kMostBytes = 64 * 1024;
  static constexpr std::size_t kMostAsked = 256;
  struct Asked {
    std::uint32_t sequence, length;
  };

  /** Length of the message at the front; 0: not whole yet. */
  [[nodiscard]] bool whole(std::size_t& length) const;
  bool submit(std::span<const std::uint8_t> message);
  void unlink(std::span<const std::uint8_t> message);
  void control(std::uint32_t sequence, const UsbSetup& setup, bool in, std::uint32_t length);
  void reply(std::uint32_t sequence, std::int32_t status, std::span<const std::uint8_t> data, std::uint32_t actual);
  void match();

  UsbModel& model_;
  std::vector<std::uint8_t> in_, out_;
  std::deque<Asked> asked_;  ///< IN transfers that wait for the device.
};

}  // namespace haptic_emu
