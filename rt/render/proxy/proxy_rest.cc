// What held the proxy when a tick ended holds it when the next begins: no sweep is needed to find it again.
#include "rt/render/proxy/proxy_step.h"

namespace hapticd {

/** Notes what holds the proxy, if it has come to its place. */
void ProxyRenderer::noteRest(const Step& step, std::uint32_t active) HD_RT {
  rest_.count = 0;
  if (!step.settled || !step.together || !(step.real || step.count == 1)) return;
  for (int i = 0; i < step.count; ++i) {
    if (!(active >> i & 1u)) continue;
    const SceneObject& object = step.scene->slot(step.held[i].slot);
    rest_.on[rest_.count++] = {step.held[i], object.id, object.flags, object.shape.number,
                               object.shape.mesh != nullptr ? object.shape.mesh->deform.moves : 0};
  }
  rest_.radius = radius_;
}

/**
 * Lets the same surfaces hold the proxy, if none has moved or changed, it is a skin above all of them and the goal is
 * below one: the sweeps to the goal would find them at once.
 */
bool ProxyRenderer::holdAgain(Step& step) HD_RT {
  if (rest_.count == 0 || !step.together || rest_.radius != radius_) return false;
  bool pressed = false;
  for (int i = 0; i < rest_.count; ++i) {
    const Rest::Surface& on = rest_.on[i];
    const SceneObject& object = step.scene->slot(on.held.slot);
    if (object.id != on.id || object.flags != on.flags || object.shape.number != on.number ||
        (object.shape.mesh != nullptr && object.shape.mesh->deform.moves != on.moves)) {
      return false;
    }
    Constraint& c = step.held[i];
    c = on.held;
    c.skin = step.skin(object);
    const double height = c.surface.height(proxy_);
    if (!(height > 0.5 * c.skin && height < 1.5 * c.skin)) return false;
    pressed = pressed || c.surface.height(step.goal) < -c.skin;
  }
  if (!pressed) return false;
  step.count = rest_.count;
  step.real = true;
  rest_.count = 0;  // Once.
  return true;
}

}  // namespace hapticd
