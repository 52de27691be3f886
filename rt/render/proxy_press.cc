// What the surfaces that hold the proxy do to the hand: each with the material and the motion of its object.
#include "rt/render/press.h"
#include "rt/render/proxy_step.h"

namespace hapticd {

namespace {

constexpr double kUnmoved = 4;  ///< Hairs.

/** What of x, a sum of the normals, falls to each; none negative. */
void shareOut(const HoldingSurface* held, int count, const Vec3& x, double* of) HD_RT {
  const Vec3 &one = held[0].normal, &other = held[1].normal;
  const Vec3 third = count == 3 ? held[2].normal : one.cross(other);
  const Vec3 part = x / one.cross(other).dot(third);  // Of planes that nearestOnPlanes() has told apart.
  of[0] = std::max(0.0, part.dot(other.cross(third)));
  of[1] = std::max(0.0, part.dot(third.cross(one)));
  if (count == 3) of[2] = std::max(0.0, part.dot(one.cross(other)));
}

}  // namespace

/** The active surfaces, and how they share in `up`, from hip to foot. */
int ProxyRenderer::holders(const Step& step, std::uint32_t active, const Vec3& up, HoldingSurface* out) const HD_RT {
  int count = 0;
  for (int i = 0; i < step.count && count < kMaxHolding; ++i) {
    if (!(active >> i & 1u)) continue;
    const Constraint& c = step.held[i];
    out[count++] = {step.scene->slot(c.slot).id, c.feature, c.kind, c.corner, c.surface.normal,
                    up.dot(c.surface.normal)};
  }
  if (count < 2) return count;
  double push[kMaxHolding];
  shareOut(out, count, up, push);
  for (int i = 0; i < count; ++i) out[i].push = push[i];
  return count;
}

/** Tells which surfaces hold the proxy, if any of them is shaded or rings. */
void ProxyRenderer::noteHolding(const Step& step, std::uint32_t active, const Vec3& up) HD_RT {
  bool asked = false;
  for (int i = 0; i < step.count; ++i) {
    const SurfaceParameters& surface = step.scene->slot(step.held[i].slot).surface.parameters;
    asked = asked || surface.smooth_cosine > 0 || surface.transient_gain > 0;
  }
  if (asked) holding_count_ = holders(step, active, up, holding_.data());
}

/** Notes the active surfaces, of several objects; `at` is the proxy. */
void ProxyRenderer::noteBeside(const Step& step, std::uint32_t active, const Vec3& at) HD_RT {
  beside_.count = 0;
  for (int i = 0; i < step.count && beside_.count < kMaxHolding; ++i) {
    if (!(active >> i & 1u)) continue;
    const Constraint& c = step.held[i];
    const SceneObject& object = step.scene->slot(c.slot);
    Beside::Surface& on = beside_.on[beside_.count++];
    on.held = c;
    on.id = object.id;
    on.number = object.shape.number;
    on.moves = object.shape.mesh != nullptr ? object.shape.mesh->deform.moves : 0;
    on.plane.normal = rotated(object.X_WO.q.conjugate(), c.surface.normal);
    on.plane.offset = c.surface.offset - c.surface.normal.dot(object.X_WO.p);
    on.proxy = toLocal(object.X_WO, at);
  }
}

/**
 * Which surfaces press. A proxy that lies on a floor and sticks to a wall needs no floor to stay there; the hand, deep
 * in both, does: how hard the floor is must not hang on whether friction on the wall would do. So what held the proxy
 * beside others holds on while the proxy has not moved on it and the hand is behind it. `foot` becomes that of them
 * all.
 */
std::uint32_t ProxyRenderer::holdBeside(Step& step, const Support& support, Vec3& foot) HD_RT {
  if (beside_.count == 0 || support.active == 0) return support.active;
  const int before = step.count;
  double rounding = 0;
  int kept = 0;
  for (int i = 0; i < beside_.count; ++i) {
    Beside::Surface on = beside_.on[i];
    const SceneObject& object = step.scene->slot(on.held.slot);
    const double skin = step.skin(object);
    rounding = std::max(rounding, kNear * skin);
    const bool same = object.id == on.id && (object.flags & HD_OBJECT_ENABLED) && object.shape.number == on.number &&
                      (object.shape.mesh == nullptr || object.shape.mesh->deform.moves == on.moves);
    if (!same || !((toLocal(object.X_WO, support.at) - on.proxy).norm() <= kUnmoved * skin)) continue;
    beside_.on[kept++] = on;
    on.held.surface.normal = rotated(object.X_WO.q, on.plane.normal);
    on.held.surface.offset = on.plane.offset + on.held.surface.normal.dot(object.X_WO.p);
    bool holds = false;
    for (int k = 0; k < before; ++k) {
      const bool active = support.active >> k & 1u;
      holds = holds || (active && step.held[k].slot == on.held.slot);
    }
    if (!holds && step.count < kMaxHalfSpaces && on.held.surface.height(step.goal) < 0)
      step.held[step.count++] = on.held;
  }
  beside_.count = kept;
  if (step.count == before) return support.active;
  HalfSpace planes[kMaxHalfSpaces];
  int slot_of[kMaxHalfSpaces];
  int count = 0;
  for (int i = 0; i < step.count; ++i) {
    if (i < before && !(support.active >> i & 1u)) continue;
    slot_of[count] = i;
    planes[count++] = step.held[i].surface;
  }
  Vec3 of_all = step.goal;
  std::uint32_t mask = 0, active = 0;
  if (!nearestInside(planes, count, rounding, of_all, mask) || mask == 0) return support.active;
  for (int i = 0; i < count; ++i) active |= (mask >> i & 1u) << slot_of[i];
  foot = of_all;
  return active;
}

/**
 * What presses on a hand whose proxy is held by the active surfaces, `up` above it, with their point of contact at x.
 * One object presses with its own material. Of several each presses with its own (press()), and damps and carries by
 * its push; then `contact`, which knows its proxy, is told each one's part.
 */
ProxyRenderer::Press ProxyRenderer::pressOf(const Step& step, const SceneObject& object, std::uint32_t feature,
                                            std::uint32_t active, const Vec3& up, const Vec3& x,
                                            SurfaceContact* contact) const HD_RT {
  const double depth = up.norm();
  Press all;
  if (depth > 0) all.normal = up / depth;
  all.stiffness = all.stored = object.material.stiffness;
  all.damping = object.material.damping;
  all.velocity = step.scene->velocityAt(object, feature, x);
  bool alone = true;
  for (int i = 0; i < step.count; ++i)
    alone = alone && (!(active >> i & 1u) || step.scene->slot(step.held[i].slot).id == object.id);
  if (alone) [[likely]]
    return all;

  HoldingSurface held[kMaxHolding];
  const int count = holders(step, active, up, held);
  Pressing part[kMaxPressing];
  Vec3 velocity[kMaxPressing];
  double pushes = 0, damping = 0;
  Vec3 mean = Vec3::Zero();
  bool alike = true;
  for (int i = 0; i < count; ++i) {
    const SceneObject& other = *step.scene->find(held[i].object);
    part[i] = {held[i].normal, held[i].push, other.material.stiffness};
    velocity[i] = step.scene->velocityAt(other, held[i].feature, x);
    pushes += held[i].push;
    damping += held[i].push * other.material.damping;
    mean += held[i].push * velocity[i];
    alike = alike && part[i].stiffness == all.stiffness && other.material.damping == all.damping &&
            velocity[i] == all.velocity;
  }
  if (count < 2 || !(pushes > 0)) return all;
  const Vec3 force = press({part, static_cast<std::size_t>(count)}, up);
  double newtons[kMaxHolding];
  shareOut(held, count, force, newtons);
  for (int i = 0; contact && i < count; ++i)
    contact->part[contact->parts++] = {held[i].object, contact->proxy - radius_ * held[i].normal,
                                       newtons[i] * held[i].normal, held[i].push / pushes};
  const double sum = force.norm();
  if (alike || !(sum > 0)) return all;
  all.normal = force / sum;
  all.turned = depth * all.normal - up;
  all.stiffness = sum / depth;
  all.stored = force.dot(up) / (depth * depth);
  all.damping = damping / pushes;
  all.velocity = mean / pushes;
  for (int i = 0; i < count; ++i) all.apart += newtons[i] * held[i].normal.cwiseProduct(velocity[i] - all.velocity);
  return all;
}

}  // namespace hapticd
