/** @file
 * A joystick or wheel with force feedback by USB PID at work: one constant force for each axis, told anew a thousand
 * times a second.
 */
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>

#include "drivers/hidpid/hidpid_parameters.h"
#include "drivers/hidpid/pid_reports.h"
#include "drivers/link/device_io.h"
#include "drivers/link/lent.h"

namespace hapticd {

/**
 * No effect is without an end. Constant forces last kHold_ms and are started again at half of that, so they stop by
 * themselves when this process is killed. When only the servo is late, a damper and a spring about the present place
 * take over in the device: at most the share `fallback` of its force, for kFallback_ms.
 */
class HidPidIo final : public DeviceIo {
 public:
  static constexpr std::int64_t kPeriod_ns = 1'000'000;
  static constexpr std::int32_t kHold_ms = pid::kHold_ms, kFallback_ms = pid::kFallback_ms;
  static constexpr int kMostLoadTries = 60;  ///< As the kernel's driver asks.
  static constexpr int kOffTries = 3;
  static constexpr int kRefusalsInARow = 100;  ///< Reports that it does not take, until it counts as gone.
  /** One that refuses only after so long hangs, for the kernel waits five seconds: gone at once. */
  static constexpr std::int64_t kHang_ns = 1'000'000'000;

  explicit HidPidIo(HidPidSetup setup) : setup_(std::move(setup)), hid_(setup_.hid()) {}
  ~HidPidIo() override { close(); }
  HidPidIo(const HidPidIo&) = delete;
  HidPidIo& operator=(const HidPidIo&) = delete;

  [[nodiscard]] const DeviceInfo& info() const noexcept override { return setup_.info; }
  [[nodiscard]] Result<void> open(const std::atomic<bool>& stop) override;
  void close() noexcept override;
  [[nodiscard]] bool exchange(DeviceLink& link, std::int64_t until_ns) noexcept override;
  void safe() noexcept override;

  /** Whether the device keeps a damper or a spring for when the servo is late. */
  [[nodiscard]] bool hasFallback() const noexcept { return fallbacks_ != 0; }

 private:
  struct Axis {
    std::int32_t block = 0;  ///< Of its constant force.
    double position = 0;     ///< -1 to 1.
    double told = 0;         ///< Share of the force that the device has taken; NaN: it refused the last.
    bool started = false;
    std::int64_t started_ns = 0;
  };
  /** A damper or spring on one axis, waiting in the device. */
  struct Fallback {
    pid::Effect effect = pid::Effect::kDamper;
    std::size_t axis = 0;
    std::int32_t block = 0;
  };

  [[nodiscard]] Result<void> prepare(const std::atomic<bool>& stop);
  [[nodiscard]] Result<std::int32_t> create(pid::Effect effect, const std::atomic<bool>& stop);
  void listen(std::span<const std::uint8_t> report) noexcept;
  /** That it is gone, if it is. */
  [[nodiscard]] Result<void> there() const;
  /** False if it has not taken it; then nobody knows what it did. */
  bool say(const pid::Report& report) noexcept;
  void tell(Axis& axis, double share) noexcept;
  void drive(const DeviceCommand& command, std::int64_t now_ns) noexcept;
  [[nodiscard]] bool isQuiet() const noexcept;
  void rest(bool actuators_off) noexcept;
  void fallBack() noexcept;
  void endFallback() noexcept;
  void publish(std::int64_t now_ns, DeviceLink& link) noexcept;

  HidPidSetup setup_;
  std::unique_ptr<HidTransport> hid_;
  pid::Layout layout_;
  pid::Encoder encoder_;
  std::array<Axis, pid::kMostAxes> axes_;
  std::array<Fallback, 2 * pid::kMostAxes> fallback_;
  std::size_t fallbacks_ = 0;
  std::array<pid::Report, 2> last_words_;
  Lent<const std::array<pid::Report, 2>*, nullptr> speak_;  ///< `last_words_`, once it may be spoken to.
  std::int64_t next_ns_ = 0;
  std::uint32_t buttons_ = 0;
  int off_tries_ = 0;     ///< To tell it that they are off; not for ever, for some never take that.
  bool told_on_ = false;  ///< It has taken that its actuators are on.
  bool known_ = false, energised_ = false, fallen_ = false, saturated_ = false;
  bool safety_open_ = false, power_off_ = false, gone_ = false;
  int refusals_ = 0;
};

}  // namespace hapticd
