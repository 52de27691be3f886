/** @file
 * Which places told by a vendor's library are believed. Pure, real-time safe.
 */
#pragma once

#include <cstdint>
#include <optional>

#include "drivers/link/hand_time.h"
#include "rt/base/math.h"
#include "rt/device.h"

namespace hapticd {

/**
 * A place must be finite, within reach, and no further from the last one than a hand gets. A few that are not are
 * dropped; kBadInARow mean that something is broken: a device error, after which the next place within reach is the
 * new truth.
 */
class PoseCheck {
 public:
  static constexpr double kMostSpeed = 10;  ///< [m/s]
  static constexpr int kBadInARow = 20;
  enum class Verdict : std::uint8_t { kBelieved, kDropped, kBroken };

  void forget() HD_RT { known_ = false, bad_ = 0; }
  [[nodiscard]] Verdict judge(const Vec3& p, std::int64_t now_ns, const DeviceInfo& info) HD_RT {
    const double time_s = 1e-3 * hand_time_.ms(last_ns_, now_ns, bad_);
    const bool there = p.allFinite() && (p.array() >= info.max_workspace_lower.array()).all() &&
                       (p.array() <= info.max_workspace_upper.array()).all();
    if (there && (!known_ || (p - last_).norm() <= kMostSpeed * time_s)) {
      last_ = p;
      last_ns_ = now_ns;
      known_ = true;
      bad_ = 0;
      return Verdict::kBelieved;
    }
    if (++bad_ < kBadInARow) return Verdict::kDropped;
    forget();
    return Verdict::kBroken;
  }

 private:
  Vec3 last_ = Vec3::Zero();
  std::int64_t last_ns_ = 0;
  int bad_ = 0;
  HandTime hand_time_;
  bool known_ = false;
};

/** The rotation that these rows are, if they are one within a hundredth. */
[[nodiscard]] inline std::optional<Quat> rotationOf(const Eigen::Matrix3d& m) HD_RT {
  if (!m.allFinite() || m.determinant() < 0) return std::nullopt;
  if ((m * m.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() > 0.01) return std::nullopt;
  return Quat(m).normalized();
}

}  // namespace hapticd
