/** @file
 * The fourth degree of freedom of a soft finger: the twist between finger and surface about the contact's normal, held
 * by friction up to a moment (thesis section 2.3). The other three are the proxy's.
 *
 * A tick (thesis steps a to e): the object and the hand have turned by so much about the normal: turn(). What that
 * twist asks of friction the proxy hears (TwistLoad) before it looks whether it slips: together they stay within the
 * ellipse x^2 + y^2 <= 1 of eq. 2.48, and what is beyond comes back along the line to the goal (eq. 2.50). Then
 * settle() gives the twist what the proxy has left to it. Uncoupled, each has all of friction for itself.
 *
 * Where the thesis is read otherwise than printed: the twist is relative, so it begins at 0; the object's turn is
 * signed (eq. 2.31 prints its absolute value, and a turn to and fro would drift), and taken from its orientations,
 * not its velocity, so nothing is lost on the way; k_r is a stiffness [N m/rad] and not eq. 2.11's number.
 */
#pragma once

#include <cstdint>
#include <limits>

#include "rt/body/mobility.h"
#include "rt/command.h"
#include "rt/finger/fingerpad.h"
#include "rt/render/proxy/proxy.h"
#include "rt/scene/scene.h"

namespace hapticd {

/** What a soft finger adds to its contact. On the hand, in W; the object gets the opposite. */
struct FingerForces {
  Vec3 force = Vec3::Zero();  ///< Of the pad's viscosity, across the normal [N].
  double moment = 0;          ///< About the normal [N m].
  Vec3 cue = Vec3::Zero();    ///< Of slip, on the hand alone [N].
  double damping = 0;         ///< By which `force` is made [N s/m].
};

/** What moves at the contact, for what is viscous. */
struct FingerMotion {
  Twist hand;                    ///< Of the hand at the device point, in W.
  Vec3 w_object = Vec3::Zero();  ///< [rad/s]
  Vec3 r = Vec3::Zero();         ///< From the body's centre of mass to the contact [m],
  Mobility body;                 ///< and its mobility; zero of what nothing moves.
  int fingers = 1;               ///< That may press the same body.
  double most_damping = std::numeric_limits<double>::infinity();  ///< That the device bears [N s/m].
};

struct PadForce {
  Vec3 force = Vec3::Zero();  ///< On the hand, in W [N].
  double damping = 0;         ///< By which it is made [N s/m].
};
/**
 * Viscosity across the normal, of a contact that sticks to a body which moves freely: with what is elastic never more
 * than the share of friction that is left to it, and never so much that it throws the body back. Springs alone let what
 * is held swing for ever, and beside a device, whose force is late, ever more, until it slides. Servo-safe.
 */
[[nodiscard]] PadForce padForce(const SurfaceContact& contact, const FingerMotion& motion, double damping, double dt,
                                double share = 1) HD_RT;

/** Servo thread only; deterministic. */
class SoftFinger {
 public:
  static constexpr double kMostArm = 0.1;            ///< [m]
  static constexpr double kMostStiffness = 100;      ///< [N m/rad]
  static constexpr double kMostDamping = 100;        ///< [N s/m]
  static constexpr double kMostCue = 100;            ///< [N s/m]
  static constexpr double kMostCueForce = 1;         ///< [N]
  static constexpr double kCueLength = 1e-3;         ///< A slip by so much is one wave of the cue [m],
  static constexpr double kMostCueFrequency = 250;   ///< up to this many a second: skin feels no more [Hz].
  static constexpr double kTwistRetardation = 0.01;  ///< Viscosity of the twist over its stiffness [s].

  /** Finite and in range; PadLaw::kNone with anything. */
  [[nodiscard]] static bool valid(const SetFinger& order) HD_RT;
  /** A valid order; what is twisted stays so. */
  void set(const SetFinger& order) HD_RT;
  [[nodiscard]] const SetFinger& order() const HD_RT { return order_; }
  [[nodiscard]] bool soft() const HD_RT { return pad_.law != PadLaw::kNone; }
  /** Of the hand that is lost, or holds a tool. */
  void reset() HD_RT;

  /** Before the proxy's step: with the hand's orientation now. What the twist asks of friction. */
  [[nodiscard]] TwistLoad turn(const Scene& scene, const Quat& q_hand) HD_RT;

  /** After the proxy's step. */
  [[nodiscard]] FingerForces settle(const Scene& scene, const SurfaceContact& contact, const FingerMotion& motion,
                                    double dt) HD_RT;

  /** Of the surface's place of contact relative to the finger, about the normal [rad]. */
  [[nodiscard]] double twist() const HD_RT { return twist_; }
  /** Whether friction bears the twist no longer. */
  [[nodiscard]] bool turning() const HD_RT { return slips_; }

 private:
  [[nodiscard]] Vec3 cueOf(double speed, double dt) HD_RT;

  SetFinger order_{};
  Fingerpad pad_;
  bool coupled_ = true;
  std::uint32_t object_ = 0;  ///< Id of what it touched in the last tick, 0 for none,
  Quat q_object_ = Quat::Identity();
  Quat q_hand_ = Quat::Identity();
  Quat q_now_ = Quat::Identity();  ///< The hand's, in this tick.
  Vec3 normal_ = Vec3::Zero();
  double arm_ = 0;        ///< Of the last tick's force [m].
  double stiffness_ = 0;  ///< As what it touches lets it be [N m/rad].
  double twist_ = 0;
  bool slips_ = false;
  double phase_ = 0;  ///< Of the cue [rad].
};

}  // namespace hapticd
