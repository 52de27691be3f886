#include "rt/cycle/free_bodies.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "rt/collide/feature.h"
#include "rt/collide/round.h"
#include "rt/cycle/obstacles.h"

namespace hapticd {
namespace {

constexpr std::uint64_t kTagShift = 40;  ///< Keys of contacts are told apart by who found them.

MassProperties massOf(const SetBody& order) HD_RT {
  MassProperties out;
  out.mass = order.mass;
  out.com_O = vec3(order.com);
  const double(&i)[6] = order.inertia;
  out.inertia_O << i[0], i[3], i[4], i[3], i[1], i[5], i[4], i[5], i[2];
  return out;
}

}  // namespace

bool valid(const ToolContacts& contacts) HD_RT {
  if (contacts.count > ToolContacts::kMost) return false;
  for (std::uint32_t i = 0; i < contacts.count; ++i) {
    const ToolContacts::Point& p = contacts.point[i];
    double squared = 0;
    for (int k = 0; k < 3; ++k) {
      squared += double(p.n_B[k]) * double(p.n_B[k]);
      if (!(std::abs(p.p_A[k]) < 1e3F)) return false;
    }
    if (!(squared > 0.9 && squared < 1.1) || !(std::abs(p.offset) < 1e4F)) return false;
  }
  return true;
}

bool canMove(const SceneObject& object) HD_RT {
  return object.parent == 0 && object.shape.kind != ShapeKind::kGroup && object.shape.kind != ShapeKind::kPlane;
}

FreeBodies::Entry* FreeBodies::lookUp(std::uint32_t object) HD_RT {
  for (Entry& entry : entry_) {
    if (object != 0 && entry.object == object) return &entry;
  }
  return nullptr;
}

ErrorCode FreeBodies::set(const SetBody& order, Scene& scene) HD_RT {
  const SceneObject* object = scene.find(order.object);
  if (object == nullptr) return ErrorCode::kNotFound;
  Entry* entry = lookUp(order.object);
  if (order.mass == 0) {
    if (entry != nullptr) {
      leave(scene, *entry);
    }
    return ErrorCode::kOk;
  }
  const MassProperties mass = massOf(order);
  if (!canMove(*object) || !mass.valid() || !(order.damping >= 0 && order.damping < 1e6)) {
    return ErrorCode::kInvalidArgument;
  }
  Twist V_before;
  Vec3 com_before = Vec3::Zero();
  const bool was_body = entry != nullptr;
  if (was_body) {
    V_before = entry->body.body.twist();
    com_before = entry->body.body.com();
  } else {
    for (Entry& e : entry_) {  // those whose objects have gone since the last tick make room
      if (e.object == 0 || scene.find(e.object) == nullptr) {
        entry = &e;
        break;
      }
    }
    if (entry == nullptr) return ErrorCode::kQuotaExceeded;
    entry->object = order.object;
    entry->model.count = 0;
    entry->age = kStale;  // it stands until it is known what it touches
    entry->told = entry->held = entry->ours = entry->stands = false;
    leadAnew(*entry);
    entry->arrived = scene.arrivedIn(objectSlot(order.object));
    entry->asked = 0;
  }
  entry->body = FreeBody(mass, order.damping, order.falls != 0);
  entry->body.body.place(object->X_PO);
  if (was_body) V_before = {hapticd::velocityAt(V_before, entry->body.body.com() - com_before), V_before.w};
  entry->body.body.setTwist(V_before);
  return ErrorCode::kOk;
}

ErrorCode FreeBodies::setGravity(const SetGravity& order) HD_RT {
  const Vec3 g = vec3(order.g);
  if (!isFinite(g) || !(g.norm() <= kMostGravity)) return ErrorCode::kInvalidArgument;
  gravity_ = g;
  for (Entry& entry : entry_) entry.body.wake();
  return ErrorCode::kOk;
}

ErrorCode FreeBodies::take(const ToolContacts& contacts) HD_RT {
  if (contacts.device < kMaxDevices || contacts.device >= kMaxDevices + kMaxBodies || !valid(contacts)) {
    return ErrorCode::kInvalidArgument;
  }
  Entry& entry = entry_[contacts.device - kMaxDevices];
  if (contacts.object == 0 || contacts.object != entry.object) return ErrorCode::kOk;
  if (entry.held || contacts.tick < entry.arrived) return ErrorCode::kOk;
  static_assert(sizeof contacts.point == sizeof entry.model.point);
  std::memcpy(entry.model.point.data(), contacts.point, sizeof contacts.point);
  entry.model.count = contacts.count;
  entry.asked = contacts.tick;
  entry.told = true;
  return ErrorCode::kOk;
}

void FreeBodies::moved(const hd_object_pose& pose, bool by_control, std::uint64_t tick) HD_RT {
  Entry* entry = lookUp(pose.object);
  if (entry == nullptr) return;
  RigidBody& body = entry->body.body;
  const Pose X{vec3(pose.p), quat(pose.q).normalized()};
  const bool elsewhere = (X.p - body.pose().p).norm() > 0.01 || X.q.angularDistance(body.orientation()) > 0.1;
  body.place(X);
  const Vec3 w = vec3(pose.w);
  body.setTwist({vec3(pose.v) + w.cross(body.com() - X.p), w});
  if (elsewhere) {
    entry->model.count = 0;
    entry->arrived = tick;
  }
  if (elsewhere || !by_control) leadAnew(*entry);
  entry->body.wake();
  entry->stands = false;
  if (by_control) entry->ours = false;
}

/** It is no body any more, and stays where it is. Where a hand has it, or had it a tick ago, that is the hand's to say.
 */
void FreeBodies::leave(Scene& scene, Entry& entry) HD_RT {
  if (!entry.held) {
    place(scene, entry, Twist{});
  } else if (const SceneObject* const object = scene.find(entry.object)) {
    (void)scene.apply(makeCommand(CommandKind::kObjectPose, poseMessage(entry.object, object->X_PO), kCycleSession));
  }
  entry.object = 0;
}

void FreeBodies::begin(Scene& scene, double dt, std::span<const std::uint32_t> held) HD_RT {
  joint_.begin(dt, gravity_);
  of_slot_ = none();
  hands_ = std::min(held.size(), in_hands_.size());
  std::copy_n(held.begin(), hands_, in_hands_.begin());
  for (std::uint8_t k = 0; k < kMaxBodies; ++k) {
    Entry& entry = entry_[k];
    entry.mover = kNone;
    entry.pushed = entry.swept = false;
    if (entry.object == 0) continue;
    const SceneObject* object = scene.find(entry.object);
    if (object == nullptr || !canMove(*object)) {
      leave(scene, entry);
      continue;
    }
    const bool was_held = entry.held;
    entry.held = std::find(held.begin(), held.end(), entry.object) != held.end();
    if (entry.held) continue;
    if (was_held) {  // let go: it flies on as the hand moved it
      RigidBody& body = entry.body.body;
      body.place(object->X_WO);
      body.setTwist({object->velocityAt(body.com()), object->V_WO.w});
      entry.model.count = 0;
      entry.told = false;
      entry.ours = true;
      leadAnew(entry);
      entry.body.wake();
    }
    // Until it is told it stands: what moves it is others, in the tick in which it became a body or was in a hand.
    if (!entry.told) entry.arrived = std::max(entry.arrived, scene.arrivedIn(objectSlot(entry.object)));
    entry.age = entry.told ? dt * static_cast<double>(scene.tick() - entry.asked) : kStale;
    entry.before = entry.body.body.twist();
    of_slot_[objectSlot(entry.object)] = k;
  }
  for (const std::uint16_t slot : scene.used()) {  // Parents first.
    if (const std::uint32_t parent = scene.slot(slot).parent; parent != 0) of_slot_[slot] = of_slot_[parent];
    scene.setLoose(slot, of_slot_[slot] != kNone);
  }
}

Pose FreeBodies::poseOf(const Scene& scene, std::uint8_t k, std::uint32_t slot) const HD_RT {
  const Pose X_WB = entry_[k].body.body.pose();
  const std::uint32_t own = objectSlot(entry_[k].object);
  return slot == own ? X_WB : X_WB * (scene.slot(own).X_WO.inverse() * scene.slot(slot).X_WO);
}

std::uint8_t FreeBodies::moverOf(std::uint8_t k) HD_RT {
  if (k == kNone) return JointStep::kFixed;
  Entry& entry = entry_[k];
  if (entry.body.asleep() || entry.age >= kStale) return JointStep::kFixed;
  if (entry.mover == kNone) entry.mover = joint_.add(entry.body);
  return entry.mover;
}

void FreeBodies::touch(const Touch& touch, std::uint8_t tool, std::uint8_t body) HD_RT {
  if (body != kNone && touch.gap < kTouching) {
    entry_[body].body.wake();
    entry_[body].ours = entry_[body].pushed = true;
  }
  Touch tagged = touch;
  tagged.key |= std::uint64_t{tool + 1u} << kTagShift;
  (void)joint_.add(tagged, tool, moverOf(body));
}

void FreeBodies::push(std::uint8_t body, const Vec3& impulse, const Vec3& at, const Vec3& turning) HD_RT {
  Entry& entry = entry_[body];
  if (!moves(body) || !isFinite(impulse) || !isFinite(turning)) return;
  if (impulse.isZero(0) && turning.isZero(0)) return;
  RigidBody& rigid = entry.body.body;
  const Twist V = rigid.twist();
  const Twist change = mobility(body)(impulse, (at - rigid.com()).cross(impulse) + turning);
  entry.body.wake();
  entry.ours = entry.pushed = true;
  rigid.setTwist({V.v + change.v, V.w + change.w});
  if (entry.mover != kNone) joint_.moved(entry.mover);  // A tool that touches it has added it to the joint step.
}

double FreeBodies::frictionOf(const SceneObject& a, const SceneObject& b) HD_RT {
  return std::sqrt(a.material.friction_static * b.material.friction_static);
}

Twist FreeBodies::motionWithin(const Scene& scene, std::uint8_t k, std::uint32_t slot) const HD_RT {
  const std::uint32_t own = objectSlot(entry_[k].object);
  if (slot == own) return Twist{};
  const SceneObject &whole = scene.slot(own), &part = scene.slot(slot);
  return {part.V_WO.v - whole.velocityAt(part.X_WO.p), part.V_WO.w - whole.V_WO.w};
}

/** Contact i of body k as it stands now. Of what is of a body r_b counts, and `moving` beside how that moves. */
Touch FreeBodies::touchOf(const Scene& scene, std::uint8_t k, std::uint32_t i) const HD_RT {
  const Entry& entry = entry_[k];
  const RigidBody& mine = entry.body.body;
  const std::uint32_t slot = entry.model.point[i].body();
  const std::uint32_t feature = entry.model.point[i].feature();
  const SceneObject& object = scene.slot(slot);
  const SceneObject& self = scene.slot(objectSlot(entry.object));
  const std::uint8_t other = find(slot);
  const Pose there = other != kNone ? poseOf(scene, other, slot) : object.X_WO;
  Twist V;
  if (!isOld(scene, k, slot)) V = other != kNone ? motionWithin(scene, other, slot) : object.V_WO;
  Touch touch = entry.model.touch(i, mine.pose(), mine.com(), there, V);
  rollTo({self.shape, mine.pose()}, feature, {object.shape, there}, mine.com(), V.w, touch);
  if (other != kNone) touch.r_b = mine.com() + touch.r_a - entry_[other].body.body.com();
  touch.friction = frictionOf(self, object);
  if (feature == kWayOut) touch.friction = 0;  // Nothing rubs there.
  touch.key |= std::uint64_t{kMaxDevices + kMaxBodies + 1u + k} << kTagShift;
  return touch;
}

/**
 * Of what jumps while a body touches it, or takes the slot of what is gone, that body's contacts lie wherever its frame
 * now puts them. Until an answer has seen it there, a question and an answer later, they hold where they still fit, or
 * what lies on a floor that is replaced by its like would fall; they push nothing.
 */
bool FreeBodies::meets(const Scene& scene, std::uint8_t k, std::uint32_t i) const HD_RT {
  const std::uint32_t slot = entry_[k].model.point[i].body();
  return feels(scene, k, slot) && (!isOld(scene, k, slot) || touchOf(scene, k, i).gap > -kTouching);
}

bool FreeBodies::feels(const Scene& scene, std::uint8_t k, std::uint32_t slot) const HD_RT {
  if (!isFelt(scene.slot(slot))) return false;
  return find(slot) == kNone || isFelt(scene.slot(objectSlot(entry_[k].object)));
}

/** In a bowl of a mesh its box leads down through the floor on which points hold. */
bool FreeBodies::holds(const Scene& scene, std::uint8_t k, std::uint32_t i) const HD_RT {
  const Entry& entry = entry_[k];
  const ContactModel& model = entry.model;
  const std::uint32_t slot = model.point[i].body();
  if (!meets(scene, k, i)) return false;
  const auto isMesh = [&](std::uint32_t s) HD_RT { return scene.slot(s).shape.kind == ShapeKind::kMesh; };
  if (model.point[i].feature() != kWayOut || !(isMesh(slot) || isMesh(objectSlot(entry.object)))) return true;
  for (std::uint32_t j = 0; j < model.count; ++j) {
    if (j != i && model.point[j].body() == slot) return false;
  }
  return true;
}

/** Those that have fewer leave the rest to the others: who came last would have none, and fall through the floor. */
std::uint32_t FreeBodies::fairShare(const Scene& scene) const HD_RT {
  std::array<std::uint32_t, kMaxBodies> wanted{};
  for (std::uint8_t k = 0; k < kMaxBodies; ++k) {
    const ContactModel& model = entry_[k].model;
    for (std::uint32_t i = 0; i < model.count && entry_[k].mover != kNone; ++i) {
      wanted[k] += holds(scene, k, i) ? 1 : 0;
    }
  }
  std::uint32_t most = kMaxTouches;
  const auto sum = [&]() HD_RT {
    std::uint32_t all = 0;
    for (const std::uint32_t n : wanted) all += std::min(n, most);
    return all;
  };
  while (most > 1 && sum() > joint_.room()) --most;
  return most;
}

void FreeBodies::addTouches(const Scene& scene, std::uint8_t k, std::uint32_t most) HD_RT {
  const Entry& entry = entry_[k];
  for (std::uint32_t i = 0; i < entry.model.count && most > 0; ++i) {
    if (!holds(scene, k, i)) continue;
    --most;
    const std::uint32_t slot = entry.model.point[i].body();
    const std::uint8_t mover = isOld(scene, k, slot) ? JointStep::kFixed : moverOf(find(slot));
    (void)joint_.add(touchOf(scene, k, i), entry.mover, mover);
  }
}

/** What a hand pushes with another body is pushed here, too: in other groups it would come to lie elsewhere. But only
 * as long as a hand does: then another's may push it. */
void FreeBodies::claimTouched() HD_RT {
  std::array<bool, JointStep::kMaxMovers> pushed{};
  for (const Entry& entry : entry_) {
    if (entry.mover != kNone && entry.pushed) pushed[joint_.island(entry.mover)] = true;
  }
  for (Entry& entry : entry_) {
    if (entry.mover != kNone && pushed[joint_.island(entry.mover)]) entry.swept = true;
  }
}

void FreeBodies::place(Scene& scene, const Entry& entry, const Twist& V_WC) HD_RT {
  const RigidBody& body = entry.body.body;
  const Pose X = body.pose();
  const Twist V{V_WC.v - V_WC.w.cross(body.com() - X.p), V_WC.w};
  const std::uint32_t mover = entry.ours || entry.swept ? kCycleSession : kControlSession;
  (void)scene.apply(makeCommand(CommandKind::kObjectPose, poseMessage(entry.object, X, V), mover));
}

void FreeBodies::step(Scene& scene, double dt) HD_RT {
  const auto free = [this](std::uint8_t k) { return entry_[k].object != 0 && !entry_[k].held; };
  for (std::uint8_t k = 0; k < kMaxBodies; ++k) {
    if (free(k)) wakeTouched(scene, k);
  }
  leadAllOut(scene, dt);
  for (std::uint8_t k = 0; k < kMaxBodies; ++k) {
    if (!free(k)) continue;
    Entry& entry = entry_[k];
    (void)moverOf(k);
    if (entry.age < kStale) {
      entry.stands = false;
    } else if (!entry.stands) {
      entry.stands = true;
      place(scene, entry, Twist{});
    }
  }
  if (joint_.movers() == 0) return;
  const std::uint32_t most = fairShare(scene);
  for (std::uint8_t k = 0; k < kMaxBodies; ++k) {
    if (entry_[k].mover != kNone) addTouches(scene, k, most);
  }
  joint_.solve();
  claimTouched();
  watchRest(dt);
  for (const Entry& entry : entry_) {
    if (entry.mover != kNone) place(scene, entry, entry.body.body.twist());
  }
}

bool FreeBodies::ask(const Scene& scene, std::span<const std::uint32_t> held, CollideRequest& request) const HD_RT {
  bool any = false;
  for (std::uint8_t k = 0; k < kMaxBodies; ++k) {
    const Entry& entry = entry_[k];
    CollideRequest::Held& out = request.held[kMaxDevices + k];
    out.object = 0;
    const SceneObject* self = entry.object != 0 && !entry.held ? scene.find(entry.object) : nullptr;
    if (self == nullptr) continue;
    any = true;
    out.object = entry.object;
    out.shape = self->shape;
    out.X_WO = entry.body.body.pose();
    out.V_WO = entry.body.body.originTwist();
    out.arrived = entry.arrived;
    out.speed = speedBound(entry.body.body, *self);
    out.put = entry.leading > 0;
    findObstacles(scene, *self, held, out);
    for (std::uint32_t i = 0; i < out.count; ++i) {
      out.obstacle[i].arrived = arrivedIn(scene, out.obstacle[i].slot);
      out.put = out.put || scene.sinceUnmet(out.obstacle[i].slot) < kStale;
    }
  }
  return any;
}

}  // namespace hapticd
