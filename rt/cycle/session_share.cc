#include "rt/cycle/session_share.h"

#include <algorithm>

namespace hapticd {
namespace {

constexpr double kNoLimit = 1e6;  ///< [N], [N m]: the guard's limits are far below.

double progress(std::int64_t since_ns, std::int64_t now_ns, std::int64_t over_ns) HD_RT {
  if (over_ns <= 0) return 1;
  return std::clamp(static_cast<double>(now_ns - since_ns) / static_cast<double>(over_ns), 0.0, 1.0);
}

double shrink(double magnitude, double limit) HD_RT { return magnitude > limit ? limit / magnitude : 1.0; }

bool finite(const SessionShare::Share& s) HD_RT {
  return isFinite(s.local_model) && isFinite(s.client_force) && isFinite(s.client_torque) && isFinite(s.local_active) &&
         isFinite(s.carried) && std::isfinite(s.stored) && std::isfinite(s.damping) &&
         std::isfinite((s.local_model + s.client_force).norm()) && std::isfinite(s.client_torque.norm());
}

void scaleForce(SessionShare::Share& s, double by) HD_RT {
  s.local_model *= by;
  s.client_force *= by;
  s.local_active *= by;
  s.carried *= by;
  s.stored *= by;
  s.damping *= by;
}

}  // namespace

void SessionShare::start(std::uint64_t id) HD_RT {
  free();
  id_ = id;
  life_ = Life::kAlive;
}

void SessionShare::free() HD_RT {
  life_ = Life::kFree;
  id_ = 0;
  returning_ = return_started_ = false;
  limits_ = {kNoLimit, kNoLimit};
  for (LocalModelSlot& model : models_) model.reset();
  client_.fill(ClientForce{});
  for (Vec3& force : last_) force.setZero();
  force_.fill(Envelope{});
  torque_.fill(Envelope{});
  applied_seq_ = 0;
  applied_tick_ = 0;
}

void SessionShare::lose(std::int64_t now_ns, std::int64_t fade_ns) HD_RT {
  if (life_ != Life::kAlive) return;
  life_ = Life::kLost;
  lost_ns_ = now_ns;
  fade_ns_ = std::max<std::int64_t>(0, fade_ns);
  for (std::uint32_t i = 0; i < kMaxDevices; ++i) {
    force_[i].at_loss = force_[i].last;
    torque_[i].at_loss = torque_[i].last;
  }
}

void SessionShare::revive() HD_RT {
  if (life_ != Life::kLost) return;
  life_ = Life::kAlive;
  returning_ = true;
  return_started_ = false;
  for (std::uint32_t i = 0; i < kMaxDevices; ++i) {
    force_[i].at_return = force_[i].last;
    torque_[i].at_return = torque_[i].last;
    force_[i].returned = torque_[i].returned = 0;
  }
}

float SessionShare::fade(std::int64_t now_ns) const HD_RT {
  if (life_ == Life::kFree) return 0;
  if (life_ == Life::kLost) return static_cast<float>(1 - progress(lost_ns_, now_ns, fade_ns_));
  if (!returning_) return 1;
  return return_started_ ? static_cast<float>(progress(return_ns_, now_ns, fade_ns_)) : 0.0f;
}

ErrorCode SessionShare::apply(const Command& command, std::int64_t now_ns, const Scene& scene) HD_RT {
  if (life_ == Life::kFree) return ErrorCode::kNotFound;
  switch (command.kind) {
    case CommandKind::kLocalModel: {
      const std::uint32_t slot = command.as<hd_local_model>().slot;
      return slot < HD_MODEL_SLOTS ? models_[slot].set(command, now_ns, scene) : ErrorCode::kInvalidArgument;
    }
    case CommandKind::kForceField: {
      const std::uint32_t slot = command.as<hd_force_field>().slot;
      return slot < HD_MODEL_SLOTS ? models_[slot].set(command, now_ns, scene) : ErrorCode::kInvalidArgument;
    }
    case CommandKind::kClearModel: {
      const auto& clear = command.as<hd_clear_model>();
      if (clear.slot >= HD_MODEL_SLOTS) return ErrorCode::kInvalidArgument;
      models_[clear.slot].clear(now_ns, clear.blend_ns);
      return ErrorCode::kOk;
    }
    case CommandKind::kClientForce: {
      const auto& force = command.as<hd_client_force>();
      if (force.device >= kMaxDevices) return ErrorCode::kInvalidArgument;
      if (!isFinite(vec3(force.force)) || !isFinite(vec3(force.torque))) return ErrorCode::kInvalidArgument;
      client_[force.device] = {force, now_ns, true};
      return ErrorCode::kOk;
    }
    case CommandKind::kLimits: {
      const auto& limits = command.as<hd_limits>();
      if (!std::isfinite(limits.force_n) || !std::isfinite(limits.torque_nm) || limits.force_n < 0 ||
          limits.torque_nm < 0) {
        return ErrorCode::kInvalidArgument;
      }
      limits_ = {std::min(limits.force_n, kNoLimit), std::min(limits.torque_nm, kNoLimit)};
      return ErrorCode::kOk;
    }
    default:
      return ErrorCode::kUnsupported;
  }
}

void SessionShare::addClientForce(const ToolPoint& tool, std::int64_t now_ns, Share& share) HD_RT {
  ClientForce& client = client_[tool.device];
  if (!client.set) return;
  const std::int64_t late = now_ns - client.applied_ns - std::max<std::int64_t>(0, client.force.lease_ns);
  const double weight = 1 - progress(0, late, LocalModelSlot::kFadeNs);
  if (weight == 0) {
    client.set = false;
    return;
  }
  share.client_force = weight * vec3(client.force.force);
  share.client_torque = weight * vec3(client.force.torque);
}

double SessionShare::scaleOf(Envelope& envelope, double magnitude, std::int64_t now_ns) const HD_RT {
  double allowed = magnitude;
  envelope.grows = 0;
  if (life_ == Life::kLost) {
    const double line = envelope.at_loss * (1 - progress(lost_ns_, now_ns, fade_ns_));
    allowed = std::min({magnitude, line, envelope.last});
  } else if (returning_ && magnitude > envelope.at_return) {
    const double returned = progress(return_ns_, now_ns, fade_ns_);
    allowed = envelope.at_return + returned * (magnitude - envelope.at_return);
    const double part = (returned - envelope.returned) * (1 - envelope.at_return / magnitude);
    if (part > 0) envelope.grows = part / (1e-9 * static_cast<double>(now_ns - envelope.last_ns));
    envelope.returned = returned;
  }
  envelope.last_ns = now_ns;
  envelope.last = allowed;
  return magnitude > 0 ? allowed / magnitude : 1.0;
}

SessionShare::Share SessionShare::evaluate(const ToolPoint& tool, std::int64_t now_ns, const Scene& scene) HD_RT {
  Share share;
  if (life_ == Life::kFree || tool.device >= kMaxDevices) return share;
  ToolPoint left = tool;
  for (LocalModelSlot& model : models_) {
    if (model.empty()) continue;
    const ModelForce f = model.evaluate(left, now_ns, scene);
    share.local_model += f.force;
    share.local_active += f.active;
    share.carried += f.carried;
    share.stored += f.stored;
    share.damping += f.damping;
    left.most_damping = std::max(0.0, tool.most_damping - share.damping);
  }
  addClientForce(tool, now_ns, share);
  if (!finite(share)) share = Share{};

  const double in_limit = shrink((share.local_model + share.client_force).norm(), limits_.force_n);
  scaleForce(share, in_limit);
  share.stored *= 2 - in_limit;  // As in Guard::pass(): a capped spring gives back more than the cap's share.
  share.client_torque *= shrink(share.client_torque.norm(), limits_.torque_nm);

  Envelope& envelope = force_[tool.device];
  if (envelope.returned == 1) returning_ = false;
  if (returning_ && !return_started_) {
    return_started_ = true;
    return_ns_ = now_ns;
  }
  const double stored = share.stored;
  scaleForce(share, scaleOf(envelope, (share.local_model + share.client_force).norm(), now_ns));
  if (envelope.grows > 0) share.carried += byAxis(envelope.grows * stored, share.local_model);
  share.client_torque *= scaleOf(torque_[tool.device], share.client_torque.norm(), now_ns);

  last_[tool.device] = share.local_model + share.client_force;
  return share;
}

void SessionShare::restate(std::int64_t now_ns, std::vector<Command>& out) const {
  out.push_back(makeCommand(CommandKind::kLimits, limits_));
  out.back().seq = applied_seq_;  // by the ring: what it has applied stays acknowledged
  for (std::uint32_t i = 0; i < HD_MODEL_SLOTS; ++i) {
    Command model;
    if (!models_[i].restate(now_ns, model)) continue;
    model.channel = 1;
    out.push_back(model);
  }
  for (const ClientForce& client : client_) {
    const std::int64_t left_ns = client.applied_ns + client.force.lease_ns - now_ns;
    if (!client.set || left_ns <= 0) continue;
    out.push_back(makeCommand(CommandKind::kClientForce, client.force));
    out.back().channel = 1;
    out.back().as<hd_client_force>().lease_ns = left_ns;
  }
}

}  // namespace hapticd
