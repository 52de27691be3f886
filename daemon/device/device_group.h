/** @file
 * A device group: devices that share one servo, with its servo and ingest threads. The control thread's handle on the
 * real-time side.
 */
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <string>
#include <vector>

#include "daemon/armed/last_resort.h"
#include "rt/base/clock.h"
#include "rt/cycle/realtime.h"
#include "rt/cycle/servo.h"
#include "rt/volume/volume_table.h"

namespace hapticd {

struct GroupOptions {
  CycleConfig cycle;
  IngestConfig ingest;
  int servo_priority = 80;
  int ingest_priority = 70;
  int collide_priority = 60;
  const VolumeTable* volumes = nullptr;  ///< Of meshes that have one; null: none has.
  std::vector<std::uint32_t> cpus;       ///< Where servo and ingest run; empty: anywhere.
  bool allow_no_rt = false;
  SafetyLines* lines = nullptr;  ///< Outlives the group.
  bool threads = true;           ///< False: stepped by hand with step() (tests, benchmarks).
};

/** Control thread only, but for the threads it owns. */
class DeviceGroup {
 public:
  /** Devices are open. kNoRealtime when rights are missing and allow_no_rt is not set. */
  [[nodiscard]] static Result<std::unique_ptr<DeviceGroup>> start(const GroupOptions& options,
                                                                  std::vector<std::unique_ptr<Device>> devices,
                                                                  const MeshTable& meshes, Clock& clock);
  /** Joins the threads, then safe() and close() on each device that is still its own. */
  ~DeviceGroup();

  /**
   * Ends the threads. False when the servo has not come back from a device within so much Patience: then safe() was
   * called for each device, and should it come back it goes on as before. True when there is none (any more).
   */
  [[nodiscard]] bool endThreads(std::int64_t patience_ns);
  /** Whether the servo has ended, though nobody may have joined it yet. */
  [[nodiscard]] bool servoEnded() const { return servo_ended_.load(std::memory_order_acquire); }  // A6
  /** Open devices that no servo has any more, still held for the last resort. */
  struct Leaving {
    std::vector<std::unique_ptr<Device>> devices;
    std::list<LastResort> last_resort;  // goes before them
  };
  /** Waits for the threads, however long: after endThreads() for nothing. */
  [[nodiscard]] Leaving takeDevices();

  /** Queues an order for the servo, in order. False when 512 wait (the servo is dead). */
  [[nodiscard]] bool send(const Command& command);
  /** Number of the last order sent; the servo has taken it once taken() >= it. Reclaim memory by these. */
  [[nodiscard]] std::uint64_t sent() const { return sent_; }
  /** A count of orders as the servo keeps it, which wraps at 2^32; of the last so many. */
  [[nodiscard]] std::uint64_t widened(std::uint32_t count) const {
    return sent_ - (static_cast<std::uint32_t>(sent_) - count);
  }
  /** Number of the last order that the servo has taken. */
  [[nodiscard]] std::uint64_t takenByServo() const;
  /** It is taken when the servo has passed it and the collide thread reads nothing that it has dropped. */
  [[nodiscard]] std::uint64_t taken();

  [[nodiscard]] std::size_t deviceCount() const { return devices_.size(); }
  [[nodiscard]] Device& device(std::size_t i) { return *devices_[i]; }
  [[nodiscard]] Servo& servo() { return *servo_; }
  [[nodiscard]] Ingest& ingest() { return *ingest_; }
  [[nodiscard]] ColliderCounters& colliderCounters() { return collider_->counters; }
  [[nodiscard]] bool realtime() const { return realtime_; }
  /** Why not, when realtime() is false. */
  [[nodiscard]] const std::string& schedulingNote() const { return note_; }
  [[nodiscard]] const GroupOptions& options() const { return options_; }

  /**
   * Runs `work` while the servo stands still between two cycles; periods that pass meanwhile are left out, not missed.
   * Only while no device is armed: nobody holds the hand's force. kTimeout when the servo does not come to a stand.
   */
  [[nodiscard]] Result<void> betweenCycles(const std::function<void(Servo&)>& work);

  /** Without threads: one ingest round, one cycle and one answer of the collide thread. */
  void step();

 private:
  DeviceGroup(const GroupOptions& options, std::vector<std::unique_ptr<Device>> devices, const MeshTable& meshes,
              Clock& clock);
  Result<void> startThreads();
  void standStill(std::uint64_t stand) HD_RT;
  void joinAll() noexcept;

  GroupOptions options_;
  std::vector<std::unique_ptr<Device>> devices_;
  std::list<LastResort> last_resort_;  ///< One of each device.
  Clock& clock_;
  std::unique_ptr<Ingest> ingest_;
  std::unique_ptr<Collider> collider_;
  std::unique_ptr<Servo> servo_;
  std::atomic<bool> stop_{false};         ///< The servo is to end.
  std::atomic<bool> stop_others_{false};  ///< Ingest and collide are; after the servo.
  std::atomic<bool> servo_ended_{false};
  std::atomic<std::uint64_t> hold_{0};  ///< Number of the stand in which the servo is to stand still, 0: none ...
  std::atomic<std::uint64_t> held_{0};  ///< ... and of the last in which it did.
  RtThread ingest_thread_, collide_thread_, servo_thread_;
  bool realtime_ = false;
  std::string note_;
  std::uint64_t stands_ = 0;
  std::uint64_t late_at_ = 0;  ///< Cycles + 1 before a stand to which it did not come; 0: there was none.
  std::uint64_t sent_ = 0;
  std::uint64_t taken_ = 0;
};

}  // namespace hapticd
