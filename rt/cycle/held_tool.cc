#include "rt/cycle/held_tool.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <initializer_list>

namespace hapticd {
namespace {

bool finiteAndNotNegative(std::initializer_list<double> values) HD_RT {
  for (const double x : values) {
    if (!(x >= 0 && x < 1e9)) return false;
  }
  return true;
}

constexpr double kOn = 1e-5, kOff = 1e-4;  ///< Gaps at which a contact begins and ends [m].

/** Whether a slot is below another in the tree. */
bool isPartOf(const Scene& scene, std::uint32_t slot, std::uint32_t of) HD_RT {
  for (std::uint32_t depth = 0; slot != 0 && depth < kMaxObjects; ++depth) {
    if (slot == of) return true;
    slot = scene.slot(slot).parent;
  }
  return false;
}

bool near(double distance_squared, double reach) HD_RT { return distance_squared <= reach * reach; }

}  // namespace

ErrorCode HeldTool::attach(const AttachTool& order, const Scene& scene) HD_RT {
  const SceneObject* object = scene.find(order.object);
  if (object == nullptr) return ErrorCode::kNotFound;
  if (object->parent != 0 || object->shape.kind == ShapeKind::kGroup || object->shape.kind == ShapeKind::kPlane) {
    return ErrorCode::kInvalidArgument;
  }
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
  age_ = 0;
  touched_ = 0;
  started_ = false;
  return ErrorCode::kOk;
}

ErrorCode HeldTool::take(const ToolContacts& contacts) HD_RT {
  if (contacts.count > ToolContacts::kMost) return ErrorCode::kInvalidArgument;
  for (std::uint32_t i = 0; i < contacts.count; ++i) {
    const ToolContacts::Point& p = contacts.point[i];
    double squared = 0;
    for (int k = 0; k < 3; ++k) {
      squared += double(p.n_B[k]) * double(p.n_B[k]);
      if (!(std::abs(p.p_A[k]) < 1e3F)) return ErrorCode::kInvalidArgument;
    }
    if (!(squared > 0.9 && squared < 1.1) || !(std::abs(p.offset) < 1e4F)) return ErrorCode::kInvalidArgument;
  }
  if (contacts.object != order_.object || order_.object == 0) return ErrorCode::kOk;
  static_assert(sizeof contacts.point == sizeof model_.point);
  std::memcpy(model_.point.data(), contacts.point, sizeof contacts.point);
  model_.count = contacts.count;
  age_ = 0;
  return ErrorCode::kOk;
}

std::uint32_t HeldTool::gather(const Scene& scene, std::span<Touch> touches) const HD_RT {
  std::uint32_t n = 0;
  const Pose X_WA = tool_.body().pose();
  for (std::uint32_t i = 0; i < model_.count; ++i) {
    const SceneObject& object = scene.slot(model_.point[i].body());
    if (object.id == 0 || (object.flags & HD_OBJECT_ENABLED) == 0) continue;
    Touch& touch = touches[n++];
    touch = model_.touch(i, X_WA, tool_.body().com(), object.X_WO, object.V_WO);
    touch.friction = object.material.friction_static;
  }
  return n;
}

void HeldTool::step(Scene& scene, const DeviceSample& sample, const Twist& velocity, double dt,
                    HeldToolOutput& out) HD_RT {
  out = HeldToolOutput{};
  if (scene.find(order_.object) == nullptr) {
    detach();
    return;
  }
  const Pose device{sample.p, sample.q.normalized()};
  if (!started_) {
    tool_.reset(device);
    model_.count = 0;
    started_ = true;
  }
  age_ += dt;
  std::array<Touch, kMaxTouches> touches;
  const std::uint32_t n = gather(scene, touches);
  tool_.step(device, {touches.data(), n}, dt, response_, step_);
  out.weight = std::clamp(1 - (age_ - kStale) / kFade, 0.0, 1.0);
  out.wrench.force = out.weight * step_.on_device.force;
  if (order_.shows_torque != 0) out.wrench.torque = out.weight * step_.on_device.torque;
  // Energy that does not come through the force: obstacles that move, and the wrist, shared among the axes.
  const double wrist = -step_.on_device.torque.dot(velocity.w);
  out.carried = step_.obstacle_work / dt + Vec3::Constant(wrist / 3);
  out.stored = tool_.energy() + tool_.reserve();

  noteTouch(scene, {touches.data(), n}, out);

  Command move;
  move.kind = CommandKind::kObjectPose;
  move.session = 0;  // as if a client moved it: so control and the other groups learn where it is (PoseBoard)
  auto& pose = move.as<hd_object_pose>();
  pose.object = order_.object;
  const Pose X = tool_.body().pose();
  store(X.p, pose.p);
  store(X.q, pose.q);
  store(tool_.body().twist().v - tool_.body().twist().w.cross(tool_.body().com() - X.p), pose.v);
  store(tool_.body().twist().w, pose.w);
  (void)scene.apply(move);
}

void HeldTool::noteTouch(const Scene& scene, std::span<const Touch> touches, HeldToolOutput& out) HD_RT {
  // What touched goes on touching until it is clearly off: a tool at rest is no series of touches.
  const double off = touched_ != 0 ? kOff : kOn;
  double nearest = off;
  for (const Touch& touch : touches) {
    if (touch.gap >= nearest) continue;
    nearest = touch.gap;
    out.touched = scene.slot(static_cast<std::uint32_t>(touch.key >> 24)).id;
    out.point = tool_.body().com() + touch.r_a;
    out.normal = touch.n;
  }
  out.touch = out.touched != 0 && touched_ == 0;
  out.untouch = out.touched == 0 && touched_ != 0;
  out.left = out.untouch ? touched_ : 0;
  touched_ = out.touched;
}

void HeldTool::ask(const Scene& scene, CollideRequest::Held& held) const HD_RT {
  held.object = 0;
  held.count = 0;
  const SceneObject* self = scene.find(order_.object);
  if (self == nullptr || !started_) return;
  held.object = order_.object;
  held.shape = self->shape;
  held.X_WO = tool_.body().pose();
  const Twist& V = tool_.body().twist();
  held.speed = V.v.norm() + V.w.norm() * self->radius;
  const Vec3 center = self->center_W + (held.X_WO.p - self->X_WO.p);
  double fastest = 0;
  for (const std::uint16_t slot : scene.touchable()) {
    const SceneObject& object = scene.slot(slot);
    if (held.count == CollideRequest::kMostObstacles) break;
    if (isPartOf(scene, slot, objectSlot(order_.object))) continue;
    const double reach = object.radius + self->radius + 0.02 + 0.01 * held.speed;
    const bool endless = !std::isfinite(object.radius);  // a plane
    if (!endless && !near((object.center_W - center).squaredNorm(), reach)) continue;
    CollideRequest::Obstacle& out = held.obstacle[held.count++];
    out.slot = slot;
    out.shape = object.shape;
    out.X_WO = object.X_WO;
    fastest = std::max(fastest, object.velocityAt(center).norm() + object.V_WO.w.norm() * self->radius);
  }
  held.speed += fastest;
}

}  // namespace hapticd
