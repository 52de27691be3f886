// Recorded motions: whatever the file holds, it is refused with a place or can be played.
#include <cmath>
#include <cstdint>
#include <cstdlib>

#include "drivers/pose_track.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace hapticd;
  const auto track = parsePoseCsv({reinterpret_cast<const char*>(data), size}, "fuzz");
  if (!track.ok()) {
    if (track.error().where.empty() || track.error().what.empty()) std::abort();
    return 0;
  }
  const std::vector<PoseRow>& rows = (*track)->rows();
  for (const bool loop : {false, true}) {
    for (const double share : {-1.0, 0.0, 0.3, 0.999999, 1.0, 1.7, 1e12}) {
      const PoseOnTrack pose = (*track)->at(share * (*track)->duration(), loop);
      if (!pose.p.allFinite() || !pose.q.coeffs().allFinite() || std::abs(pose.q.norm() - 1) > 1e-6) std::abort();
      if (!pose.v.allFinite() || !pose.w.allFinite() || !std::isfinite(pose.gripper_rad)) std::abort();
    }
  }
  for (std::size_t i = 1; i < rows.size(); ++i) {
    if (!(rows[i].t_s > rows[i - 1].t_s)) std::abort();
  }
  return 0;
}
