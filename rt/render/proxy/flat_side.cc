#include "rt/render/proxy/flat_side.h"

#include <algorithm>

#include "rt/render/proxy/proxy_step.h"

namespace hapticd {
namespace {

/** From triangle to triangle of the side. */
struct FlatSide {
  const MeshView& mesh;
  Vec3 hip;
  double depth;
  int most;
  double less2;  ///< Depth below a plane that is nearer, squared.
  std::uint32_t nearest = HD_NO_INDEX;
  int count = 1;
  std::uint32_t (&side)[kMaxOfSide];

  [[nodiscard]] bool isNearEdge(const SeenFace& f, int k) const HD_RT;
  void lookBeyond(const SeenFace& f) HD_RT;
};

/** Whether the hip's foot is as near to the edge itself, from corner to corner, as isNear() asks of its line. */
bool FlatSide::isNearEdge(const SeenFace& f, int k) const HD_RT {
  Vec3 out = hip - f.v[k];
  const double along = out.dot(f.along[k]);
  if (along > 0 && along < f.along[k].squaredNorm()) return true;
  if (along > 0) out -= f.along[k];
  const double up = out.dot(f.up);
  return out.squaredNorm() - up * up / f.up2 <= kTan2 * depth * depth;
}

void FlatSide::lookBeyond(const SeenFace& f) HD_RT {
  for (int k = 0; k < 3; ++k) {
    Vec3 opposite;
    if (!f.isNear(k, depth) || !f.beyond(k, opposite)) continue;
    const double rise = f.up.dot(opposite), rise2 = rise * rise, flat2 = kFlat * f.up2;
    const std::uint32_t across = mesh.neighbours[f.triangle][k];
    if (rise2 <= flat2 * opposite.squaredNorm() &&  // Else surely not flat.
        rise2 * f.along[k].squaredNorm() <= flat2 * area2(opposite, f.along[k])) {
      if (count < most && std::find(side, side + count, across) == side + count && isNearEdge(f, k))
        side[count++] = across;
      continue;
    }
    if (!(rise < 0)) continue;
    // Above the hip, times the doubled area of what is beyond.
    const double height = -opposite.dot(f.along[k].cross(hip - f.v[k]));
    const double area = area2(opposite, f.along[k]);
    if (!(height > 0 && height * height < less2 * area) || !isNearEdge(f, k)) continue;
    nearest = across;
    less2 = height * height / area;
  }
}

}  // namespace

double distanceToEdge(const MeshView& mesh, std::uint32_t triangle, std::uint32_t corner, const Vec3& x) HD_RT {
  const Vec3 from = mesh.vertex(triangle, static_cast<int>(corner)), out = x - from;
  const Vec3 along = mesh.vertex(triangle, static_cast<int>(corner + 1) % 3) - from;
  return (out - std::clamp(out.dot(along) / along.squaredNorm(), 0.0, 1.0) * along).norm();
}

std::uint32_t nearerOfSide(const SeenFace& face, const Vec3& hip, double depth, int most, std::uint32_t& work) HD_RT {
  std::uint32_t side[kMaxOfSide];
  side[0] = face.triangle;
  FlatSide flat{face.mesh, hip, depth, most, kClearlyNearer * kClearlyNearer * depth * depth, HD_NO_INDEX, 1, side};
  flat.lookBeyond(face);
  for (int i = 1; i < flat.count; ++i, ++work) {
    SeenFace next(face.mesh, side[i]);
    next.seek(hip);
    flat.lookBeyond(next);
  }
  return flat.nearest;
}

}  // namespace hapticd
