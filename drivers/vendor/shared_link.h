/** @file
 * A DeviceLink whose two ends are processes: newest sample up, newest order down, through memory that both map.
 *
 * Neither trusts the other with more than numbers: nothing in the memory is an index or a length, what a reader gets
 * is whole or not there, and each number is checked by whoever takes it.
 */
#pragma once

#include <atomic>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "drivers/link/device_link.h"

namespace hapticd {

/** What SharedBox::take() came to. */
enum class Taken : std::uint8_t { kSame, kNew, kBusy };

/**
 * The newest value of one writer for readers in other processes: wait-free for the writer, and for a reader, who after
 * kTries torn copies goes on with what it has. A writer that dies in the middle leaves it unreadable, which is silence.
 */
template <class T>
class SharedBox {
  static_assert(std::is_trivially_copyable_v<T> && sizeof(T) % 8 == 0);
  static constexpr std::size_t kWords = sizeof(T) / 8;

 public:
  static constexpr int kTries = 4;

  void put(const T& value) HD_RT {
    std::uint64_t words[kWords];
    std::memcpy(words, &value, sizeof value);
    const std::uint32_t version = version_.load(std::memory_order_relaxed) | 1;  // A dead writer may have left it odd.
    version_.store(version, std::memory_order_relaxed);
    // R1, pairs with A2: whoever sees a new word sees the odd version too.
    for (std::size_t i = 0; i < kWords; ++i) words_[i].store(words[i], std::memory_order_release);
    version_.store(version + 1, std::memory_order_release);  // R2, pairs with A1
  }
  /** kSame: there is nothing newer than `seen`; kBusy: there is, and no whole copy to be had. Both leave `out`. */
  [[nodiscard]] Taken take(T& out, std::uint32_t& seen) const HD_RT {
    for (int i = 0; i < kTries; ++i) {
      const std::uint32_t before = version_.load(std::memory_order_acquire);  // A1
      if (before == seen) return Taken::kSame;
      if ((before & 1) != 0) continue;
      std::uint64_t words[kWords];
      for (std::size_t k = 0; k < kWords; ++k) words[k] = words_[k].load(std::memory_order_acquire);  // A2
      if (version_.load(std::memory_order_relaxed) != before) continue;
      std::memcpy(&out, words, sizeof out);
      seen = before;
      return Taken::kNew;
    }
    return Taken::kBusy;
  }

 private:
  std::atomic<std::uint32_t> version_{0};
  std::uint32_t unused_ = 0;
  std::atomic<std::uint64_t> words_[kWords]{};
};

/** As DeviceSample, in plain numbers. */
struct SharedSample {
  std::int64_t t_ns;
  std::int64_t answers_ns;  ///< When the order was given that the device has taken before this reading; 0: none.
  double p[3], q[4], gripper_rad;
  std::uint32_t buttons, status;
  std::uint32_t measured;  ///< 0: the status alone.
  std::uint32_t unused;
};
/** As DeviceCommand. */
struct SharedOrder {
  std::int64_t t_ns;
  double force[3], torque[3], gripper_force;
  std::uint32_t enabled;
  std::uint32_t unused;
};

/** What lies in the memory. All zeros is its beginning. */
struct SharedLinkMemory {
  static constexpr std::uint32_t kVersion = 1;
  alignas(64) SharedBox<SharedSample> up;
  alignas(64) SharedBox<SharedOrder> down;
  alignas(64) std::atomic<std::uint32_t> safe;  ///< Zeros, until an order that is off.
  std::atomic<std::uint32_t> calibration;       ///< Calibration.
  std::atomic<std::uint32_t> generation;        ///< Of the helper that may speak; the daemon counts.
};

/** The servo's end. read() and write() by the servo, safe() by anybody, a signal handler too. */
class SharedServoEnd {
 public:
  explicit SharedServoEnd(SharedLinkMemory& memory) noexcept : memory_(memory) {}
  /** As Device::read. A reading that no device can give (not finite, no rotation, from the future) is a device error.
   */
  void read(std::int64_t now_ns, DeviceSample& sample) HD_RT;
  void write(std::int64_t now_ns, const DeviceCommand& command) HD_RT;
  void safe() noexcept { memory_.safe.store(1); }
  /** The helper has ended. If it had told that the device is gone, nothing is on its way to it any more. */
  void lost() noexcept {
    if (gone_.load()) off_.store(true);
  }
  /** As Device::isOff: a reading has come that was taken after the device got an order that is off, or it is gone. */
  [[nodiscard]] bool isOff() const noexcept { return off_.load(); }

  Histogram round_trip;  ///< From a command to a reading after it, both by the servo's own ticks.

 private:
  SharedLinkMemory& memory_;
  std::uint32_t seen_ = 0;
  std::int64_t off_since_ns_ = 0;  ///< When the first order that is off was given, after any that is not; 0: it is not.
  std::atomic<bool> off_{true};
  std::atomic<bool> gone_{false};  ///< The helper says so; not that it has died.
};

/** The device's end: what a DeviceIo in the helper exchanges with. */
class SharedDeviceEnd final : public DeviceLink {
 public:
  SharedDeviceEnd(SharedLinkMemory& memory, std::uint32_t generation, std::int64_t stale_ns) noexcept
      : DeviceLink(stale_ns), memory_(memory), generation_(generation), stale_ns_(stale_ns) {}
  void publish(const DeviceSample& sample) HD_RT override;
  void publishStatus(std::uint32_t status) HD_RT override;

 protected:
  [[nodiscard]] DeviceCommand command(std::int64_t now_ns) HD_RT override;

 private:
  static constexpr int kTell = 20;  ///< A thousand readings a second: longer than a servo needs to look.
  [[nodiscard]] bool current() const HD_RT;
  SharedLinkMemory& memory_;
  std::uint32_t generation_;
  std::int64_t stale_ns_;
  std::uint32_t told_ = 0;  ///< Status that is told with the next readings,
  int tell_ = 0;            ///< so many.
  SharedOrder order_{};
  std::int64_t answers_ns_ = 0;  ///< Of the last order that the device took.
  std::uint32_t seen_ = 0;
};

}  // namespace hapticd
