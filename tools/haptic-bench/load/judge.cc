#include "tools/haptic-bench/load/judge.h"

#include <algorithm>
#include <vector>

#include "tools/haptic-bench/failure.h"

namespace haptic_bench {

ForceError judgeForces(std::span<const haptic_sample> samples, const BuiltSurface& surface, Source source,
                       double stiffness) {
  const std::size_t owner = source == Source::kNative  ? HAPTIC_SOURCE_SURFACE
                            : source == Source::kForce ? HAPTIC_SOURCE_CLIENT
                                                       : HAPTIC_SOURCE_LOCAL_MODEL;
  std::vector<Vec3> hips, forces;
  const auto place = [](const haptic_sample& s) { return Vec3(s.p[0], s.p[1], s.p[2]); };
  for (std::size_t i = 0; i < kApproach && !samples.empty(); ++i) {
    const double part = static_cast<double>(i) / kApproach;
    hips.emplace_back((1 + 0.2 * (1 - part)) * place(samples.front()));
  }
  for (const haptic_sample& s : samples) {
    hips.push_back(place(s));
    forces.emplace_back(s.by_source[owner][0], s.by_source[owner][1], s.by_source[owner][2]);
  }
  const std::vector<Vec3> native = nativeForces(surface.meshes(), stiffness, hips);
  const ForceError e =
      compareForces(forces, std::span(native).subspan(std::min<std::size_t>(kApproach, native.size())));
  if (!(e.mean > 0)) throw Failure("load", "the hand touched nothing", "a stroke takes 0.72 s: more --seconds");
  return e;
}

}  // namespace haptic_bench
