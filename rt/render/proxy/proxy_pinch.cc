// A proxy between two that close on each other: it does not leave at their rims, at once and however far.
#include <algorithm>

#include "rt/render/proxy/proxy_step.h"

namespace hapticd {
namespace {

constexpr double kFacing = -0.6;   // Cosine of the normals of two that face each other.
constexpr double kMostPushed = 8;  // Times as far as what moves goes, it may push the proxy: a wedge of 7 degrees does,
constexpr double kPushedAtOnce = 3;  // but one below 19 not far beyond where the proxy already is.

}  // namespace

/** Notes where the proxy is relative to each object, carried along by it: before it settles. */
ProxyRenderer::Pinch ProxyRenderer::pinchOf(const Step& step) HD_RT {
  double far = (proxy_ - step.goal).norm(), most = 0, least = kAnyLength, skin = 0;
  bool firm = false;
  Pinch pinch;
  for (const std::uint16_t slot : step.scene->touchable()) {
    const SceneObject& object = step.scene->slot(slot);
    const Vec3 place = object.toWorld(start_[slot]);
    const double way = (place - object.X_WO_before * carried_[slot]).norm();  // With that of its vertices.
    carried_[slot] = start_[slot];
    far = std::max(far, (place - step.goal).norm());
    most = std::max(most, way);
    skin = std::max(skin, step.skin(object));
    const bool first = !object.loose && !firm;
    if (first || (firm != object.loose && (way < least || (slot == step.carrier && way <= 2 * least)))) {
      least = first ? way : std::min(least, way);
      pinch.from = place;
    }
    firm = firm || !object.loose;
  }
  pinch.most = far + std::min(kMostPushed * most, kPushedAtOnce * most + far / 2) + kAt * skin;
  return pinch;
}

/** Whether a body that moves freely is about the place where a pinched proxy would stay. */
bool ProxyRenderer::isUnderBody(const Step& step, const Vec3& from) const HD_RT {
  for (const std::uint16_t slot : step.scene->touchable()) {
    const SceneObject& object = step.scene->slot(slot);
    if (object.loose && (object.center_W - from).norm() < object.radius + radius_ + kAt * step.skin(object))
      return true;
  }
  return false;
}

/** Whether two objects that face each other hold the proxy. */
bool ProxyRenderer::isBetween(const Step& step) const HD_RT {
  for (int i = 0; i < step.count; ++i)
    for (int j = 0; j < i; ++j)
      if (step.held[i].slot != step.held[j].slot &&
          step.held[i].surface.normal.dot(step.held[j].surface.normal) < kFacing)
        return true;
  return false;
}

/**
 * What moves takes the proxy along by its own way, and out of a groove that closes by some more. Farther, it stays
 * where it is relative to each object, on its side of all, held where it is by what moves least; until they part. But a
 * body that lies on it comes over it, and is felt once it has been left: nobody is to be held by what he could lift.
 */
void ProxyRenderer::leavePinch(Step& step, const Pinch& pinch) HD_RT {
  if (step.together ? !((proxy_ - step.goal).norm() > pinch.most) : !isBetween(step)) return;
  step.count = 0;
  step.settled = step.supported = false;
  if (!isUnderBody(step, pinch.from)) {
    for (const std::uint16_t slot : step.scene->touchable()) start_[slot] = carried_[slot];
    proxy_ = pinch.from;
    step.together = false;
    return;
  }
  arrive(step, pinch.from);
  step.plain = true;
  crowded_ = true;
  settle(step);
  if (leadsAway(pinch.from, proxy_, step.goal)) (void)goBack(step, pinch.from, 0);
}

}  // namespace hapticd
