/** @file
 * One client's share of the force: its local models and its own force, bound by its limits, faded when it is lost.
 */
#pragma once

#include <array>
#include <cstdint>

#include "rt/render/local_model.h"

namespace hapticd {

/** A session slot of the cycle. Servo thread only. */
class SessionShare {
 public:
  enum class Life : std::uint8_t { kFree, kAlive, kLost };

  /** Share for one device, split by source. */
  struct Share {
    Vec3 local_model = Vec3::Zero();
    Vec3 client_force = Vec3::Zero();
    Vec3 client_torque = Vec3::Zero();
  };

  void start(std::uint64_t id) HD_RT;
  /** From now on the magnitude of the share only falls, and is zero after `fade_ns`. */
  void lose(std::int64_t now_ns, std::int64_t fade_ns) HD_RT;
  void revive() HD_RT;
  void free() HD_RT;

  /** Local model, force field, clear, client force, limits. */
  ErrorCode apply(const Command& command, std::int64_t now_ns, const Scene& scene) HD_RT;
  [[nodiscard]] Share evaluate(const ToolPoint& tool, std::int64_t now_ns, const Scene& scene) HD_RT;

  [[nodiscard]] Life life() const HD_RT { return life_; }
  [[nodiscard]] std::uint64_t id() const HD_RT { return id_; }
  /** 1 alive, falling to 0 when lost. */
  [[nodiscard]] float fade(std::int64_t now_ns) const HD_RT;
  [[nodiscard]] LocalModelSlot& model(std::uint32_t i) HD_RT { return models_[i]; }
  [[nodiscard]] const LocalModelSlot& model(std::uint32_t i) const HD_RT { return models_[i]; }
  [[nodiscard]] std::uint64_t appliedSeq() const HD_RT { return applied_seq_; }
  [[nodiscard]] std::uint64_t appliedTick() const HD_RT { return applied_tick_; }
  void noteApplied(std::uint64_t seq, std::uint64_t tick) HD_RT {
    applied_seq_ = seq;
    applied_tick_ = tick;
  }
  /** The last share of that device, for hd_sample.own. */
  [[nodiscard]] const Vec3& last(std::uint32_t device) const HD_RT { return last_[device]; }

 private:
  struct ClientForce {
    hd_client_force force{};
    std::int64_t applied_ns = 0;
    bool set = false;
  };

  Life life_ = Life::kFree;
  std::uint64_t id_ = 0;
  std::int64_t lost_ns_ = 0;
  std::int64_t fade_ns_ = 0;
  hd_limits limits_{};
  std::array<LocalModelSlot, HD_MODEL_SLOTS> models_;
  std::array<ClientForce, kMaxDevices> client_;
  std::array<Vec3, kMaxDevices> last_{};
  std::array<double, kMaxDevices> ceiling_{};  ///< Most the share may be while lost [N].
  std::uint64_t applied_seq_ = 0;
  std::uint64_t applied_tick_ = 0;
};

}  // namespace hapticd
