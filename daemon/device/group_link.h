/** @file
 * The control thread's end of one device group: an orderly outbox to the servo, the group's mesh table, and a monitor
 * that sees what every session sees.
 */
#pragma once

#include <deque>
#include <memory>
#include <string>

#include "daemon/device/device_group.h"
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
  [[nodiscard]] bool accepting() const override { return outbox_.size() < kOutbox; }
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

  /** Overtakes what waits in the outbox: stop, disarm, loss of a session. False when the servo has no room, be it
   * dead or flooded with such orders. */
  [[nodiscard]] bool urgent(const Command& command);
  /** Orders to arm that device that still wait become orders to disarm it: else they undid what overtakes them. */
  void callOffArms(std::uint32_t device);
  /**
   * Lowers the device's limits to these where they are higher, before all that waits in the outbox, where orders that
   * set limits then set none above these. False when so many of them are under way that a stop would have to wait.
   */
  [[nodiscard]] bool lowerLimits(std::uint32_t device, const GuardLimits& most);
  /** Hands on what the servo has room for. True when orders still wait. */
  bool flush();

  /** Latest sample of a device; false before the first. */
  [[nodiscard]] bool latest(std::uint32_t device, hd_sample& out) const;
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] DeviceGroup& group() { return *group_; }
  /** Cycles that have ended; what they left in a log is there to be read. */
  [[nodiscard]] std::uint64_t cycles() const;
  /** Bytes of the monitor. */
  [[nodiscard]] static constexpr std::size_t monitorBytes() { return sizeof(hd_region_a); }

 private:
  static constexpr std::size_t kOutbox = 4096;    ///< Beyond it edits are refused.
  static constexpr std::uint64_t kInFlight = 64;  ///< Four cycles' worth: an urgent order waits no longer.
  static constexpr std::uint64_t kLowering = kControlCommandsPerCycle;  ///< So many limits at once may overtake.

  GroupLink(std::string name, std::int64_t period_ns);

  std::string name_;
  std::int64_t period_ns_;
  std::unique_ptr<MeshTable> meshes_;
  std::unique_ptr<DeviceGroup> group_;
  hd_region_a* monitor_ = nullptr;
  std::deque<Command> outbox_;
  std::uint64_t sent_ = 0;       ///< Orders handed on from the outbox.
  std::uint64_t urgent_ = 0;     ///< Orders that overtook.
  std::uint64_t stands_at_ = 0;  ///< cycles() + 1 when it was found not to come back; 0: never.
};

}  // namespace hapticd
