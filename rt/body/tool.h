/** @file
 * A tool in the hand: a rigid body that the virtual coupling pulls after the device and that contacts hold back,
 * stepped once a servo tick. Owns the books: the tool never holds more energy than the hand and moving obstacles gave.
 *
 * A tick, at the device pose just read: (1) kick: velocities under coupling (implicit), weight and contacts (response);
 * (2) drift: RigidBody::drift(); (3) the clamp: if the energy of body and coupling after (2) exceeds that before (1)
 * plus the work of moving obstacles plus the reserve, the velocities are scaled down until it does not. At zero
 * velocity it holds, for then only the coupling's inner part relaxes; so there always is such a scale.
 *
 * The reserve is energy that earlier ticks lost, at most kMostReserve: it pays for pushing a tool out of an overlap,
 * which a late detector leaves, against the coupling. So such recoveries can give back what sinking in had taken, and
 * no more. Touches that yield (Touch::give) are springs that are charged and paid from the reserve too, which may then
 * hold as much more as they do.
 *
 * A tick is kick(), a response, move() as often as the clamp asks, accept(): step() for a tool alone, JointStep for
 * tools and bodies that push each other.
 */
#pragma once

#include "rt/body/coupling.h"
#include "rt/body/response.h"
#include "rt/body/rigid_body.h"

namespace hapticd {

struct ToolSetup {
  MassProperties mass;
  CouplingGains gains;
  Vec3 grip_O = Vec3::Zero();      ///< Where the coupling holds the tool, in the tool's frame [m].
  Quat turned = Quat::Identity();  ///< Tool's orientation relative to the device's when the coupling is at rest.
  Vec3 weight = Vec3::Zero();      ///< On the centre of mass: mass times gravity [N]; none unless wanted.
};

/** A tick's outcome. */
struct ToolStep {
  Wrench on_device;                   ///< Force, and torque about the device point: what the hand is to feel [N, N m].
  Wrench contact;                     ///< Of the obstacle on the tool, about its centre of mass, mean over the tick.
  Vec3 obstacle_work = Vec3::Zero();  ///< What moving obstacles put in, by axis [J].
  double lost = 0;             ///< Energy that the tick took from body and coupling [J]; may be below 0 by the reserve.
  double clamped = 1;          ///< Scale of the velocities that the clamp chose; 1: it had nothing to do.
  double residual = 0;         ///< ResponseResult::residual [m/s].
  std::uint32_t touching = 0;  ///< Touches with an impulse.
  std::uint32_t rounds = 0;    ///< Of the response.
};

/** A motion brought below Tool::kMostSpeed and kMostTurn: the scale that does it. */
[[nodiscard]] double scaleToBound(const Twist& V) HD_RT;
/** Sets what touches ask for: recovery from an overlap, but for kSlop, at a bounded speed. */
void settleTouches(std::span<Touch> touches, double dt) HD_RT;
/** What a touch that yields holds once its points have parted by `opened` [J]. */
[[nodiscard]] double heldBy(const Touch& touch, double opened) HD_RT;

/** One thread, servo-safe. */
class Tool {
 public:
  static constexpr double kMostReserve = 2e-3;  ///< [J]
  static constexpr double kMostSpeed = 20;      ///< [m/s]
  static constexpr double kMostTurn = 400;      ///< [rad/s]
  static constexpr double kRecoverTime = 0.02;  ///< An overlap is left within about this [s] ...
  static constexpr double kRecoverSpeed = 0.1;  ///< ... but not faster [m/s].
  static constexpr double kSlop = 10e-6;        ///< Overlap that is let be [m].
  static constexpr int kMostTries = 6;          ///< Halvings by the clamp, then a full stop.

  explicit Tool(const ToolSetup& setup) noexcept;

  /** Puts the tool where the device holds it, at rest. */
  void reset(const Pose& device) HD_RT;
  /** One tick. `touches` as ContactModel gives them; `separate` and the gaps' meaning are set here. */
  void step(const Pose& device, std::span<Touch> touches, double dt, Response& response, ToolStep& out) HD_RT;

  /** What holds the tool during a tick, and how it answers impulses at the tick's beginning. */
  struct Kick {
    Pose device;
    double dt = 0;
    SolidStep linear, angular;
    double had = 0;     ///< Energy before it [J].
    Mobility mobility;  ///< Of the body with its coupling.
    Twist free;         ///< Its motion if nothing touched.
  };
  /** Where a motion would take it. */
  struct Move {
    Move() : body(MassProperties{}) {}
    explicit Move(const RigidBody& from) HD_RT : body(from) {}
    RigidBody body;
    Vec3 d = Vec3::Zero(), u = Vec3::Zero(), e = Vec3::Zero(), e_turn = Vec3::Zero();
    double gained = 0;  ///< Energy, less what the weight gave [J].
  };
  void kick(const Pose& device, double dt, Kick& out) HD_RT;
  /** Moves a copy of the body on at V, of its centre of mass. */
  void move(const Kick& kick, const Twist& V, Move& out) const HD_RT;
  /** The tick was that; `reserve` is left. Sets out.on_device. */
  void accept(const Kick& kick, const Move& move, double reserve, ToolStep& out) HD_RT;

  [[nodiscard]] const RigidBody& body() const HD_RT { return body_; }
  /** Kinetic energy and what the coupling holds with the device at the last pose; without the weight's [J]. */
  [[nodiscard]] double energy() const HD_RT;
  [[nodiscard]] double reserve() const HD_RT { return reserve_; }
  [[nodiscard]] const ToolSetup& setup() const HD_RT { return setup_; }
  /** On the centre of mass from now on [N]. */
  void setWeight(const Vec3& weight) HD_RT { setup_.weight = weight; }
  /** Sets the motion, for tests and for what is thrown. */
  void setTwist(const Twist& V_WC) HD_RT { body_.setTwist(V_WC); }

 private:
  struct Stretch {
    Vec3 d = Vec3::Zero();  ///< Device from grip, in the world [m].
    Vec3 u = Vec3::Zero();  ///< Turn from tool to device, in the world [rad].
  };
  [[nodiscard]] Stretch stretch(const RigidBody& body, const Pose& device) const HD_RT;
  [[nodiscard]] double energyOf(const RigidBody& body, const Stretch& s, const Vec3& e, const Vec3& e_turn) const HD_RT;

  ToolSetup setup_;
  RigidBody body_;
  Pose device_;
  Vec3 e_ = Vec3::Zero();  ///< Deflections of the coupling's inner part.
  Vec3 e_turn_ = Vec3::Zero();
  double reserve_ = 0;
};

}  // namespace hapticd
