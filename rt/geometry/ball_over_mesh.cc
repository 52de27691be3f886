// The swept ball against triangles: faces moved out by the radius, and the round edges and vertices between them.
#include "rt/geometry/box_queries.h"
#include "rt/geometry/first_touch.h"
#include "rt/geometry/pseudo_normal.h"
#include "rt/geometry/tree_walk.h"
#include "rt/geometry/triangle.h"

namespace hapticd {
namespace {

/** Sine of the angle by which a contact on an edge may seem to lie behind a face: rounding on the edge of a knife. */
constexpr double kGrazing = 1e-9;

class BallOverMesh {
 public:
  BallOverMesh(const MeshView& mesh, Sweep& sweep) noexcept
      : mesh_(mesh), sweep_(sweep), rounding_(roundingOf(sweep)) {}

  bool meets(std::uint32_t triangle, SweepHit& hit) HD_RT {
    const Corners v{mesh_.vertex(triangle, 0), mesh_.vertex(triangle, 1), mesh_.vertex(triangle, 2)};
    Vec3 n = v.normal();
    const double length = n.norm();
    if (length == 0) return false;
    n /= length;
    double height = n.dot(sweep_.a - v.a), approach = -n.dot(sweep_.d);
    if (sweep_.two_sided && height < 0) {
      n = -n;
      height = -height;
      approach = -approach;
    }
    // Behind the face all the way, or above its plane until too late. Edges seen from behind belong to a neighbour.
    if (std::max(height, height - approach) < -kGrazing * sweep_.radius - rounding_) return false;
    const double above = height - sweep_.radius;
    if (above > 0 && above >= approach * hit.t) return false;
    if (approach > 0 && above >= -sweep_.tolerance && meetsFace(triangle, v, n, above, approach, hit)) return true;
    return meetsRim(triangle, v, n, above > 0 ? above / approach : 0.0, hit);
  }

 private:
  bool meetsFace(std::uint32_t triangle, const Corners& v, const Vec3& n, double above, double approach,
                 SweepHit& hit) HD_RT {
    const double t = std::max(above, 0.0) / approach;
    if (t >= hit.t || nearestOnTriangle(v, sweep_.a + t * sweep_.d).kind != FeatureKind::kFace) return false;
    hit = {t, above, n, n.dot(v.a) + sweep_.radius, triangle, FeatureKind::kFace, 0, Vec3::Zero()};
    return true;
  }

  /** From the moment on at which the ball reaches the face's plane, beside the face. */
  bool meetsRim(std::uint32_t triangle, const Corners& v, const Vec3& n, double t, SweepHit& hit) HD_RT {
    Vec3 out;
    const auto foot = [&](const Vec3& x) { return nearestOnTriangle(v, x).point; };
    if (!firstTouch(sweep_, rounding_, hit.t, foot, t, out)) return false;
    const TriangleFoot touched = nearestOnTriangle(v, sweep_.a + t * sweep_.d);
    if (!sweep_.two_sided) {
      if (n.dot(out) < -kGrazing) return false;
      if (touched.kind != FeatureKind::kFace &&
          pseudoNormal(mesh_, triangle, touched.kind, touched.corner, sweep_.work).dot(out) < -kGrazing) {
        return false;
      }
    }
    const double offset = out.dot(touched.point) + sweep_.radius;
    hit = {t, out.dot(sweep_.a) - offset, out, offset, triangle, touched.kind, touched.corner, Vec3::Zero()};
    return true;
  }

  const MeshView& mesh_;
  Sweep& sweep_;
  double rounding_;
};

}  // namespace

SweepResult sweepBallOverMesh(const MeshView& mesh, Sweep& sweep, SweepHit& hit) HD_RT {
  const SweptBoxes boxes(sweep);
  const BoxTests& tests = boxTests();
  BallOverMesh ball(mesh, sweep);
  bool found = false;
  const bool finished = walkTree(
      mesh, {sweep.work, sweep.limit},
      [&](const hd_bvh_node& node, float* key) { return boxes.look(tests, node, hit.t, key); },
      [&] { return roundedUp(hit.t); },
      [&](std::uint32_t first, std::uint32_t count) {
        for (std::uint32_t t = first; t < first + count; ++t) found |= ball.meets(t, hit);
      });
  if (!finished) return SweepResult::kExhausted;
  return found ? SweepResult::kHit : SweepResult::kNone;
}

}  // namespace hapticd
