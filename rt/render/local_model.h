/** @file
 * Local models: the small geometry a client sends about the tool, rendered here at full rate, blended from one to the
 * next without a jump, aged, and faded when the client is late. Thesis section 5.2 (intermediate representation);
 * Adachi, Kumano, Ogino, VRAIS 1995; Mark et al., SIGGRAPH 1996.
 */
#pragma once

#include <array>
#include <cstdint>

#include "rt/base/math.h"
#include "rt/command.h"
#include "rt/scene/scene.h"

namespace hapticd {

/** One device point as the models see it, in W. */
struct ToolPoint {
  Vec3 p = Vec3::Zero();
  Vec3 v = Vec3::Zero();
  std::uint32_t device = 0;
};

/**
 * One slot: the model in force and the one it replaces. Between them the force is
 * F = F_old + s (F_new - F_old), with s rising linearly over blend_ns, so that per tick
 * |change| <= |change of either model| + (dt / blend) |F_new - F_old|; blend_ns is at least kMinBlendNs.
 */
class LocalModelSlot {
 public:
  static constexpr std::int64_t kMinBlendNs = 5'000'000;
  static constexpr std::int64_t kFadeNs = 50'000'000;  ///< After the lease has run out.

  /** Takes effect now; what stood here is blended out from its present force. */
  void set(const Command& command, std::int64_t now_ns, const Scene& scene) HD_RT;
  void clear(std::int64_t now_ns, std::int64_t blend_ns) HD_RT;
  void reset() HD_RT;

  /** Force on the hand at `tool` [N]; zero for another device's model. */
  [[nodiscard]] Vec3 evaluate(const ToolPoint& tool, std::int64_t now_ns, const Scene& scene) HD_RT;

  [[nodiscard]] hd_model_status status(std::int64_t now_ns) const HD_RT;
  [[nodiscard]] bool empty() const HD_RT { return state_ == State::kEmpty; }
  /** True once, in the tick in which the lease ran out. */
  [[nodiscard]] bool takeExpired() HD_RT;

 private:
  enum class State : std::uint8_t { kEmpty, kInForce, kFading };

  /** One model with its memory (friction anchor, last frame pose). */
  struct Model {
    CommandKind kind = CommandKind::kNone;
    union {
      hd_local_model local;
      hd_force_field field;
    };
    Vec3 anchor = Vec3::Zero();
    bool touching = false;
    bool slip = false;
    Model() noexcept : local{} {}
  };

  static Vec3 force(Model& model, const ToolPoint& tool, const Scene& scene) HD_RT;

  State state_ = State::kEmpty;
  Model now_, before_;
  bool blending_ = false;
  bool expired_ = false;
  std::uint64_t seq_ = 0;
  std::int64_t applied_ns_ = 0;
  std::int64_t lease_ns_ = 0;
  std::int64_t blend_ns_ = 0;
  Vec3 frozen_ = Vec3::Zero();  ///< Force at the moment of replacement beyond what `before_` explains.
  std::uint32_t device_ = 0;
};

}  // namespace hapticd
