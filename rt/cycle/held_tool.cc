#include "rt/cycle/held_tool.h"

#include <algorithm>
#include <cstring>
#include <initializer_list>

#include "rt/body/direct.h"
#include "rt/collide/round.h"

namespace hapticd {
namespace {

bool finiteAndNotNegative(std::initializer_list<double> values) HD_RT {
  for (const double x : values) {
    if (!(x >= 0 && x < 1e9)) return false;
  }
  return true;
}

constexpr double kOn = 1e-5, kOff = 1e-4;  ///< Gaps at which a contact begins and ends [m].

/** The object that it is part of, below the root. */
std::uint32_t wholeOf(const Scene& scene, std::uint32_t slot) HD_RT {
  while (scene.slot(slot).parent != 0) slot = scene.slot(slot).parent;
  return scene.slot(slot).id;
}

}  // namespace

ErrorCode HeldTool::attach(const AttachTool& order, const Scene& scene) HD_RT {
  const SceneObject* object = scene.find(order.object);
  if (object == nullptr) return ErrorCode::kNotFound;
  if (!canMove(*object)) return ErrorCode::kInvalidArgument;
  ToolSetup setup;
  setup.mass.mass = order.mass;
  setup.mass.com_O = vec3(order.com);
  const double(&i)[6] = order.inertia;
  setup.mass.inertia_O << i[0], i[3], i[4], i[3], i[1], i[5], i[4], i[5], i[2];
  setup.gains = {order.outer,         order.stiffness,         order.damping,
                 order.angular_outer, order.angular_stiffness, order.angular_damping};
  if (!setup.mass.valid() ||
      !finiteAndNotNegative({order.mass, order.outer, order.stiffness, order.damping, order.angular_outer,
                             order.angular_stiffness, order.angular_damping})) {
    return ErrorCode::kInvalidArgument;
  }
  order_ = order;
  tool_ = Tool(setup);
  response_.reset();
  model_.count = 0;
  step_ = ToolStep{};
  touched_ = 0;
  forget();  // An answer may be on its way of where the same object was held before.
  return ErrorCode::kOk;
}

ErrorCode HeldTool::take(const ToolContacts& contacts) HD_RT {
  if (!valid(contacts)) return ErrorCode::kInvalidArgument;
  if (contacts.object != order_.object || order_.object == 0) return ErrorCode::kOk;
  if (!started_ || contacts.tick < arrived_) return ErrorCode::kOk;
  static_assert(sizeof contacts.point == sizeof model_.point);
  std::memcpy(model_.point.data(), contacts.point, sizeof contacts.point);
  model_.count = contacts.count;
  asked_ = contacts.tick;
  return ErrorCode::kOk;
}

double HeldTool::stiffness() const HD_RT {
  const double sum = order_.outer + order_.stiffness;
  return sum > 0 ? order_.outer * order_.stiffness / sum : 0;
}

void HeldTool::gather(const Scene& scene, const FreeBodies& bodies) HD_RT {
  touches_ = 0;
  const SceneObject& self = scene.slot(objectSlot(order_.object));
  const Pose X_WA = tool_.body().pose();
  const Vec3& com = tool_.body().com();
  for (std::uint32_t i = 0; i < model_.count; ++i) {
    const std::uint32_t slot = model_.point[i].body();
    const SceneObject& object = scene.slot(slot);
    if (!isFelt(object)) continue;
    const std::uint8_t body = bodies.find(slot);
    // What moves passes what is not felt, and that passes it.
    if (!isFelt(self) && (body != FreeBodies::kNone || bodies.isInHand(wholeOf(scene, slot)))) continue;
    // Skip contacts with what has been replaced or has jumped: by its whole leap deep, they would hit the hand.
    if (asked_ < bodies.arrivedIn(scene, slot)) continue;
    body_of_[touches_] = body;
    Touch& touch = touch_[touches_++];
    const std::uint32_t feature = model_.point[i].feature();
    const bool loose = body != FreeBodies::kNone;
    const Pose there = loose ? bodies.poseOf(scene, body, slot) : object.X_WO;
    const Twist V = loose ? bodies.motionWithin(scene, body, slot) : object.V_WO;
    touch = model_.touch(i, X_WA, com, there, V);
    rollTo({self.shape, X_WA}, feature, {object.shape, there}, com, V.w, touch);
    if (loose) touch.r_b = com + touch.r_a - bodies.body(body).body.com();
    touch.friction = object.material.friction_static;
  }
  yieldTo(scene);
}

/** What is softer than the coupling gives way, so that in the end the hand feels the object's own stiffness. */
void HeldTool::yieldTo(const Scene& scene) HD_RT {
  const double stiffness_end = stiffness();
  if (!(stiffness_end > 0)) return;
  for (std::uint32_t i = 0; i < touches_; ++i) {
    const auto slot = static_cast<std::uint32_t>(touch_[i].key >> 24);
    const double give = 1 / scene.slot(slot).material.stiffness - 1 / stiffness_end;
    if (!(give > 0)) continue;
    // Contacts that overlap one object share its stiffness, so that a face is no stiffer than a corner.
    const auto overlap = [&](const Touch& t) HD_RT { return t.gap < 0 && t.key >> 24 == slot; };
    const auto sharing = std::count_if(touch_.begin(), touch_.begin() + touches_, overlap);
    touch_[i].give = give * static_cast<double>(std::max<std::ptrdiff_t>(1, sharing));
  }
}

/** Direct: the tool is where the device is; a spring as stiff as the softer of device and object. */
void HeldTool::render(const Twist& velocity, const Pose& device, double dt, FreeBodies& bodies) HD_RT {
  const Vec3 arm = tool_.body().com() - device.p;
  const Twist V{velocity.v + velocity.w.cross(arm), velocity.w};
  tool_.setTwist(V);
  step_ = ToolStep{};
  stored_ = 0;
  double pushing = 0;
  for (std::uint32_t i = 0; i < touches_; ++i) pushing += touch_[i].gap < 0 ? 1 : 0;
  for (std::uint32_t i = 0; i < touches_; ++i) {
    const Touch& touch = touch_[i];
    if (!(touch.gap < 0)) continue;
    const double k = 1 / (1 / stiffness() + touch.give / pushing);
    const Vec3 force = directWrench({&touch, 1}, V, Twist{}, {k / pushing, 0}).force;
    const Vec3 torque = touch.r_a.cross(force);
    step_.contact.force += force;
    step_.contact.torque += torque;
    step_.on_device.force += force;
    step_.on_device.torque += torque + arm.cross(force);
    const Vec3 at = tool_.body().com() + touch.r_a;
    const std::uint8_t body = body_of_[i];
    const Vec3 carried = body != FreeBodies::kNone ? bodies.velocityAt(body, at) : Vec3(Vec3::Zero());
    step_.obstacle_work += dt * force.cwiseProduct(carried + touch.moving);
    stored_ += 0.5 * k / pushing * touch.gap * touch.gap;
    ++step_.touching;
    if (body != FreeBodies::kNone) bodies.push(body, -dt * force, at);
  }
}

void HeldTool::begin(const Scene& scene, const DeviceSample& sample, const Twist& velocity, double dt,
                     FreeBodies& bodies) HD_RT {
  if (scene.find(order_.object) == nullptr) {
    detach();
    return;
  }
  const bool direct = (order_.flags & kToolDirect) != 0;
  const Pose device{sample.p, sample.q.normalized()};
  if (!started_ || direct) tool_.reset(device);
  if (!started_) {
    model_.count = 0;
    arrived_ = asked_ = scene.tick();
    weight_ = 1;  // Nothing is stretched.
    taken_ = true;
  }
  started_ = true;
  age_ = dt * static_cast<double>(scene.tick() - asked_);
  com_ = tool_.body().com();
  const bool weighs = (order_.flags & kToolWeighs) != 0;
  tool_.setWeight(weighs ? Vec3(order_.mass * bodies.gravity()) : Vec3(Vec3::Zero()));
  gather(scene, bodies);
  if (direct) {
    render(velocity, device, dt, bodies);
    step_.on_device.force += tool_.setup().weight;
    step_.on_device.torque += (com_ - device.p).cross(tool_.setup().weight);
    return;
  }
  const bool pushes = std::any_of(body_of_.begin(), body_of_.begin() + touches_,
                                  [](std::uint8_t body) { return body != FreeBodies::kNone; });
  if (pushes) {
    response_.reset();
    const std::uint8_t self = bodies.join(tool_, device, step_);
    for (std::uint32_t i = 0; i < touches_; ++i) bodies.touch(touch_[i], self, body_of_[i]);
  } else {
    tool_.step(device, {touch_.data(), touches_}, dt, response_, step_);
  }
}

void HeldTool::finish(Scene& scene, const Twist& velocity, double dt, HeldToolOutput& out) HD_RT {
  out = HeldToolOutput{};
  if (!held()) return;
  // It comes back no faster than it goes: meanwhile the coupling has been stretched under the hand.
  const double former = weight_;
  weight_ = std::min(std::clamp(1 - (age_ - kStale) / kFade, 0.0, 1.0), weight_ + dt / kFade);
  const double rose = std::max(0.0, weight_ - former);
  out.weight = weight_;
  out.wrench.force = out.weight * step_.on_device.force;
  if (order_.shows_torque != 0) out.wrench.torque = out.weight * step_.on_device.torque;
  // Power beyond force times velocity: from moving obstacles, the weight, and the wrist's torque, split by axis.
  const bool direct = (order_.flags & kToolDirect) != 0;
  const double wrist = -step_.on_device.torque.dot(velocity.w);
  const Vec3 moved = direct ? Vec3(dt * tool_.body().twist().v) : Vec3(tool_.body().com() - com_);
  out.carried = (step_.obstacle_work + tool_.setup().weight.cwiseProduct(moved)) / dt + Vec3::Constant(wrist / 3);
  out.stored = direct ? stored_ : tool_.energy() + tool_.reserve();
  if (weight_ < 1 || rose > 0) {  // As Cycle::weighClutch().
    out.carried = weight_ * out.carried + byAxis(rose * std::max(0.0, out.stored) / dt, step_.on_device.force);
    out.stored *= weight_;
  }
  noteTouch(scene, out);

  // No hand has carried it there, nor pushed with it what it touched where it lay.
  const SceneObject& object = scene.slot(objectSlot(order_.object));
  const Pose X = tool_.body().pose();
  const double step = (X.p - object.X_WO.p).norm() + X.q.angularDistance(object.X_WO.q) * object.radius;
  if (taken_ && step > Scene::kUnmetStep) scene.leaps(objectSlot(order_.object));
  taken_ = false;
  const auto place = poseMessage(order_.object, tool_.body().pose(), tool_.body().originTwist());
  (void)scene.apply(makeCommand(CommandKind::kObjectPose, place, kCycleSession));
}

void HeldTool::noteTouch(const Scene& scene, HeldToolOutput& out) HD_RT {
  // Hysteresis: a touch ends only when the tool is clearly off, or a tool at rest would touch again and again.
  const double off = touched_ != 0 ? kOff : kOn;
  double nearest = off;
  for (std::uint32_t i = 0; i < touches_; ++i) {
    const Touch& touch = touch_[i];
    if (touch.gap >= nearest) continue;
    nearest = touch.gap;
    out.touched = scene.slot(static_cast<std::uint32_t>(touch.key >> 24)).id;
    out.point = tool_.body().com() + touch.r_a;
    out.normal = touch.n;
  }
  out.touch = out.touched != 0 && touched_ == 0;
  touched_ = out.touched;
}

void HeldTool::ask(const Scene& scene, const FreeBodies& bodies, CollideRequest::Held& held) const HD_RT {
  held.object = 0;
  held.count = 0;
  const SceneObject* self = scene.find(order_.object);
  if (self == nullptr || !started_) return;
  held.object = order_.object;
  held.shape = self->shape;
  held.X_WO = tool_.body().pose();
  held.V_WO = tool_.body().originTwist();
  held.speed = speedBound(tool_.body(), *self);
  held.arrived = arrived_;
  findObstacles(scene, *self, {}, held);
  for (std::uint32_t i = 0; i < held.count; ++i) {
    held.obstacle[i].arrived = bodies.arrivedIn(scene, held.obstacle[i].slot);
  }
}

}  // namespace hapticd
