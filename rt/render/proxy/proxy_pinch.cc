// A proxy between two that close on each other: it does not leave at their rims, at once and however far.
#include <algorithm>

#include "rt/render/proxy/proxy_step.h"

namespace hapticd {
namespace {

constexpr double kFacing = -0.6;   // Cosine of the normals of two that face each other.
constexpr double kMostPushed = 8;  // Times as far as what moves goes, it may push the proxy: a wedge of 7 degrees does,
constexpr double kPushedAtOnce = 3;  // but one below 19 not far beyond where the proxy already is.

}  // namespace

/** How far the object takes what is at the proxy in this tick, its vertices too [m]; negative: it is not there. */
double ProxyRenderer::wayOf(const Step& step, std::uint32_t slot) const HD_RT {
  const SceneObject& object = step.scene->slot(slot);
  const double way = (object.toWorld(start_[slot]) - object.X_WO_before * carried_[slot]).norm();
  const double reach = way + radius_ + kAt * step.skin(object);
  const bool there = object.shape.kind == ShapeKind::kPlane
                         ? start_[slot].z() <= reach
                         : (object.center_W - object.toWorld(start_[slot])).norm() <= object.radius + reach;
  return there ? way : -1;
}

/** Of the objects that are where the proxy is, not of those far away. Notes the places to which they carry it. */
ProxyRenderer::Pinch ProxyRenderer::pinchOf(const Step& step) HD_RT {
  double far = (proxy_ - step.goal).norm(), most = -1, least = kAnyLength, carrier = least, skin = 0;
  bool firm = false;
  std::uint32_t mover = 0, carrying = 0;
  for (const std::uint16_t slot : step.scene->touchable()) {
    const SceneObject& object = step.scene->slot(slot);
    const double way = wayOf(step, slot);
    carried_[slot] = start_[slot];
    if (way < 0) continue;
    far = std::max(far, (object.toWorld(start_[slot]) - step.goal).norm());
    most = std::max(most, way);
    skin = std::max(skin, step.skin(object));
    if (pinched_by_ != 0 ? object.id == pinched_by_ : slot == step.carrier) {
      carrier = way;
      carrying = slot;
    }
    if (object.loose ? firm || way >= least : firm && way >= least) continue;
    firm = firm || !object.loose;
    least = way;
    mover = slot;
  }
  Pinch pinch;
  pinch.from = proxy_;
  if (most < 0) return pinch;
  // From what holds it once to another it would leap by how far these are in each other.
  const bool stays = pinched_by_ != 0 ? carrying != 0 : carrier <= 2 * least;
  if (stays && !(firm && step.scene->slot(carrying).loose)) mover = carrying;
  pinch.by = mover;
  pinch.near = radius_ + most + kAt * skin;
  pinch.from = step.scene->slot(mover).toWorld(start_[mover]);
  pinch.most = far + std::min(kMostPushed * most, kPushedAtOnce * most + far / 2) + kAt * skin;
  return pinch;
}

/** Whether a body that moves freely closes on the place where a pinched proxy would stay. */
bool ProxyRenderer::isUnderBody(Step& step, const Pinch& pinch) const HD_RT {
  for (const std::uint16_t slot : step.scene->touchable()) {
    const SceneObject& object = step.scene->slot(slot);
    const double reach = object.radius + pinch.near;
    if (!object.loose || (object.center_W - pinch.from).squaredNorm() > reach * reach) continue;
    Nearest near;
    const Vec3 x = object.toLocal(pinch.from);
    if (nearestWithin(object, x, pinch.near, step.vicinity(slot), step.work, near) != NearestResult::kNone) return true;
  }
  return false;
}

/** Slot of that of two objects that face each other, the proxy between, which presses to `from`; 0: there are none. */
std::uint32_t ProxyRenderer::pressedOfTwo(const Step& step, const Vec3& from) const HD_RT {
  const Vec3 up = from - step.goal;
  for (int i = 0; i < step.count; ++i) {
    const Constraint& one = step.held[i];
    for (int j = 0; j < i; ++j) {
      const Constraint& other = step.held[j];
      if (one.slot == other.slot || one.surface.normal.dot(other.surface.normal) >= kFacing) continue;
      return one.surface.normal.dot(up) > other.surface.normal.dot(up) ? one.slot : other.slot;
    }
  }
  return 0;
}

/**
 * What moves takes the proxy along by its own way, and out of a groove that closes by some more. Farther, it stays
 * where it is relative to each object, on its side of all, held where it is by what moved least, until they part. But a
 * body that lies on it comes over it, and is felt once it has been left: nobody is to be held by what he could lift.
 */
void ProxyRenderer::leavePinch(Step& step, const Pinch& pinch) HD_RT {
  pinched_by_ = 0;
  const std::uint32_t pressed = step.together ? step.carrier : pressedOfTwo(step, pinch.from);
  if (step.together ? !((proxy_ - step.goal).norm() > pinch.most) : pressed == 0) return;
  step.count = 0;
  step.settled = step.supported = false;
  if (!isUnderBody(step, pinch)) {
    for (const std::uint16_t slot : step.scene->touchable()) start_[slot] = carried_[slot];
    proxy_ = pinch.from;
    step.together = false;
    step.met = pressed != 0 ? pressed : pinch.by;
    pinched_by_ = step.scene->slot(pinch.by).id;
    return;
  }
  // On what is pressed, if that is firm: what moves least may be something beside, and leave it in what rises.
  const std::uint32_t on = pressed != 0 && !step.scene->slot(pressed).loose ? pressed : pinch.by;
  const Vec3 from = step.scene->slot(on).toWorld(carried_[on]);
  arrive(step, from);
  step.plain = true;
  about_.set();
  settle(step);
  if (leadsAway(from, proxy_, step.goal)) (void)goBack(step, from, 0);
}

/** Where objects have moved: no farther than they take it along, and not to the rims of two that close on it. */
void ProxyRenderer::settleCarried(Step& step) HD_RT {
  const Pinch pinch = pinchOf(step);
  const std::uint32_t slot = step.carrier;
  const Vec3 from = slot != 0 ? step.scene->slot(slot).toWorld(start_[slot]) : Vec3::Zero();
  settle(step);
  if (slot != 0 && leadsAway(from, proxy_, step.goal)) settleAgain(step, from, slot);
  leavePinch(step, pinch);
}

}  // namespace hapticd
