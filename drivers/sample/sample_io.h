/** @file
 * A driver to copy: a device with a thread of its own over USB. docs/writing-a-driver.md goes through it.
 *
 * It is complete (the conformance suite runs it against haptic-emu's sample device) but stands in no registry, for
 * nobody can buy the device.
 */
#pragma once

#include <atomic>
#include <memory>

#include "drivers/link/device_io.h"
#include "drivers/link/lent.h"
#include "drivers/sample/sample_protocol.h"
#include "drivers/usb/transport.h"
#include "rt/base/clock.h"

namespace hapticd {

/** What it is and can do. */
[[nodiscard]] DeviceInfo sampleInfo();

/**
 * The device tells its reading once a millisecond, and takes an order for each. Its own watchdog takes the force back
 * after 100 ms without one. Silence for kSilent_ns counts as gone.
 */
class SampleIo final : public DeviceIo, private UsbListener {
 public:
  static constexpr std::int64_t kSilent_ns = 500'000'000;
  static constexpr std::int64_t kTrust_ns = 10'000'000;  ///< A reading older than this carries no force.

  SampleIo(UsbOpener open_usb, Clock& clock) : open_usb_(std::move(open_usb)), clock_(clock), info_(sampleInfo()) {}
  ~SampleIo() override { close(); }

  [[nodiscard]] const DeviceInfo& info() const noexcept override { return info_; }
  [[nodiscard]] Result<void> open(const std::atomic<bool>& stop) override;
  void close() noexcept override;
  [[nodiscard]] bool exchange(DeviceLink& link, std::int64_t until_ns) noexcept override;
  void safe() noexcept override;

 private:
  void onIn(UsbStatus status, std::span<const std::uint8_t> bytes) noexcept override;
  void onOut(UsbStatus status) noexcept override;
  [[nodiscard]] sample::Order orderFor(const DeviceCommand& command) noexcept;

  UsbOpener open_usb_;
  Clock& clock_;
  DeviceInfo info_;
  std::unique_ptr<UsbTransport> usb_;
  Lent<UsbTransport*, nullptr> live_;  ///< For safe().
  DeviceLink* link_ = nullptr;         ///< While exchange() runs.
  bool gone_ = false;
  bool answered_ = false;  ///< A good reading came since the last order.
  bool saturated_ = false;
  std::size_t under_way_ = 0;  ///< Orders whose transfer has not ended.
  bool not_taken_ = false;     ///< One has failed since the last was sent.
  int unasked_ = 0;  ///< Requests that failed, to go out with the next order: at once they could fail without end.
  std::uint8_t number_ = 0;
  std::int64_t sent_ns_ = 0, heard_ns_ = 0;
};

}  // namespace hapticd
