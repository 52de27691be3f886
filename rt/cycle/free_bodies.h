/** @file
 * The objects that move freely, within the cycle: given a mass by an order, told of contacts by the collide thread
 * through CycleInput, pushed by tools and hands, stepped each tick together with the tools that touch them. The scene's
 * objects follow, so that clients, other groups and every proxy see them move.
 *
 * Each servo moves the bodies of its own scene. The one whose tools or hands have pushed a body last, also by another
 * body, tells control that it has, as if a client had moved it; where it goes from then on the others take over.
 */
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "rt/body/contact_model.h"
#include "rt/body/joint_step.h"
#include "rt/collide/request.h"
#include "rt/scene/scene.h"

namespace hapticd {

/** Checks what both tools and bodies are told of contacts. */
[[nodiscard]] bool valid(const ToolContacts& contacts) HD_RT;
/** False where an object cannot be a rigid body: no end, no surface, or part of another. */
[[nodiscard]] bool canMove(const SceneObject& object) HD_RT;

/**
 * Servo thread. A tick: begin(), tools join() and touch(), hands push(), step(). In that order, for hands meet bodies
 * where the last tick left them: pushed after the step they would be driven by forces a tick old, and a body between
 * two fingers would gain energy until it is thrown.
 */
class FreeBodies {
 public:
  static constexpr double kStale = 0.1;      ///< No contacts for so long: a body stands still [s].
  static constexpr double kTouching = 1e-4;  ///< Gap at which a body is woken by what touches it [m].
  static constexpr double kLeadOut = 3;      ///< The longest that what was put somewhere is led out, in its turns [s].
  static constexpr std::uint32_t kMostMissed = 3;  ///< Answers in a row that may miss what a body is led out of.
  static constexpr std::uint32_t kMostLooks = 2;   ///< In a tick for ways out: what it costs is the square of touches.
  static constexpr double kMostGravity = 100;      ///< [m/s^2]
  static constexpr std::uint8_t kNone = 0xff;

  /** kNotFound: no such object. kInvalidArgument: out of range, or it cannot move. kQuotaExceeded: kMaxBodies are. */
  ErrorCode set(const SetBody& order, Scene& scene) HD_RT;
  ErrorCode setGravity(const SetGravity& order) HD_RT;
  /** Those of a body that is gone are none of ours, and no error. */
  ErrorCode take(const ToolContacts& contacts) HD_RT;
  /** Somebody has put an object elsewhere. */
  void moved(const hd_object_pose& pose, bool by_control, std::uint64_t tick) HD_RT;

  /** `held`: objects in hands; they are the hands' while they are. */
  void begin(Scene& scene, double dt, std::span<const std::uint32_t> held) HD_RT;
  /** The free body of which the object in that slot of the scene is the whole or a part; kNone. */
  [[nodiscard]] std::uint8_t find(std::uint32_t slot) const HD_RT {
    return slot < kMaxObjects ? of_slot_[slot] : kNone;
  }
  /** Also while it is in a hand. */
  [[nodiscard]] bool isBody(std::uint32_t object) const HD_RT {
    return object != 0 && std::any_of(entry_.begin(), entry_.end(), [=](const Entry& e) { return e.object == object; });
  }
  /** Whether it is one of those that begin() was told. */
  [[nodiscard]] bool isInHand(std::uint32_t object) const HD_RT {
    return std::find(in_hands_.begin(), in_hands_.begin() + hands_, object) != in_hands_.begin() + hands_;
  }
  [[nodiscard]] const FreeBody& body(std::uint8_t k) const HD_RT { return entry_[k].body; }
  /** Where the object in that slot, found to be of body k, stands now that the body may have gone on. */
  [[nodiscard]] Pose poseOf(const Scene& scene, std::uint8_t k, std::uint32_t slot) const HD_RT;
  /** How a client moves the object in that slot, found to be of body k, beside how that moves; of its origin. */
  [[nodiscard]] Twist motionWithin(const Scene& scene, std::uint8_t k, std::uint32_t slot) const HD_RT;
  /** Whether no answer has seen it yet where somebody has put it. */
  [[nodiscard]] bool wasPut(std::uint8_t k) const HD_RT { return entry_[k].asked < entry_[k].arrived; }
  /** Tick in which what is in that slot, or the body that it is of, last came where it is by no motion. */
  [[nodiscard]] std::uint64_t arrivedIn(const Scene& scene, std::uint32_t slot) const HD_RT {
    const std::uint8_t k = find(slot);
    if (k == kNone) return scene.arrivedIn(slot);
    // Of a part that jumps by itself; where the whole goes too fast for the scene's eyes both jump in each tick.
    const std::uint64_t part = scene.arrivedIn(slot), whole = scene.arrivedIn(objectSlot(entry_[k].object));
    return part > whole ? std::max(part, entry_[k].arrived) : entry_[k].arrived;
  }
  /** A tool that touches bodies is stepped with them. Its number for touch(). */
  std::uint8_t join(Tool& tool, const Pose& device, ToolStep& out) HD_RT { return joint_.add(tool, device, out); }
  /** A touch of a tool that has joined; `body`: what find() says of the other side. */
  void touch(const Touch& touch, std::uint8_t tool, std::uint8_t body) HD_RT;
  /** Of the body's point at x_W; zero where it stands [m/s]. */
  [[nodiscard]] Vec3 velocityAt(std::uint8_t k, const Vec3& x_W) const HD_RT {
    const RigidBody& rigid = entry_[k].body.body;
    return entry_[k].age < kStale ? hapticd::velocityAt(rigid.twist(), x_W - rigid.com()) : Vec3(Vec3::Zero());
  }
  /** Of its point at r from its center of mass, before anything pushed it in this tick [m, m/s]. */
  [[nodiscard]] Vec3 velocityBefore(std::uint8_t k, const Vec3& r) const HD_RT {
    return entry_[k].age < kStale ? hapticd::velocityAt(entry_[k].before, r) : Vec3(Vec3::Zero());
  }
  /** Whether what pushes it moves it now; else it stands. */
  [[nodiscard]] bool moves(std::uint8_t k) const HD_RT { return entry_[k].age < kStale; }
  [[nodiscard]] Mobility mobility(std::uint8_t k) const HD_RT {
    const RigidBody& rigid = entry_[k].body.body;
    return Mobility::free(rigid.mass(), rigid.inertia());
  }
  /** The body gets an impulse at a point of the world [N s, m], and an angular one beside it [N m s]. */
  void push(std::uint8_t body, const Vec3& impulse, const Vec3& at, const Vec3& turning = Vec3::Zero()) HD_RT;
  void step(Scene& scene, double dt) HD_RT;

