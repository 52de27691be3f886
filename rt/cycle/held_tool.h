/** @file
 * The tool in one device's hand, within the cycle: attached by an order, told of contacts by the collide thread through
 * CycleInput, stepped each tick at the servo's rate. The scene's object follows it.
 */
#pragma once

#include <cstdint>

#include "rt/body/constraint_response.h"
#include "rt/body/contact_model.h"
#include "rt/body/tool.h"
#include "rt/collide/request.h"
#include "rt/cycle/free_bodies.h"
#include "rt/cycle/obstacles.h"
#include "rt/device.h"
#include "rt/scene/scene.h"

namespace hapticd {

/** What it comes to in one tick. */
struct HeldToolOutput {
  Wrench wrench;                ///< For the guard: torque only where the device can show it [N, N m].
  Vec3 carried = Vec3::Zero();  ///< Power by axis that moving obstacles and the wrist put in [W].
  double stored = 0;            ///< Energy that may come back [J].
  std::uint32_t touched = 0;    ///< Object with the strongest contact, 0 for none.
  bool touch = false;           ///< The first contact began this tick.
  Vec3 point = Vec3::Zero();    ///< Of that contact, in the world [m].
  Vec3 normal = Vec3::Zero();   ///< Its direction, toward the tool.
  double weight = 1;            ///< Below one: contacts are stale, the force fades.
};

/** Servo thread. */
class HeldTool {
 public:
  static constexpr double kStale = 0.1;  ///< No contacts for so long: the force fades ... [s]
  static constexpr double kFade = 0.05;  ///< ... over this [s], and comes back over as long.

  HeldTool() noexcept : tool_(ToolSetup{}) {}

  /** kNotFound: no such object. kInvalidArgument: a value is out of range, or it has a parent or no surface. */
  ErrorCode attach(const AttachTool& order, const Scene& scene) HD_RT;
  void detach() HD_RT { order_.object = 0; }
  /** Contacts, checked; those of a tool that is gone are none of ours, and no error. */
  ErrorCode take(const ToolContacts& contacts) HD_RT;

  /** Follows the device: alone, or, where it touches bodies that move, joins them. Lets go when its object is gone. */
  void begin(const Scene& scene, const DeviceSample& sample, const Twist& velocity, double dt,
             FreeBodies& bodies) HD_RT;
  /** After bodies.step(): what came of it. Moves the scene's object there. */
  void finish(Scene& scene, const Twist& velocity, double dt, HeldToolOutput& out) HD_RT;
  /** The hand is elsewhere at once, or its reading is not to be used: the tool starts anew where it next stands. */
  void forget() HD_RT { started_ = false; }
  /** What to ask the collide thread. */
  void ask(const Scene& scene, const FreeBodies& bodies, CollideRequest::Held& held) const HD_RT;

  [[nodiscard]] bool held() const HD_RT { return order_.object != 0; }
  /** Stiffness of the coupling that is felt in the end, or of direct rendering [N/m]. */
  [[nodiscard]] double stiffness() const HD_RT;
  [[nodiscard]] const AttachTool& order() const HD_RT { return order_; }
  [[nodiscard]] const Tool& tool() const HD_RT { return tool_; }
  [[nodiscard]] const ToolStep& last() const HD_RT { return step_; }

 private:
  void noteTouch(const Scene& scene, HeldToolOutput& out) HD_RT;
  void gather(const Scene& scene, const FreeBodies& bodies) HD_RT;
  void yieldTo(const Scene& scene) HD_RT;
  void render(const Twist& velocity, const Pose& device, double dt, FreeBodies& bodies) HD_RT;

  AttachTool order_{};
  Tool tool_;
  ConstraintResponse response_;
  ContactModel model_;
  ToolStep step_;
  std::array<Touch, kMaxTouches> touch_;
  std::array<std::uint8_t, kMaxTouches> body_of_{};  ///< Of each touch: FreeBodies::find().
  std::uint32_t touches_ = 0;
  double stored_ = 0;          ///< Energy that may come back [J].
  Vec3 com_ = Vec3::Zero();    ///< Before this tick.
  double age_ = 0;             ///< Of the contacts [s].
  double weight_ = 1;          ///< Of the force, for their age.
  std::uint64_t asked_ = 0;    ///< Tick of the question that they answer, or in which it started.
  std::uint64_t arrived_ = 0;  ///< Tick in which it last started.
  std::uint32_t touched_ = 0;  ///< In the last tick.
  bool started_ = false;
  bool taken_ = false;  ///< Into the hand, from wherever it was, in this tick.
};

}  // namespace hapticd
