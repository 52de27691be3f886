#include "rt/collide/sheet.h"

#include "rt/collide/edge_search.h"
#include "rt/collide/purse.h"
#include "rt/geometry/nearest/fan.h"
#include "rt/geometry/nearest/pseudo_normal.h"
#include "rt/geometry/sweep/sweep.h"

namespace hapticd {
namespace {

constexpr double kHairOff = 2e-5;  ///< From a sheet to where a way across it begins and ends [m].

/** Whether a triangle has a border within kInset of a point of it; `out`: to beyond that border. */
bool isNearBorder(const MeshView& mesh, std::uint32_t t, const Vec3& x, Vec3& out) HD_RT {
  for (int k = 0; k < 3 && mesh.neighbours != nullptr; ++k) {
    if (mesh.neighbours[t][k] != HD_NO_INDEX) continue;
    const Vec3 from = mesh.vertex(t, k), along = (mesh.vertex(t, (k + 1) % 3) - from).normalized();
    if (!(along.cross(x - from).norm() < kInset)) continue;
    out = 2 * kInset * along.cross(faceNormal(mesh, t));
    return true;
  }
  return false;
}

}  // namespace

bool isOnBorder(const MeshView& mesh, const Nearest& nearest) HD_RT {
  if (nearest.kind == FeatureKind::kFace || mesh.neighbours == nullptr) return false;
  const auto ends = [&](std::uint32_t t, std::uint32_t edge) HD_RT { return mesh.neighbours[t][edge] == HD_NO_INDEX; };
  if (nearest.kind == FeatureKind::kEdge) return ends(nearest.feature, nearest.corner);
  return anyAbout(mesh, nearest.feature, mesh.triangles[nearest.feature][nearest.corner],
                  [&](std::uint32_t t, std::uint32_t here) HD_RT { return ends(t, here) || ends(t, (here + 2) % 3); });
}

/**
 * What lies on a sheet and slides off its border is in the sheet by a hair there: a way that meets nothing a little
 * farther out counts, too. Where two borders lie side by side as a seam it meets the other.
 */
bool SceneContacts::hasGoneRound(const Vec3& x_A, const CollideRequest::Held& held,
                                 const CollideRequest::Obstacle& sheet, const Vec3& up, Purse& purse) const HD_RT {
  const Vec3 from = before(stoodOf(sheet)).inverse() * (before(stoodOf(held)) * x_A) + kHairOff * up;
  const Vec3 way = sheet.X_WO.inverse() * (held.X_WO * x_A) - kHairOff * up - from;
  SweepHit hit;
  const auto meets = [&](const Vec3& start) HD_RT {
    Sweep sweep;
    sweep.a = start;
    sweep.d = way;
    sweep.two_sided = true;
    sweep.limit = purse.left();
    hit = {};
    const SweepResult result = sweepShape(sheet.shape, sweep, hit);
    purse.report.work += sweep.work;
    return result;
  };
  const SweepResult straight = meets(from);
  if (straight != SweepResult::kHit) return straight == SweepResult::kNone;
  Vec3 out;
  return isNearBorder(*sheet.shape.mesh, hit.feature, hit.point, out) && meets(from + out) == SweepResult::kNone;
}

}  // namespace hapticd