  /** What to ask the collide thread. True if there is a body. */
  bool ask(const Scene& scene, std::span<const std::uint32_t> held, CollideRequest& request) const HD_RT;

  [[nodiscard]] const Vec3& gravity() const HD_RT { return gravity_; }
  /** Bodies for which the last step has looked for a way out of what they were put into. */
  [[nodiscard]] std::uint32_t looks() const HD_RT { return looks_; }
  [[nodiscard]] const JointStep& joint() const HD_RT { return joint_; }

 private:
  /** What may hold a body, as it was when that was last awake. */
  struct Support {
    std::uint32_t slot = 0;
    ShapeKind kind = ShapeKind::kGroup;
    Vec3 size = Vec3::Zero();
    std::uint64_t mesh = 0;  ///< Number of a mesh's shape.
    Pose X_WO;
    double friction = 0;
  };
  struct Entry {
    std::uint32_t object = 0;  ///< Id, 0: unused.
    FreeBody body{MassProperties{}, 0, false};
    ContactModel model;
    Twist before;                 ///< As the tick began.
    std::uint64_t asked = 0;      ///< Tick of the question that they answer.
    std::uint64_t arrived = 0;    ///< Tick in which it last came where it is by no motion.
    bool told = false;            ///< There was an answer since it is a body and in no hand.
    double age = 0;               ///< Of the contacts [s].
    double leading = 0;           ///< So long it may still be led out of what it was put into, by its own turns [s].
    Vec3 way = Vec3::Zero();      ///< The way; zero: it has not begun.
    bool led = false;             ///< In its last turn.
    std::uint32_t missed = 0;     ///< Answers in a row that told of nothing to be led out of, ...
    std::uint64_t missed_in = 0;  ///< ... the last of them, by the tick of its question.
    std::array<Support, kMaxTouches> support;  ///< What it touched when it was last awake.
    std::uint32_t supports = 0;
    bool held = false;    ///< In a hand.
    bool ours = false;    ///< Pushed here last: control is told where it goes,
    bool swept = false;   ///< and so is what it pushes, in this tick.
    bool pushed = false;  ///< By a hand or tool, in this tick.
    bool stands = false;  ///< Its contacts are stale, and the scene knows that it stands.
    std::uint8_t mover = kNone;
  };
  Entry* lookUp(std::uint32_t object) HD_RT;
  std::uint8_t moverOf(std::uint8_t k) HD_RT;
  /** Whether body k feels what is in that slot; of two bodies neither does if one is not felt. */
  [[nodiscard]] bool feels(const Scene& scene, std::uint8_t k, std::uint32_t slot) const HD_RT;
  /** Whether body k touches what contact i is of. */
  [[nodiscard]] bool meets(const Scene& scene, std::uint8_t k, std::uint32_t i) const HD_RT;
  /** Whether what body k knows of that slot is of before that came there. */
  [[nodiscard]] bool isOld(const Scene& scene, std::uint8_t k, std::uint32_t slot) const HD_RT {
    return entry_[k].asked < arrivedIn(scene, slot);
  }
  [[nodiscard]] Touch touchOf(const Scene& scene, std::uint8_t k, std::uint32_t i) const HD_RT;
  /** Two coefficients make one: the geometric mean is common. */
  [[nodiscard]] static double frictionOf(const SceneObject& a, const SceneObject& b) HD_RT;
  // Sleep (free_bodies_rest.cc).
  [[nodiscard]] Support supportOf(const Scene& scene, std::uint8_t k, std::uint32_t slot) const HD_RT;
  /** What it touches now is what may hold it. */
  void noteSupports(const Scene& scene, std::uint8_t k) HD_RT;
  /** Whether all that held it is there as then, and holds it no less. */
  [[nodiscard]] bool isHeldAsBefore(const Scene& scene, std::uint8_t k) const HD_RT;
  void wakeTouched(const Scene& scene, std::uint8_t k) HD_RT;
  void watchRest(double dt) HD_RT;
  // Out of what it was put into (lead_out.cc).
  /** What a plane knows of what it touches: a point; all of it, or of the box about it (kWayOut). */
  enum class Knows : std::uint8_t { kPoint, kWhole, kBox };
  /** Touches of one body. */
  struct Near {
    static constexpr std::uint32_t kMost = 32;
    std::uint32_t count = 0;
    std::array<Touch, kMost> touch;
    std::array<std::uint32_t, kMost> slot;   ///< What is touched; of a body of several parts the whole.
    std::array<std::uint32_t, kMost> parts;  ///< Which part of that, and which of this body.
    std::array<bool, kMost> moves;           ///< It is a body, too,
    std::array<bool, kMost> mine;            ///< which found it: the plane is of this body.
    std::array<Knows, kMost> knows;
  };
  /** It overlaps nothing; what it is in bars it, or it has come another way; another thing is in the way. */
  enum class Way : std::uint8_t { kNone, kBarred, kWaits, kOut };
  static void leadAnew(Entry& entry) HD_RT;
  /** Whether it is out, and no answer has only missed what it is in. */
  [[nodiscard]] static bool isOut(Entry& entry) HD_RT;
  void findNear(const Scene& scene, std::uint8_t k, Near& near) const HD_RT;
  /** `of`: the slot of what it leads out of. */
  [[nodiscard]] static Way findWayOut(const Entry& entry, const Near& near, double dt, Knows most, Touch& out,
                                      std::uint32_t& of) HD_RT;
  [[nodiscard]] bool goesAhead(std::uint8_t other, std::uint8_t k, const Vec3& n) const HD_RT;
  void leadAllOut(const Scene& scene, double dt) HD_RT;
  /** Whether it may be led now. */
  [[nodiscard]] static bool mayLead(const Scene& scene, Entry& entry) HD_RT;
  void leadOut(const Scene& scene, std::uint8_t k, double dt) HD_RT;
  /** How many touches each body may have, so that all together have room. */
  [[nodiscard]] std::uint32_t fairShare(const Scene& scene) const HD_RT;
  /** Whether it may hold: a mesh's box does where no point of the mesh is known. */
  [[nodiscard]] bool holds(const Scene& scene, std::uint8_t k, std::uint32_t i) const HD_RT;
  /** The first `most` of them: those that ContactModel chose first hold it best. */
  void addTouches(const Scene& scene, std::uint8_t k, std::uint32_t most) HD_RT;
  void claimTouched() HD_RT;
  static void place(Scene& scene, const Entry& entry, const Twist& V_WC) HD_RT;
  static void leave(Scene& scene, Entry& entry) HD_RT;

  std::array<Entry, kMaxBodies> entry_;
  std::array<std::uint8_t, kMaxObjects> of_slot_ = none();
  std::array<std::uint32_t, kMaxDevices> in_hands_{};
  std::size_t hands_ = 0;
  Vec3 gravity_ = Vec3::Zero();
  std::uint8_t next_look_ = 0;  ///< Whose turn it is.
  std::uint32_t looks_ = 0;
  JointStep joint_;

  static constexpr std::array<std::uint8_t, kMaxObjects> none() {
    std::array<std::uint8_t, kMaxObjects> out{};
    out.fill(kNone);
    return out;
  }
};

}  // namespace hapticd
