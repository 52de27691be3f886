// Room for the ball: where a mesh has moved into it, it is pushed out, or made smaller where it cannot go.
#include <limits>

#include "rt/render/proxy/proxy_step.h"

namespace hapticd {
namespace {

constexpr int kMaxPushes = 8;         // Of the ball out of one mesh in one tick.
constexpr double kAway = 1.25;        // Skins that it is pushed off the surface: fitRadius() wants one.
constexpr double kLeastBall = 1024;   // Skins: on a smaller one what it touches lies in no direction but rounding's.
constexpr double kOnSheet = 0x1p-6;   // Skins: twice as near as a two-sided triangle must be to hold from either side,
constexpr double kOffSheet = 0x1p-3;  // and clearly beyond.
constexpr int kMaxSheets = 4;         // That meet where the proxy is.

/** From the surface to the centre of the ball, unit; false if that is inside. */
bool outward(const Nearest& near, const Vec3& x, bool two_sided, double skin, double distance, Vec3& out) HD_RT {
  const Vec3 away = x - near.point;
  const double side = away.dot(near.pseudo_normal);
  if (!two_sided && side < 0) return false;
  if (near.kind == FeatureKind::kFace || distance < kDirected * skin) {
    out = side < 0 ? Vec3(-near.pseudo_normal) : near.pseudo_normal;
  } else {
    out = away / distance;
  }
  return true;
}

/** The skin above an object where the proxy touches it, however far away it is now. */
template <class Step>
double skinInTouch(const Step& step, const SceneObject& object) HD_RT {
  const double size = object.radius + (object.center_W - object.X_WO.p).norm();
  return std::min(step.skin(object), 2 * kSkin * (step.scale + size));
}

}  // namespace

NearestResult nearestWithin(const SceneObject& object, const Vec3& x, double reach, Vicinity* vicinity,
                            std::uint32_t& work, Nearest& near) HD_RT {
  NearestQuery query;
  query.x = x;
  query.reach = reach;
  query.vicinity = vicinity;
  query.work = work;
  query.limit = ProxyRenderer::kMaxWork;
  const NearestResult result = nearestOnShape(object.shape, query, near);
  work = query.work;
  return result;
}

/**
 * Pushes the ball out of meshes whose vertices have moved into it, faces, edges or vertices; its centre they have taken
 * along already. It is swept through the meshes as they are now, as large as it is free where it is, so it passes
 * nothing; where it cannot go it is made to fit (fitRadius), as in a mesh that has appeared about its centre.
 */
void ProxyRenderer::makeRoom(Step& step) HD_RT {
  for (const std::uint16_t slot : step.scene->touchable()) {
    const SceneObject& object = step.scene->slot(slot);
    if (object.shape.kind != ShapeKind::kMesh || object.appeared || about_[slot]) continue;
    if (step.scene->movesTriangles(*object.shape.mesh)) pushOut(step, slot);
  }
}

void ProxyRenderer::pushOut(Step& step, std::uint32_t slot) HD_RT {
  const SceneObject& object = step.scene->slot(slot);
  const double skin = step.skin(object);
  const bool two_sided = (object.flags & HD_OBJECT_TWO_SIDED) != 0;
  Vec3& x = start_[slot];
  HalfSpace planes[kMaxHalfSpaces];
  int count = 0;
  double ahead = 1;  // How far is looked, in parts of the push.
  for (int push = 0; push < kMaxPushes; ++push) {
    Nearest near;
    if (nearestWithin(object, x, radius_ + 0.5 * skin, nullptr, step.work, near) != NearestResult::kFound) return;
    const double distance = std::sqrt(near.squared_distance);
    Vec3 out;
    if (!outward(near, x, two_sided, skin, distance, out)) return;

    step.carried = true;
    // As little as gets it off all that was in its way.
    if (count == kMaxHalfSpaces) count = 0;
    planes[count++] = {out, out.dot(near.point) + radius_ + kAway * skin};
    Vec3 to = x;
    std::uint32_t active = 0;
    if (!nearestInside(planes, count, kNear * skin, to, active)) {
      planes[0] = planes[count - 1];
      count = 1;
      to = x - planes[0].height(x) * out;
      ahead = 2;
    }
    Sweep sweep;
    sweep.a = x;
    sweep.d = ahead * (to - x);
    sweep.radius = std::max(0.0, distance - skin);
    sweep.tolerance = kNear * skin;
    sweep.two_sided = two_sided;
    sweep.work = step.work;
    sweep.limit = kMaxWork;
    SweepHit hit;
    const SweepResult free = sweepShape(object.shape, sweep, hit);
    step.work = sweep.work;
    if (free == SweepResult::kExhausted) return;
    // Between two walls as far from the one as from the other.
    x += (free == SweepResult::kHit ? 0.5 * hit.t : 1 / ahead) * sweep.d;
  }
}

/**
 * Off two-sided triangles on which the proxy has started, which have appeared on it, or onto whose border it has come
 * in their plane: so near that they would hold it from either side. It comes to lie on the one where it is; `unstuck`,
 * held so where nothing moves, on the hip's; on the front, if that cannot be told. True if there were any.
 */
bool ProxyRenderer::stepOff(Step& step, bool unstuck) HD_RT {
  bool stepped = false;
  for (const std::uint16_t slot : step.scene->touchable()) {
    const SceneObject& object = step.scene->slot(slot);
    if (object.shape.kind != ShapeKind::kMesh || (object.flags & HD_OBJECT_TWO_SIDED) == 0) continue;
    const double skin = step.skin(object);
    for (int sheet = 0; sheet < kMaxSheets; ++sheet) {
      const Vec3 x = startIn(step, slot);
      Nearest near;
      if (nearestWithin(object, x, kOnSheet * skin, nullptr, step.work, near) != NearestResult::kFound) break;
      double height = (x - near.point).dot(near.normal);
      if (unstuck && step.together) {
        const double hip = (step.hipIn(slot) - near.point).dot(near.normal);
        if (std::abs(hip) > skin) height = hip;
      }
      const Vec3 off = (height < 0 ? -1 : 1) * kOffSheet * skin * near.normal;
      stepped = true;
      if (step.together) {
        proxy_ += object.R_WO * off;
      } else {
        start_[slot] += off;
      }
    }
  }
  return stepped;
}

/**
 * As large a ball as wanted, or as there is room for; a point where there is next to none. Of what its centre is inside
 * nothing is felt until that has left it, and no more then of what the ball overlaps yet: it is looked for till then.
 */
void ProxyRenderer::fitRadius(Step& step) HD_RT {
  double room = wanted_radius_, least = 0;
  std::bitset<kMaxObjects> about;
  std::uint32_t work = std::max(step.work, kMaxWork / 2);  // The rest is left to go to where less is as near.
  for (const std::uint16_t slot : step.scene->touchable()) {
    const SceneObject& object = step.scene->slot(slot);
    const double skin = step.skin(object);
    const Vec3 x = startIn(step, slot);
    least = std::max(least, kLeastBall * skinInTouch(step, object));
    const bool two_sided = (object.flags & HD_OBJECT_TWO_SIDED) != 0;
    const bool far = (object.toWorld(x) - object.center_W).norm() > object.radius;  // Surely outside.
    const double reach = about_[slot] && !far && !two_sided ? std::numeric_limits<double>::infinity() : room + skin;
    Nearest near;
    const std::uint32_t before = work;
    const NearestResult result = nearestWithin(object, x, reach, nullptr, work, near);
    step.work += work - before;
    if (result == NearestResult::kExhausted) return;
    if (result == NearestResult::kNone) continue;
    const double distance = std::sqrt(near.squared_distance);
    if (!two_sided && near.isInside(x)) {
      about[slot] = true;
    } else if (distance < room + skin) {
      const double free = std::max(0.0, distance - skin);  // But what is free as it is stays as it is.
      room = distance > radius_ + 0.5 * skin ? std::max(free, std::min(room, radius_)) : free;
    }
  }
  radius_ = room >= least ? room : 0;
  about_ = about;
}

}  // namespace hapticd
