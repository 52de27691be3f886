/** @file
 * The control thread's end of one device group: an orderly outbox to the servo, the group's mesh table, and a monitor
 * that sees what every session sees.
 */
#pragma once

#include <array>
#include <memory>
#include <string>

#include "daemon/device/device_group.h"
#include "daemon/device/outbox.h"
#include "daemon/scene/command_sink.h"

namespace hapticd {

/** Session slots of a group that clients can have; the last slot is the monitor's. */
inline constexpr std::uint32_t kClientSessions = kMaxSessions - 1;

/** Control thread only. */
class GroupLink final : public CommandSink {
 public:
  /** Starts the group. Devices are open. */
  [[nodiscard]] static Result<std::unique_ptr<GroupLink>> start(std::string name, const GroupOptions& options,
                                                                std::vector<std::unique_ptr<Device>> devices,
                                                                Clock& clock);
  ~GroupLink() override;
  GroupLink(const GroupLink&) = delete;
  GroupLink& operator=(const GroupLink&) = delete;

  std::uint64_t post(const Command& command) override;
  [[nodiscard]] std::uint64_t posted() const override { return sent_ + outbox_.size(); }
  [[nodiscard]] bool passed(std::uint64_t ticket) override;
  [[nodiscard]] bool accepting() const override { return outbox_.hasRoomFor(*giver_); }
  /** Whether an order to arm that device is: no edits of anybody's take its place. */
  [[nodiscard]] bool acceptingArm(std::uint32_t device) const { return outbox_.of(arming(device)) < kArms; }
  /** From now on orders are given for that connection; 0: for the daemon. It must live as long as this. */
  void setGiver(const std::uint64_t& connection) { giver_ = &connection; }
  [[nodiscard]] std::uint64_t nextTick() const override;
  [[nodiscard]] std::int64_t periodNs() const override { return period_ns_; }
  [[nodiscard]] MeshTable& meshes() override { return *meshes_; }
  [[nodiscard]] bool posed(std::uint32_t slot, std::uint64_t ticket, PosedObject& out) override;

  /**
   * Ends the threads; then what the servo reads may go. False when the servo has not come back from a device: all stays
   * as it is. While it stands still in there, this is answered at once.
   */
  [[nodiscard]] bool endThreads(std::int64_t patience_ns);
  /** Whether endThreads() found it so, and it has not moved since. */
  [[nodiscard]] bool standsStill() const { return stands_at_ == cycles() + 1 && !group_->servoEnded(); }
  /** As DeviceGroup::takeDevices(). The group is no more; nothing but names and tickets answers. */
  [[nodiscard]] DeviceGroup::Leaving stop();

  /**
   * Stops (kStop) or disarms (kDisarm) the device before all that waits in the outbox; orders to arm it that wait there
   * become orders to disarm it, else they undid this. What the servo is about to read anyway is not said again: a flood
   * of stops leaves room for those of other devices. False when the servo has no room.
   */
  [[nodiscard]] bool switchOff(std::uint32_t device, CommandKind kind, std::int64_t now_ns);
  /** Since when an order to switch that device off has waited for the servo; 0: none does. */
  [[nodiscard]] std::int64_t offSince(std::uint32_t device) const;
  /** Whether it was told to switch that device off, and not to arm it since. */
  [[nodiscard]] bool isSwitchedOff(std::uint32_t device) const { return off_[device].kind != CommandKind::kNone; }
  /**
   * Lowers the device's limits to these where they are higher, before all that waits in the outbox, where orders that
   * set limits then set none above these. False when so many of them are under way that a stop would have to wait.
   */
  [[nodiscard]] bool lowerLimits(std::uint32_t device, const GuardLimits& most);
  /** Hands on what the servo has room for. True when orders still wait. */
  bool flush();
  /**
   * Only while the servo stands between two cycles: orders on their way that are the scene model's to restate become
   * orders to do nothing, for a cycle that begins with the whole scene has obeyed them.
   */
  void forgetSceneOrders();

  /** Latest sample of a device; false before the first. */
  [[nodiscard]] bool latest(std::uint32_t device, hd_sample& out) const;
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] DeviceGroup& group() { return *group_; }
  /** Cycles that have ended; what they left in a log is there to be read. */
  [[nodiscard]] std::uint64_t cycles() const;
  /** Bytes of the monitor. */
  [[nodiscard]] static constexpr std::size_t monitorBytes() { return sizeof(hd_region_a); }

 private:
  static constexpr std::uint64_t kInFlight = 64;  ///< Four cycles' worth: an urgent order waits no longer.
  static constexpr std::uint64_t kLowering = kControlCommandsPerCycle;  ///< So many limits at once may overtake.
  static constexpr std::size_t kArms = 16;  ///< Orders to arm one device that may wait, those taken back included.
  static constexpr std::uint64_t kDaemon = 0;

  /** The order to switch a device off that was sent last. */
  struct Off {
    std::uint64_t order = 0;                ///< Its number among all orders sent; 0: there was none.
    CommandKind kind = CommandKind::kNone;  ///< kNone: an order to arm was sent after it.
    std::int64_t since_ns = 0;              ///< When the first of those that wait was sent.
  };

  GroupLink(std::string name, std::int64_t period_ns);
  /** Whose place in the outbox an order to arm that device takes: no connection's. */
  static constexpr std::uint64_t arming(std::uint32_t device) { return ~std::uint64_t{device}; }
  static_assert(kMaxDevices < Outbox::kMostOwn);
  bool urgent(const Command& command);
  [[nodiscard]] bool waits(const Off& off) const;

  std::string name_;
  std::int64_t period_ns_;
  std::unique_ptr<MeshTable> meshes_;
  std::unique_ptr<DeviceGroup> group_;
  hd_region_a* monitor_ = nullptr;
  Outbox outbox_;
  const std::uint64_t* giver_ = &kDaemon;
  std::uint64_t sent_ = 0;    ///< Orders handed on from the outbox.
  std::uint64_t urgent_ = 0;  ///< Orders that overtook.
  std::array<Off, kMaxDevices> off_;
  std::uint64_t stands_at_ = 0;  ///< cycles() + 1 when it was found not to come back; 0: never.
};

}  // namespace hapticd
