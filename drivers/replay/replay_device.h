/** @file
 * The replay device: replay://FILE?speed=1&loop=0 plays recorded positions.
 */
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>

#include "drivers/link/holds_memory.h"
#include "drivers/link/slow_to_open.h"
#include "drivers/parameters.h"
#include "drivers/pose_file.h"
#include "drivers/registry.h"
#include "rt/device.h"

namespace hapticd {

/** Keys of a replay:// URI; see replayParameterTable(). */
struct ReplayParameters {
  double speed = 1;
  double wait = 0;
  bool loop = false;
  double max_force = 10;
  double max_torque = 0.2;
  double resolution = 1e-5;
  std::string serial;
};

[[nodiscard]] const std::vector<Parameter<ReplayParameters>>& replayParameterTable();

/** A URI resolved: the file found, the query applied. */
struct ReplaySetup {
  ReplayParameters parameters;
  PoseFile file;
  DeviceInfo info;
};
[[nodiscard]] Result<ReplaySetup> resolveReplay(const DeviceUri& uri);

/**
 * Plays a recording from the first read on, in the time of now_ns times speed, with straight lines between its rows. It
 * cannot be moved: it takes commands as an actuated device does, so that contact, guard and limits run as usual and
 * what the hand would have felt is published, and ignores them.
 *
 * read and write are real-time safe.
 */
class ReplayDevice final : public Device, public SlowToOpen, public HoldsMemory {
 public:
  explicit ReplayDevice(ReplaySetup setup) : setup_(std::move(setup)) {}

  [[nodiscard]] const DeviceInfo& info() const noexcept override { return setup_.info; }
  [[nodiscard]] Result<void> open() override;
  void giveUp() noexcept override { given_up_.store(true, std::memory_order_relaxed); }
  void close() noexcept override { track_ = nullptr; }
  [[nodiscard]] std::size_t heldBytes() const noexcept override { return track_ == nullptr ? 0 : track_->bytes(); }
  void read(std::int64_t now_ns, DeviceSample& sample) HD_RT override;
  void write(std::int64_t, const DeviceCommand&) HD_RT override {}
  void safe() noexcept override {}

 private:
  ReplaySetup setup_;
  std::shared_ptr<const PoseTrack> track_;  ///< While it is open.
  bool started_ = false;
  std::int64_t start_ns_ = 0;
  std::int64_t last_ns_ = 0;
  std::atomic<bool> given_up_{false};
};

}  // namespace hapticd
