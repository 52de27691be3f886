// The swept ball against triangles: faces moved out by the radius, and the round edges and vertices between them.
#include "rt/geometry/nearest/pseudo_normal.h"
#include "rt/geometry/sweep/first_touch.h"
#include "rt/geometry/sweep/sweep_triangles.h"
#include "rt/geometry/triangle.h"

namespace hapticd {
namespace {

/** Sine of the angle by which a contact on an edge may seem to lie behind a face: rounding on the edge of a knife. */
constexpr double kGrazing = 1e-9;

constexpr int kMaxTouchSteps = 64;  // Of one touch; few are needed.

class BallOverMesh {
 public:
  BallOverMesh(const MeshView& mesh, Sweep& sweep) noexcept
      : mesh_(mesh), sweep_(sweep), rounding_(roundingOf(sweep)) {}

  /** Takes the triangle if it is met first. When it is met does not depend on what was found before. */
  void tryTriangle(std::uint32_t triangle, Earliest& first) HD_RT {
    const Corners v = cornersOf(mesh_, triangle);
    Vec3 n = v.normal();
    const double length2 = n.squaredNorm();
    if (length2 == 0 || isLeftBehind(n, length2, v.a)) return;
    n /= std::sqrt(length2);
    double height = n.dot(sweep_.a - v.a), approach = -n.dot(sweep_.d);
    if (sweep_.two_sided && height < 0) {
      n = -n;
      height = -height;
      approach = -approach;
    }
    // Behind the face all the way, or at its plane too late. Edges seen from behind are left to the neighbour.
    if (std::max(height, height - approach) < -kGrazing * sweep_.radius - rounding_) return;
    const double above = height - sweep_.radius;
    if (above > 0 && approach <= 0) return;
    const double t = above > 0 ? above / approach : 0.0;
    if (!first.isBeatenBy(t, triangle)) return;
    const bool reaches = approach > 0 && above >= -sweep_.tolerance;
    const TriangleFoot foot = nearestOnTriangle(v, sweep_.a + t * sweep_.d);
    if (reaches && foot.kind == FeatureKind::kFace) {
      first.set({t, above, n, n.dot(v.a) + sweep_.radius, triangle, FeatureKind::kFace, 0, Vec3::Zero()});
    } else {
      tryRim(triangle, v, n, t, foot, first);
    }
  }

 private:
  /** Whether the ball is above the plane through a and comes no nearer; without a root. `n` is any length. */
  [[nodiscard]] bool isLeftBehind(const Vec3& n, double length2, const Vec3& a) const HD_RT {
    double above = n.dot(sweep_.a - a), away = n.dot(sweep_.d);
    if (sweep_.two_sided && above < 0) {
      above = -above;
      away = -away;
    }
    return away >= 0 && above > 0 && above * above > sweep_.radius * sweep_.radius * length2;
  }

  /** From the moment on at which the ball reaches the face's plane, beside the face. */
  void tryRim(std::uint32_t triangle, const Corners& v, const Vec3& n, double t, TriangleFoot touched,
              Earliest& first) HD_RT {
    Vec3 out;
    if (!firstTouch(v, first.time(), t, out, touched) || !first.isBeatenBy(t, triangle)) return;
    if (!sweep_.two_sided) {
      if (n.dot(out) < -kGrazing) return;
      if (touched.kind != FeatureKind::kFace &&
          pseudoNormal(mesh_, triangle, touched.kind, touched.corner, sweep_.work).dot(out) < -kGrazing) {
        return;
      }
    }
    const double offset = out.dot(touched.point) + sweep_.radius;
    first.set({t, out.dot(sweep_.a) - offset, out, offset, triangle, touched.kind, touched.corner, Vec3::Zero()});
  }

  /**
   * First t in [t, t_max] at which the ball touches the triangle, as firstTouch() of first_touch.h;
   * `touched` is the point nearest to where it begins, and then that of the touch. Where the nearest
   * edge or vertex stays the nearest a quadratic equation tells it at once, also on grazing ways, on which Newton's
   * steps would gain two bits each.
   */
  bool firstTouch(const Corners& v, double t_max, double& t, Vec3& out, TriangleFoot& touched) const HD_RT {
    for (int step = 0; step < kMaxTouchSteps; ++step) {
      const Vec3 x = sweep_.a + t * sweep_.d;
      if (step > 0) touched = nearestOnTriangle(v, x);
      const Vec3 away = x - touched.point;
      const double turning = away.dot(sweep_.d);
      if (turning >= 0) return false;
      const double distance = away.norm();
      const double gap = distance - sweep_.radius;
      if (step == 0 && gap < -std::max(sweep_.tolerance, rounding_)) return false;
      const double next = t - gap * distance / turning;  // Newton's.
      // Allow for rounding, which is most of a tiny gap, so that both triangles at an edge give the same answer.
      if (gap > rounding_ && t - (gap - rounding_) * distance / turning > t_max) return false;
      out = away / distance;
      if (gap <= rounding_) return true;
      if (touched.kind != FeatureKind::kFace) {
        const Vec3 d = acrossRim(v, touched);
        const double past = (distance - sweep_.radius) * (distance + sweep_.radius), towards = -away.dot(d);
        const double root = towards * towards - d.squaredNorm() * past;
        const double later = t + (root >= 0 ? past / (towards + std::sqrt(root)) : towards / d.squaredNorm());
        const Vec3 there = sweep_.a + later * sweep_.d;
        const TriangleFoot foot = nearestOnTriangle(v, there);
        if (foot.kind == touched.kind && foot.corner == touched.corner) {
          if (root < 0 || later > t_max)
            return false;  // Already where it is nearest the distance is larger; or too late.
          t = later;
          out = (there - foot.point).normalized();
          touched = foot;
          return true;
        }
      }
      if (next <= t) return true;
      t = next;
    }
    return true;
  }

  /** What of the way leads across the edge or vertex. */
  [[nodiscard]] Vec3 acrossRim(const Corners& v, const TriangleFoot& foot) const HD_RT {
    if (foot.kind == FeatureKind::kVertex) return sweep_.d;
    const Vec3 along = foot.corner == 0 ? Vec3(v.b - v.a) : (foot.corner == 1 ? Vec3(v.c - v.b) : Vec3(v.a - v.c));
    return sweep_.d - sweep_.d.dot(along) / along.squaredNorm() * along;
  }

  const MeshView& mesh_;
  Sweep& sweep_;
  double rounding_;
};

}  // namespace

SweepResult sweepBallOverMesh(const MeshView& mesh, Sweep& sweep, SweepHit& hit) HD_RT {
  BallOverMesh ball(mesh, sweep);
  return sweepTriangles(mesh, sweep, hit, [&](std::uint32_t t, Earliest& first) { ball.tryTriangle(t, first); });
}

}  // namespace hapticd
