/** @file
 * A played HID device before a driver in the same process, in virtual time: nothing depends on the machine, runs repeat
 * to the bit.
 */
#pragma once

#include "drivers/hid/transport.h"
#include "rt/base/clock.h"
#include "tools/haptic-emu/hid_model.h"

namespace haptic_emu {

/**
 * Opens `model` as a driver would open the node; kNotFound while it is unplugged. Waiting in read() moves `clock`, and
 * with it the model, until a report comes. Both outlive it. As in the kernel, the oldest of more than 64 waiting
 * reports is lost.
 */
class InProcessHid final : public hapticd::HidTransport {
 public:
  InProcessHid(HidModel& model, hapticd::Clock& clock) : model_(model), clock_(clock) {}

  [[nodiscard]] hapticd::Result<void> open() override;
  void close() noexcept override { open_ = false; }
  [[nodiscard]] const std::vector<std::uint8_t>& descriptor() const noexcept override { return model_.descriptor(); }
  [[nodiscard]] hapticd::HidPlugged plugged() const override { return {"played", std::to_string(model_.pluggings())}; }
  [[nodiscard]] std::int64_t now() const noexcept override { return clock_.now(); }
  [[nodiscard]] hapticd::HidResult read(std::span<std::uint8_t> buffer, std::size_t& size,
                                        std::int64_t until_ns) noexcept override;
  [[nodiscard]] hapticd::HidResult write(std::span<const std::uint8_t> report) noexcept override;
  [[nodiscard]] hapticd::HidResult setFeature(std::span<const std::uint8_t> report) noexcept override;
  [[nodiscard]] hapticd::HidResult getFeature(std::span<std::uint8_t> buffer, std::size_t& size) noexcept override;
  void lastWords(std::span<const std::uint8_t> report) noexcept override { (void)write(report); }

 private:
  [[nodiscard]] bool there() noexcept;

  HidModel& model_;
  hapticd::Clock& clock_;
  bool open_ = false;
};

}  // namespace haptic_emu
