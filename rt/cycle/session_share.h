/** @file
 * One client's share of the force: its local models and its own force, bound by its limits, faded when it is lost.
 */
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "rt/base/error.h"
#include "rt/render/model/local_model.h"

namespace hapticd {

/** A session slot of the cycle. Servo thread only. */
class SessionShare {
 public:
  enum class Life : std::uint8_t { kFree, kAlive, kLost };

  /** Share for one device, split by source; the rest is for the guard (GuardInput). Vectors in W. */
  struct Share {
    Vec3 local_model = Vec3::Zero();
    Vec3 client_force = Vec3::Zero();
    Vec3 client_torque = Vec3::Zero();
    Vec3 local_active = Vec3::Zero();  ///< Part of local_model that springs and force fields make [N].
    Vec3 carried = Vec3::Zero();       ///< Power, by axis, that moving, changing or returning models put in [W].
    double stored = 0;                 ///< Elastic energy in the local models [J].
    double damping = 0;                ///< By which they damp together [N s/m].
  };

  SessionShare() noexcept { free(); }

  void start(std::uint64_t id) HD_RT;
  /**
   * From now on the magnitude of the share only falls, whatever the hand and late commands do, and is zero after
   * `fade_ns`: it stays below the line from the last magnitude to zero, and below its own least so far.
   */
  void lose(std::int64_t now_ns, std::int64_t fade_ns) HD_RT;
  /** Back before it was freed: the magnitude returns from what it is now over the time it took to fade. */
  void revive() HD_RT;
  void free() HD_RT;

  /**
   * Local model, force field, clear, client force, limits. kInvalidArgument (slot, device or a value out of range),
   * kNotFound (frame object), kUnsupported (another kind): nothing changes.
   */
  ErrorCode apply(const Command& command, std::int64_t now_ns, const Scene& scene) HD_RT;
  /** Once per tick and device. A share that is not finite (huge values overflow) counts as zero: nobody else suffers.
   */
  [[nodiscard]] Share evaluate(const ToolPoint& tool, std::int64_t now_ns, const Scene& scene) HD_RT;

  /** Adds the commands that give a new session these limits, models and forces. Not HD_RT: allocates. */
  void restate(std::int64_t now_ns, std::vector<Command>& out) const;

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
  /** What loss and return leave of a magnitude. */
  struct Envelope {
    double last = 0;     ///< Magnitude at the last evaluation.
    double at_loss = 0;  ///< When it was lost.
    double at_return = 0;
    double returned = 0;       ///< Progress of the return at the last evaluation,
    std::int64_t last_ns = 0;  ///< which was then.
    double grows = 0;          ///< Part of the whole that the return adds [1/s].
  };

  void addClientForce(const ToolPoint& tool, std::int64_t now_ns, Share& share) HD_RT;
  [[nodiscard]] double scaleOf(Envelope& envelope, double magnitude, std::int64_t now_ns) const HD_RT;

  Life life_ = Life::kFree;
  std::uint64_t id_ = 0;
  std::int64_t lost_ns_ = 0;
  std::int64_t fade_ns_ = 0;
  bool returning_ = false;
  bool return_started_ = false;
  std::int64_t return_ns_ = 0;
  hd_limits limits_{};
  std::array<LocalModelSlot, HD_MODEL_SLOTS> models_;
  std::array<ClientForce, kMaxDevices> client_;
  std::array<Vec3, kMaxDevices> last_;
  std::array<Envelope, kMaxDevices> force_{};
  std::array<Envelope, kMaxDevices> torque_{};
  std::uint64_t applied_seq_ = 0;
  std::uint64_t applied_tick_ = 0;
};

}  // namespace hapticd
