#include "tools/haptic-bench/trajectory/fit.h"

#include <fmt/format.h>

#include <algorithm>

#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/model/tree_nearest.h"
#include "tools/haptic-bench/tell.h"

namespace haptic_bench {
namespace {

// Parts of the radius. Facets of a smooth hollow meet at angles of a degree or so: less than the first. Normals that
// are interpolated over coarse facets are tilted by up to 18 degrees: the second.
constexpr double kHollow = 3e-4, kTilted = 0.05;
constexpr double kVertex = 1e-7;  // [m]: rounding of vertices.

bool fits(const SurfaceSample& s, double radius, const TreeNearest& surface) {
  const SurfacePoint below = surface.find(s.point);
  const double height = below.inside ? -below.distance : below.distance;
  const double here = radius * s.normal.dot(below.outward(s.point));  // Over the facet, as if it had no end.
  const double distance = surface.find(s.point + radius * s.normal).distance;
  return distance > height + std::max(here - kHollow * radius, (1 - kTilted) * radius) - kVertex;
}

}  // namespace

void judgeWhereItFits(Trajectory& in, const std::vector<SurfaceSample>& out, const Model& model, double radius,
                      const std::string& what) {
  if (radius == 0) return;
  const TreeNearest surface(model);
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (fits(out[i], radius, surface)) continue;
    in.samples[i].judged = false;
    ++in.unfit;
  }
  if (in.unfit < out.size()) return;
  throw Failure(what, fmt::format("a ball of {:g} mm fits nowhere on its way", 1e3 * radius), "a smaller --radius");
}

void tellOfThinPlaces(const Trajectory& in, const std::vector<SurfaceSample>& out, const Model& model,
                      const std::string& what) {
  const TreeNearest surface(model);
  std::size_t beyond = 0;
  for (std::size_t i = 0; i < out.size(); ++i) {
    const Vec3& hip = in.samples[i].hip;
    if (out[i].force > 0 && surface.find(hip).outward(hip).dot(out[i].normal) < 0) ++beyond;
  }
  if (beyond == 0) return;
  tellOnce(
      fmt::format("{}: at {} of {} samples another side of {} is nearer to the hand than the one it presses on, "
                  "and nearest is no yardstick",
                  what, beyond, out.size(), model.name));
}

}  // namespace haptic_bench
