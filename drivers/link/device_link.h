/** @file
 * What lies between the servo and a device's own I/O thread: the newest sample one way, the newest command the other.
 */
#pragma once

#include <atomic>
#include <cstdint>
#include <type_traits>

#include "rt/base/histogram.h"
#include "rt/device.h"
#include "rt/ring/newest.h"

namespace hapticd {

/** A servo silent for so long has its force taken back. */
inline constexpr std::int64_t kCommandLife_ns = 10'000'000;

/** What happened on the wire since open. The I/O thread writes, anybody reads. */
struct LinkCounters {
  std::atomic<std::uint64_t> exchanges{0};       ///< Answers that were whole and made sense.
  std::atomic<std::uint64_t> lost{0};            ///< Questions without an answer in time.
  std::atomic<std::uint64_t> dropped_bytes{0};   ///< Thrown away to find the next packet.
  std::atomic<std::uint64_t> rejected{0};        ///< Whole packets with a reading that cannot be.
  std::atomic<std::uint64_t> stale_commands{0};  ///< Zeros sent because the servo was silent, or stopped amid an order.
  std::atomic<std::uint64_t> replugs{0};         ///< Times the device came back.

  /** By the one writer. */
  static void add(std::atomic<std::uint64_t>& counter, std::uint64_t n = 1) noexcept {
    counter.store(counter.load(std::memory_order_relaxed) + n, std::memory_order_relaxed);
  }
};

/**
 * The servo calls read and write, the I/O thread the rest but safe(), awaitSent() and isOff(), which anybody may call,
 * a signal handler too. Neither servo nor I/O thread ever waits for the other.
 */
class DeviceLink {
 public:
  /** A command older than `stale_ns` is not sent any more: zeros are. */
  explicit DeviceLink(std::int64_t stale_ns) noexcept : stale_ns_(stale_ns) {}
  virtual ~DeviceLink() = default;
  DeviceLink(const DeviceLink&) = delete;
  DeviceLink& operator=(const DeviceLink&) = delete;

  /** As Device::read. */
  void read(std::int64_t now_ns, DeviceSample& sample) HD_RT;
  /** As Device::write. */
  void write(std::int64_t now_ns, const DeviceCommand& command) HD_RT;

  /** A reading for the servo; its `fresh` is set here. */
  virtual void publish(const DeviceSample& sample) HD_RT { to_servo_.put({sample, true}); }
  /**
   * No reading, but the device's state (bits of DeviceStatus). The servo sees it as not fresh; where a reading follows
   * before it looks, with that one.
   */
  virtual void publishStatus(std::uint32_t status) HD_RT;
  /**
   * Calls send(command) with what is to be sent now: the servo's newest command; zeros when that is stale, off, or
   * safe() was called. The transfer must happen in `send`: awaitSent() waits for it. A `send` that returns a bool says
   * by it whether the device has taken the command.
   */
  template <class Send>
  void order(std::int64_t now_ns, Send&& send) noexcept {
    sending_.store(true);             // S1: before safe_ is read in command(); pairs with S2
    if (sent_off_) off_.store(true);  // The thread has come back from sending it.
    const DeviceCommand now = command(now_ns);
    if (now.enabled) off_.store(false);  // Before it is sent.
    if constexpr (std::is_same_v<std::invoke_result_t<Send, const DeviceCommand&>, bool>) {
      arrived_ = send(now);
    } else {
      send(now);
      arrived_ = true;
    }
    sent_off_ = arrived_ && !now.enabled;
    sending_.store(false, std::memory_order_release);
  }
  /** The last order, said to be taken, has not arrived or may not have: its transfer goes on, or has failed. */
  void notTaken() noexcept { arrived_ = sent_off_ = false; }
  /** The device has gone, and the thread has let go of it: nothing is on its way any more. */
  void lost() noexcept { off_.store(true); }
  /** What was told before the device was opened is over. While neither side is at work. */
  void forget() noexcept { told_.store(0); }
  /** Whether nothing that is not off has been sent since zeros were last seen out, or the device went. Anybody. */
  [[nodiscard]] bool isOff() const noexcept { return off_.load(); }

  /** Zeros from now on, until the servo has sent a command that is off. */
  void safe() noexcept { safe_.store(true); }  // S2: before sending_ is read in awaitSent(); pairs with S1
  /**
   * After safe(): returns when no order from before it is on its way to the device any more, so that zeros sent next
   * are the last word; or after `most_ns`, false, when the I/O thread is stuck in its transfer.
   */
  bool awaitSent(std::int64_t most_ns) const noexcept;

  LinkCounters counters;
  Histogram round_trip;  ///< From a command sent to the answer with a reading. Written by the I/O thread.
  Histogram age;         ///< Of a fresh sample when the servo reads it. Written by the servo.

 protected:
  /** As order() says. */
  [[nodiscard]] virtual DeviceCommand command(std::int64_t now_ns) HD_RT;
  /** Whether the device has the last order. By the I/O thread. */
  [[nodiscard]] bool isTaken() const HD_RT { return arrived_; }

 private:
  struct Reading {
    DeviceSample sample;
    bool measured = false;
  };
  struct Order {
    DeviceCommand command;
    std::int64_t t_ns = 0;
  };

  std::int64_t stale_ns_;
  Newest<Reading> to_servo_;
  std::atomic<std::uint32_t> told_{0};  ///< Status that the servo has not seen; a newer reading may stand before it.
  Newest<Order> to_device_;
  Reading taken_;  ///< The servo's.
  Order order_;    ///< The I/O thread's.
  std::atomic<bool> safe_{false};
  std::atomic<bool> sending_{false};  ///< The I/O thread has taken an order and not yet sent it.
  std::atomic<bool> off_{true};
  bool arrived_ = false;   ///< The device has the last order. The I/O thread's, as is
  bool sent_off_ = false;  ///< that it was off.
};

}  // namespace hapticd
