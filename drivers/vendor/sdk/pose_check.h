/** @file
 * Which places told by a vendor's library are believed. Pure, real-time safe.
 */
#pragma once

#include <cstdint>
#include <optional>

#include "drivers/link/reading_check.h"
#include "rt/base/math.h"
#include "rt/device.h"

namespace hapticd {

/** As ReadingCheck; a place must be finite and within reach. */
class PoseCheck {
 public:
  static constexpr double kMostSpeed = 10;  ///< [m/s]
  static constexpr int kBadInARow = 20;
  using Verdict = ReadingCheck::Verdict;

  void forget() HD_RT { check_.forget(); }
  [[nodiscard]] Verdict judge(const Vec3& p, std::int64_t now_ns, const DeviceInfo& info) HD_RT {
    const bool there = p.allFinite() && (p.array() >= info.max_workspace_lower.array()).all() &&
                       (p.array() <= info.max_workspace_upper.array()).all();
    const Verdict verdict = check_.judge(there, (p - last_).norm(), now_ns);
    if (verdict == Verdict::kBelieved) last_ = p;
    return verdict;
  }
  /** As ReadingCheck's. */
  [[nodiscard]] bool trusted(std::int64_t now_ns, std::int64_t most_ns) const HD_RT {
    return check_.trusted(now_ns, most_ns);
  }

 private:
  ReadingCheck check_{1e-3 * kMostSpeed, kBadInARow};
  Vec3 last_ = Vec3::Zero();
};

/** The rotation that these rows are, if they are one within a hundredth. */
[[nodiscard]] inline std::optional<Quat> rotationOf(const Eigen::Matrix3d& m) HD_RT {
  if (!m.allFinite() || m.determinant() < 0) return std::nullopt;
  if ((m * m.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() > 0.01) return std::nullopt;
  return Quat(m).normalized();
}

}  // namespace hapticd
