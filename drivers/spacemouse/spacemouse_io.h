/** @file
 * A SpaceMouse at work: listens, and shows its light while it is open.
 */
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>

#include "drivers/link/device_io.h"
#include "drivers/spacemouse/cap_pose.h"
#include "drivers/spacemouse/spacemouse_protocol.h"

namespace hapticd {

/**
 * A cap that is let go says so three times and then is silent: silence means "as before", so a sample is published
 * every kSample_ns all the same. As the dead-man switch of its group it is open until its button is down, and when it
 * is gone.
 */
class SpaceMouseIo final : public DeviceIo {
 public:
  static constexpr std::int64_t kSample_ns = 4'000'000;

  explicit SpaceMouseIo(SpaceMouseSetup setup)
      : setup_(std::move(setup)), hid_(setup_.hid()), pose_(setup_.parameters) {}
  ~SpaceMouseIo() override { close(); }
  SpaceMouseIo(const SpaceMouseIo&) = delete;
  SpaceMouseIo& operator=(const SpaceMouseIo&) = delete;

  [[nodiscard]] const DeviceInfo& info() const noexcept override { return setup_.info; }
  [[nodiscard]] Result<void> open(const std::atomic<bool>& stop) override;
  void close() noexcept override;
  [[nodiscard]] bool exchange(DeviceLink& link, std::int64_t until_ns) noexcept override;
  [[nodiscard]] std::uint32_t statusWhenGone() const noexcept override {
    return kDeviceGone | (setup_.parameters.deadman != 0 ? kGroupDeadmanOpen : 0u);
  }
  void safe() noexcept override {}

  /** As last told; -1 where the device never did. Any thread. */
  [[nodiscard]] int batteryPercent() const noexcept override { return battery_.load(std::memory_order_relaxed); }

 private:
  void publish(std::int64_t now_ns, DeviceLink& link) noexcept;

  SpaceMouseSetup setup_;
  std::unique_ptr<HidTransport> hid_;
  CapPose pose_;
  spacemouse::State state_;
  std::atomic<int> battery_{-1};
  std::int64_t published_ns_ = 0;
};

}  // namespace hapticd
