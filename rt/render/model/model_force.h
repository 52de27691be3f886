/** @file
 * The force law of one local model: geometry, stiffness, damping and the thesis's two-state friction cone. Time, leases
 * and blending are local_model.h's.
 *
 * Every law is a continuous function of place and velocity, but for the one jump that friction is made of (stick to
 * slip: k (mu_s - mu_d) d).
 */
#pragma once

#include <limits>

#include "rt/base/error.h"
#include "rt/base/math.h"
#include "rt/command.h"

namespace hapticd {

/** What a model does to the hand. Vectors in W. */
struct ModelForce {
  Vec3 force = Vec3::Zero();    ///< On the hand [N].
  Vec3 active = Vec3::Zero();   ///< Part of it that springs and force fields make [N].
  Vec3 carried = Vec3::Zero();  ///< Power, by axis, that the client puts in by moving the model [W].
  double stored = 0;            ///< Elastic energy of the passive part [J].
  double damping = 0;           ///< By which it damps, at most its force over the speed [N s/m].
};

/** Where a model's frame F stands and how it moves. */
struct ModelFrame {
  Pose X_WF;
  Twist V_WF;  ///< In W, about F's origin.
};

/**
 * One model with its memory. Contact kinds (plane, sphere, half-spaces, corner):
 *
 *   normal   F_n = k d + c, c = -b v_n held within +-k d: never pulling, zero at the surface, dissipative
 *   friction F_t = k (a - x)_t with the anchor a in F (thesis section 2.2.1): sticks while r = |(a - x)_t| < mu_s d;
 *            leaving it moves a to the border of the dynamic cone, r = mu_d d; slip ends inside the dynamic cone
 *
 * Sticking, the whole force is that of the spring to the anchor, k (a - x) + c n: on a plane the same, and where the
 * normal turns as the hand moves, on balls and at edges, no closed way gives energy. A slip leaves less in the spring.
 * So does the anchor in the middle of a solid: it fades as the force without friction does, and lets go of a hand that
 * comes out on the other side.
 *
 * with v relative to the frame. The solid of half-spaces has its edges rounded (model_solid.h) by
 * `radius`, or by 0.5 mm where that is 0: between faces the force turns within that much slack, and 1 - 1/m of half of
 * it is missing where m faces meet. A radius of 1e-9 leaves them as sharp as those of a mesh: no depth is missing, and
 * the force turns from face to face at once. A sphere's force fades toward its centre over the inner tenth of the
 * radius, a spring's with a free length likewise: no jump there. Spring: F = -k (|x - o| - L) u - b v along u, u from o
 * to x; L = 0: F = -k (x - o) - b v. Field: F = w (f0 + J (x - x0)), w = 1 to 0.8 radius, falling to 0 at the radius.
 */
class LocalModel {
 public:
  LocalModel() noexcept : local_{} {}

  /** From a command of kind kLocalModel or kForceField; normals are made unit. kInvalidArgument: nothing changes. */
  ErrorCode set(const Command& command) HD_RT;
  /** Whether it is the same law in the same frame, whatever lease and blend it came with. */
  [[nodiscard]] bool isSame(const LocalModel& other) const HD_RT;
  /**
   * The contact memory of the model that this one replaces: a stuck anchor stays stuck through updates. All of it, if
   * only the material is another. None of a spring's, which touches nothing, and none of another device's.
   */
  void inherit(const LocalModel& former, const ModelFrame& former_frame, const ModelFrame& frame) HD_RT;

  [[nodiscard]] bool none() const HD_RT { return kind_ == CommandKind::kNone; }
  /** The command that makes this model anew, to the bit, without its contact memory. */
  [[nodiscard]] Command command() const HD_RT;
  [[nodiscard]] std::uint32_t frame() const HD_RT;
  [[nodiscard]] std::uint32_t device() const HD_RT;
  [[nodiscard]] std::int64_t lease_ns() const HD_RT;
  [[nodiscard]] std::int64_t blend_ns() const HD_RT;
  [[nodiscard]] bool slips() const HD_RT { return touching_ && slip_; }

  /**
   * Force on a hand at p with velocity v, both in W. Advances the friction state.
   * @param p  [m]
   * @param v  [m/s]
   * @param frame  Of the model, now.
   * @param resolution  Steps in which the coordinates of p come [m]: what slips does not stick for one of them.
   * @param most_damping  What it damps by at most [N s/m].
   */
  [[nodiscard]] ModelForce evaluate(const Vec3& p, const Vec3& v, const ModelFrame& frame, double resolution = 0,
                                    double most_damping = std::numeric_limits<double>::infinity()) HD_RT;

 private:
  /** Where the tool stands in a solid. Vectors in F. */
  struct Contact {
    double depth = 0;    ///< Of the spring, [m]; <= 0: outside.
    double full = 0;     ///< Without friction k full^2 / 2 is stored [m]; at edges and centres more than depth.
    double elastic = 0;  ///< [N]
    double most = std::numeric_limits<double>::infinity();  ///< Of a stuck spring's part along the normal [m].
    Vec3 normal = Vec3::UnitZ();                            ///< Outward, unit.
  };

  /** Neither spring nor field. */
  [[nodiscard]] bool isContact() const HD_RT;
  [[nodiscard]] Contact findContact(const Vec3& x) const HD_RT;
  [[nodiscard]] Vec3 contactForce(const Contact& contact, const Vec3& x, const Vec3& v, double resolution, double b,
                                  ModelForce& out) HD_RT;
  [[nodiscard]] Vec3 springForce(const Vec3& x, const Vec3& v, double b, ModelForce& out) const HD_RT;
  [[nodiscard]] Vec3 fieldForce(const Vec3& x) const HD_RT;

  CommandKind kind_ = CommandKind::kNone;
  union {
    hd_local_model local_;
    hd_force_field field_;
  };
  Vec3 anchor_ = Vec3::Zero();  ///< In F.
  double beyond_ = 0;           ///< Energy that was stored when it was set, beyond the spring's, over k / 2 [m^2].
  bool touching_ = false;
  bool slip_ = false;
  bool inherited_ = false;  ///< Friction's state is that of another model, whose planes lay otherwise.
  double left_ = 0;         ///< Where friction was left: the way from anchor to surface, in depths.
};

}  // namespace hapticd
