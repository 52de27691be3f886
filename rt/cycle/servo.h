/** @file
 * The servo: one device group's loop. Wakes at absolute deadlines, reads the devices, gathers the CycleInput, steps the
 * cycle, writes the devices and publishes to every session.
 */
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>

#include "rt/base/clock.h"
#include "rt/base/histogram.h"
#include "rt/collide/collider.h"
#include "rt/cycle/cycle.h"
#include "rt/cycle/cycle_log.h"
#include "rt/cycle/pose_board.h"
#include "rt/cycle/safety_lines.h"
#include "rt/ingest/ingest.h"
#include "rt/ring/state.h"

namespace hapticd {

/** Where the servo publishes for one session. Set by control before kAddSession, cleared after kFreeSession passed. */
struct SessionPort {
  std::atomic<hd_region_a*> region{nullptr};
};

/** Durations of the stages of a cycle. */
struct ServoHistograms {
  Histogram wake, read, render, guard, write, cycle;
};

/** Counters for status and watchdog; written by the servo, read by anybody. */
struct ServoCounters {
  std::atomic<std::uint64_t> tick{0};
  std::atomic<std::uint64_t> cycles{0};
  std::atomic<std::uint64_t> missed{0};
  std::atomic<std::uint64_t> overruns{0};
  std::atomic<std::uint64_t> stale{0};
  std::atomic<std::uint64_t> contacts{0};
  std::array<std::atomic<float>, kMaxDevices> heat{};  ///< GuardOutput::heat of each device.
  std::atomic<std::uint64_t> faults{0};
  std::atomic<std::uint64_t> events_dropped{0};
  std::atomic<std::int64_t> last_cycle_ns{0};     ///< Clock at the end of the last cycle: the heartbeat.
  std::atomic<std::uint32_t> control_applied{0};  ///< Commands of the control thread taken so far (wraps).
};

class Servo {
 public:
  /** Devices are open and outlive the servo; so does everything else referred to. */
  Servo(const CycleConfig& config, std::array<Device*, kMaxDevices> devices, const MeshTable& meshes, Clock& clock);

  /** Sets the first deadline to the next period from now. */
  void begin() HD_RT;
  /** Waits for the next deadline on the clock, then runs one cycle. Missed periods are counted and skipped. */
  void runOnce() HD_RT;
  /** The last act: zeros to the devices. */
  void end() HD_RT;

  /** Goes on with a copy of this cycle from the next period. Not while it runs: see DeviceGroup::betweenCycles(). */
  void replaceCycle(const Cycle& cycle) { cycle_ = cycle; }
  /** Brings the whole pose board up to date at once. Not while it runs. */
  void publishPoses() HD_RT;
  /** Leaves out the periods that passed while nobody ran it, without counting them as missed. */
  void skipPassed() HD_RT;

  // Inlets. Each has one producer.
  ControlToServo from_control;
  Ingest* ingest = nullptr;      ///< Its commands are taken; null in tests without one.
  Collider* collider = nullptr;  ///< Asked where tools touch; null in tests without one.
  std::array<SessionPort, kMaxSessions> ports;
  std::atomic<bool> stop_line{false};
  std::atomic<bool> deadman_open{false};
  std::atomic<bool> no_realtime{false};  ///< Only shown.
  SafetyLines* lines = nullptr;          ///< Of the machine, beside the two above; null: there are none.
  SafetyLines::Sign* sign = nullptr;     ///< Of this servo among them.

  // Outlets.
  std::atomic<CycleLog*> log{nullptr};  ///< Every cycle goes there while it is set.
  SpscRing<ServoEvent, 1024> events;
  ServoCounters counters;
  ServoHistograms histograms;
  PoseBoard poses;  ///< Published once a cycle, after the commands: poses.publish(cycle_.scene(), tick_, applied).

  [[nodiscard]] const Cycle& cycle() const HD_RT { return cycle_; }
  [[nodiscard]] const CycleInput& lastInput() const HD_RT { return *input_; }
  [[nodiscard]] const CycleOutput& lastOutput() const HD_RT { return *output_; }

 private:
  void gather() HD_RT;
  [[nodiscard]] bool deadmanOpen(std::uint32_t device) HD_RT;
  void addButtons(std::uint32_t device) HD_RT;
  void askCollider() HD_RT;
  void publish(std::int64_t woke_ns, std::int64_t late_ns) HD_RT;
  void publishSession(std::uint32_t slot) HD_RT;
  void count(std::int64_t done_ns, std::int64_t late_ns) HD_RT;

  /** What a device shows of the group's dead-man switch. */
  struct Deadman {
    bool is_one = false;
    std::int64_t heard_ns = 0;  ///< Deadline of its last fresh sample.
  };

  CycleConfig config_;
  std::array<Device*, kMaxDevices> devices_;
  std::array<Deadman, kMaxDevices> deadman_;
  Clock& clock_;
  Cycle cycle_;
  std::unique_ptr<CycleInput> input_;
  std::unique_ptr<CycleOutput> output_;
  std::unique_ptr<CollideRequest> question_;
  bool asked_ = false;  ///< The last question named a tool.
  std::array<StateWriter, kMaxSessions> writers_;
  std::int64_t deadline_ns_ = 0;
  std::uint64_t tick_ = 0;
  std::int64_t last_cycle_duration_ns_ = 0;
  std::uint32_t orders_taken_ = 0;
  std::uint32_t max_wake_ns_ = 0;
  std::uint32_t max_cycle_ns_ = 0;
};

}  // namespace hapticd
