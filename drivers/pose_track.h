/** @file
 * A recorded motion: poses over time, read from CSV when a device opens, evaluated in real time.
 */
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "rt/base/error.h"
#include "rt/base/math.h"

namespace hapticd {

/** One row. Time counts from the first row. */
struct PoseRow {
  double t_s = 0;
  Vec3 p = Vec3::Zero();
  Quat q = Quat::Identity();
  double gripper_rad = 0;
  std::uint32_t buttons = 0;
};

/** A pose on the way, with its velocity. */
struct PoseOnTrack {
  Vec3 p = Vec3::Zero(), v = Vec3::Zero();
  Quat q = Quat::Identity();
  Vec3 w = Vec3::Zero();
  double gripper_rad = 0;
  std::uint32_t buttons = 0;
};

/** Rows in order of time, at least one. Immutable once made. */
class PoseTrack {
 public:
  static constexpr std::size_t kMaxRows = 2'000'000;
  static constexpr std::size_t kMaxFileBytes = 64u << 20;

  /**
   * Straight lines between the rows (great arcs for the rotation); holds the ends, or starts again if `loop`. Before 0
   * it stands at its first row.
   */
  [[nodiscard]] PoseOnTrack at(double t_s, bool loop) const HD_RT;
  [[nodiscard]] double duration() const HD_RT { return rows_.back().t_s; }
  [[nodiscard]] const std::vector<PoseRow>& rows() const noexcept { return rows_; }
  [[nodiscard]] std::size_t bytes() const noexcept { return rows_.size() * sizeof(PoseRow); }
  /** Whether any row turns, grips or presses. */
  [[nodiscard]] bool hasRotation() const noexcept { return has_rotation_; }
  [[nodiscard]] bool hasGripper() const noexcept { return has_gripper_; }
  [[nodiscard]] bool hasButtons() const noexcept { return has_buttons_; }

 private:
  friend Result<std::shared_ptr<const PoseTrack>> parsePoseCsv(std::string_view text, std::string_view name,
                                                               const std::atomic<bool>* given_up);
  std::vector<PoseRow> rows_;
  bool has_rotation_ = false, has_gripper_ = false, has_buttons_ = false;
};

/**
 * Reads comma-separated rows. With a header line, columns are found by name: time t or time in seconds, position x, y,
 * z or px, py, pz in metres, or with a unit behind: t_ms, x_mm (t_ns goes before another time); optionally rotation qw,
 * qx, qy, qz, gripper_rad and buttons (a bit mask); others are passed over. Without one they are t,x,y,z[,qw,qx,qy,qz].
 * Empty lines and those that begin with '#' are passed over. Times must rise from row to row. Errors name `name`, line
 * and column; kCancelled once `given_up` is true. Fuzzed.
 */
[[nodiscard]] Result<std::shared_ptr<const PoseTrack>> parsePoseCsv(std::string_view text, std::string_view name,
                                                                    const std::atomic<bool>* given_up = nullptr);

}  // namespace hapticd
