/** @file
 * Local models: the small geometry a client sends about the tool, rendered here at full rate, blended from one to the
 * next without a jump, aged, and faded when the client is late. Thesis section 5.2 (intermediate representation);
 * Adachi, Kumano, Ogino, VRAIS 1995; Mark et al., SIGGRAPH 1996.
 */
#pragma once

#include <array>
#include <cstdint>
#include <limits>

#include "rt/base/math.h"
#include "rt/command.h"
#include "rt/render/model/model_force.h"
#include "rt/scene/scene.h"

namespace hapticd {

/** One device point as the models see it, in W. */
struct ToolPoint {
  Vec3 p = Vec3::Zero();
  Vec3 v = Vec3::Zero();
  std::uint32_t device = 0;
  double resolution = 0;  ///< Steps in which p's coordinates come [m], as the device's encoders give them.
  double most_damping = std::numeric_limits<double>::infinity();  ///< Of all models together [N s/m].
};

/**
 * One slot: the model in force and what it replaces. Between them the force is
 *
 *   F = w (s F_new + (1 - s) (c F_old + r)),  s rising linearly from 0 to 1 over blend_ns (at least kMinBlendNs)
 *
 * where w fades from 1 to 0 after the lease, and c F_old + r was in force at the moment of replacement: c, from the
 * weight the old model had then to 1, is the share of it that leaves the smallest constant r. So the rest of an
 * unfinished blend goes on as a part of the old model as far as the two say the same, and models that are replaced
 * before they have come into force, but agree, follow the hand without a lag; where both say nothing they agree, so
 * that a hand which comes to a surface meets all of it. One that is in force and is sent again only has its lease
 * renewed. That moment is the last tick of the old model: there s is 0 and the force exactly what it was, in the first
 * tick of the new one s is dt / blend, so that models which are replaced in every tick come into force too. Per tick
 *
 *   |change| <= max(|change of F_new|, |change of c F_old|) + (dt / blend) |F_new - c F_old - r| + (dt / kFadeNs) |F|
 *
 * A replaced model hands its friction anchor on: a hand that sticks goes on sticking through updates of one surface. A
 * frame that moves takes its models along; when its object is gone the model stays where it was and fades.
 */
class LocalModelSlot {
 public:
  static constexpr std::int64_t kMinBlendNs = 5'000'000;
  static constexpr std::int64_t kFadeNs = 50'000'000;  ///< After the lease has run out.

  LocalModelSlot() noexcept { reset(); }

  /** Takes effect now; what stood here is blended out from its present force. kInvalidArgument: nothing changes. */
  ErrorCode set(const Command& command, std::int64_t now_ns, const Scene& scene) HD_RT;
  void clear(std::int64_t now_ns, std::int64_t blend_ns) HD_RT;
  void reset() HD_RT;

  /** Force on the hand at `tool`; zero for another device's model. Once per tick and device. */
  [[nodiscard]] ModelForce evaluate(const ToolPoint& tool, std::int64_t now_ns, const Scene& scene) HD_RT;

  /** The command that would put the model in force here again, for the rest of its lease; false when none is. */
  [[nodiscard]] bool restate(std::int64_t now_ns, Command& command) const HD_RT;

  [[nodiscard]] hd_model_status status(std::int64_t now_ns) const HD_RT;
  [[nodiscard]] bool empty() const HD_RT { return state_ == State::kEmpty; }
  /** Of the model in force; 0 when none is. */
  [[nodiscard]] std::uint32_t device() const HD_RT { return now_.model.none() ? 0 : now_.model.device(); }
  /** True once, after the lease ran out. */
  [[nodiscard]] bool takeExpired() HD_RT;

 private:
  enum class State : std::uint8_t { kEmpty, kInForce, kFading };

  /** A model and the place of its frame. */
  struct Framed {
    LocalModel model;
    ModelFrame frame;
    bool frame_gone = false;
  };

  static void follow(Framed& framed, const Scene& scene) HD_RT;
  void replace(const Framed& next, std::uint64_t seq, std::int64_t now_ns, std::int64_t blend_ns) HD_RT;
  [[nodiscard]] double blend(std::int64_t now_ns) const HD_RT;
  [[nodiscard]] double weight(std::int64_t now_ns) const HD_RT;

  State state_ = State::kEmpty;
  Framed now_, before_;
  bool blending_ = false;   ///< The old model had a part in the force, a tick ago at least.
  bool evaluated_ = false;  ///< Since the last replacement.
  bool expired_ = false;
  std::uint64_t seq_ = 0;
  std::int64_t applied_ns_ = 0;
  std::int64_t lease_ns_ = 0;
  std::int64_t blend_ns_ = kMinBlendNs;
  std::int64_t blend_start_ns_ = 0;
  std::int64_t last_ns_ = 0;    ///< Tick of the last evaluation,
  std::int64_t former_ns_ = 0;  ///< and the one before.
  std::int64_t fade_start_ns_ = 0;
  double now_weight_ = 1;                          ///< w s at the last evaluation,
  double agreed_weight_ = 1;                       ///< and w (s + (1 - s) c).
  double before_weight_ = 0;                       ///< c
  double cleared_weight_ = 1;                      ///< Of what was cleared, as told by then.
  std::array<Vec3, kMaxDevices> residual_;         ///< r, by device [N].
  std::array<Vec3, kMaxDevices> last_;             ///< Force at the last evaluation, by device [N].
  std::array<Vec3, kMaxDevices> last_of_now_;      ///< What now_ alone made of it, before weights [N].
  std::array<double, kMaxDevices> stored_;         ///< Elastic energy at the last evaluation, by device [J],
  std::array<double, kMaxDevices> stored_of_now_;  ///< and that of now_ alone.
  std::array<double, kMaxDevices> appeared_;  ///< By which c times that of the old model is more than there was [J].
};

}  // namespace hapticd
