#include "rt/render/model/local_model.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace hapticd {
namespace {

double ratio(std::int64_t part, std::int64_t whole) HD_RT {
  return static_cast<double>(part) / static_cast<double>(whole);
}

constexpr double kSilent2 = 1e-24;  // [N^2]

/**
 * The share of `model` that explains most of `force`: at least `own`, the share it has, and not more than all of it.
 * Where neither says anything, `agreed`: that of all models which say so.
 */
double shareIn(const Vec3& force, const Vec3& model, double own, double agreed) HD_RT {
  const double squared = model.squaredNorm();
  if (squared > kSilent2) return std::clamp(force.dot(model) / squared, own, std::max(own, 1.0));
  return force.squaredNorm() > kSilent2 ? own : agreed;
}

}  // namespace

void LocalModelSlot::reset() HD_RT {
  state_ = State::kEmpty;
  now_ = before_ = Framed{};
  blending_ = evaluated_ = expired_ = false;
  seq_ = 0;
  now_weight_ = agreed_weight_ = 1;
  before_weight_ = 0;
  for (std::uint32_t i = 0; i < kMaxDevices; ++i) {
    residual_[i].setZero();
    last_[i].setZero();
    last_of_now_[i].setZero();
    stored_[i] = stored_of_now_[i] = appeared_[i] = 0;
  }
}

void LocalModelSlot::follow(Framed& framed, const Scene& scene) HD_RT {
  const std::uint32_t id = framed.model.none() ? 0 : framed.model.frame();
  if (id == 0) return;
  const SceneObject* object = scene.find(id);
  framed.frame_gone = framed.frame_gone || object == nullptr;
  if (framed.frame_gone) {
    framed.frame.V_WF = Twist{};
  } else {
    framed.frame = {object->X_WO, object->V_WO};
  }
}

ErrorCode LocalModelSlot::set(const Command& command, std::int64_t now_ns, const Scene& scene) HD_RT {
  Framed next;
  if (const ErrorCode error = next.model.set(command); error != ErrorCode::kOk) return error;
  const std::uint32_t frame = next.model.frame();
  if (frame != 0 && scene.find(frame) == nullptr) return ErrorCode::kNotFound;
  if (state_ == State::kInForce && next.model.isSame(now_.model)) {  // Nothing new but its lease.
    seq_ = command.seq;
    applied_ns_ = now_ns;
    lease_ns_ = next.model.lease_ns();
    return ErrorCode::kOk;
  }
  follow(next, scene);
  if (state_ != State::kEmpty) {
    Framed& former = evaluated_ ? now_ : before_;  // What never came into force holds no hand.
    follow(former, scene);
    next.model.inherit(former.model, former.frame, next.frame);
  }
  replace(next, command.seq, now_ns, next.model.blend_ns());
  lease_ns_ = next.model.lease_ns();
  return ErrorCode::kOk;
}

void LocalModelSlot::clear(std::int64_t now_ns, std::int64_t blend_ns) HD_RT {
  if (state_ == State::kEmpty) return;
  const std::int64_t applied_ns = applied_ns_;
  const double told = status(last_ns_).weight;
  replace(Framed{}, seq_, now_ns, blend_ns);
  // Of the model that goes, whose number it keeps, for whoever asks.
  applied_ns_ = applied_ns;
  cleared_weight_ = told;
  lease_ns_ = std::numeric_limits<std::int64_t>::max();
}

void LocalModelSlot::replace(const Framed& next, std::uint64_t seq, std::int64_t now_ns, std::int64_t blend_ns) HD_RT {
  const bool was_empty = state_ == State::kEmpty;
  if (was_empty) {
    reset();
    last_ns_ = former_ns_ = now_ns;
  } else if (evaluated_) {
    before_ = now_;
    const std::uint32_t d = device();
    before_weight_ = now_.model.none() ? 0 : shareIn(last_[d], last_of_now_[d], now_weight_, agreed_weight_);
    for (std::uint32_t i = 0; i < kMaxDevices; ++i) {
      residual_[i] = last_[i] - before_weight_ * last_of_now_[i];
      last_of_now_[i].setZero();
      appeared_[i] = before_weight_ * stored_of_now_[i] - stored_[i];
      stored_of_now_[i] = 0;
    }
  }  // Else the replaced model never came into force, and its predecessor stays.
  now_ = next;
  state_ = State::kInForce;
  blending_ = true;
  evaluated_ = false;
  seq_ = seq;
  applied_ns_ = now_ns;
  blend_start_ns_ = last_ns_;
  blend_ns_ = std::max(blend_ns, kMinBlendNs);
}

double LocalModelSlot::blend(std::int64_t now_ns) const HD_RT {
  return blending_ ? std::clamp(ratio(now_ns - blend_start_ns_, blend_ns_), 0.0, 1.0) : 1.0;
}

double LocalModelSlot::weight(std::int64_t now_ns) const HD_RT {
  return state_ == State::kFading ? std::clamp(1 - ratio(now_ns - fade_start_ns_, kFadeNs), 0.0, 1.0) : 1.0;
}

ModelForce LocalModelSlot::evaluate(const ToolPoint& tool, std::int64_t now_ns, const Scene& scene) HD_RT {
  if (state_ == State::kEmpty || tool.device >= kMaxDevices) return {};
  follow(now_, scene);
  if (state_ == State::kInForce && (now_ns - applied_ns_ > lease_ns_ || now_.frame_gone)) {
    expired_ = now_ns - applied_ns_ > lease_ns_;
    fade_start_ns_ = expired_ ? applied_ns_ + lease_ns_ : now_ns;
    state_ = State::kFading;
  }
  const double s = blend(now_ns);
  const double w = weight(now_ns);
  if (w == 0 || (s == 1 && now_.model.none())) {
    const bool expired = expired_;
    reset();
    expired_ = expired;
    return {};
  }
  if (now_ns != last_ns_) former_ns_ = std::exchange(last_ns_, now_ns);
  const double s_former = blend(former_ns_);
  blending_ = s_former < 1;
  evaluated_ = true;
  now_weight_ = w * s;
  const bool one_device = !before_.model.none() && !now_.model.none() && before_.model.device() == now_.model.device();
  agreed_weight_ = w * (one_device ? s + (1 - s) * before_weight_ : s);

  ModelForce out;
  if (!now_.model.none() && now_.model.device() == tool.device) {
    out = now_.model.evaluate(tool.p, tool.v, now_.frame, tool.resolution, tool.most_damping);
  }
  last_of_now_[tool.device] = out.force;
  stored_of_now_[tool.device] = out.stored;
  if (blending_) {
    ModelForce old;
    if (!before_.model.none() && before_.model.device() == tool.device) {
      follow(before_, scene);
      old = before_.model.evaluate(tool.p, tool.v, before_.frame, tool.resolution, tool.most_damping);
    }
    const double c = before_weight_;
    const Vec3& r = residual_[tool.device];
    // Blending to another model changes stored energy without any motion. That change since the last tick is charged to
    // the client as work of its own; the first time with the jump by which the old model's share began.
    const double begun = former_ns_ == blend_start_ns_ ? appeared_[tool.device] : 0.0;
    const double grown = (s - s_former) * (out.stored - c * old.stored) + begun;
    const double dt = static_cast<double>(now_ns - former_ns_) * 1e-9;
    const double put_in = grown > 0 && dt > 0 ? grown / dt : 0.0;
    const Vec3 change = out.force - c * old.force - r;
    out.force = s * out.force + (1 - s) * (c * old.force + r);
    out.active = s * out.active + (1 - s) * (c * old.active + r);
    out.carried = s * out.carried + (1 - s) * c * old.carried + byAxis(put_in, change);
    out.stored = s * out.stored + (1 - s) * c * old.stored;
    out.damping = s * out.damping + (1 - s) * c * old.damping;
  }
  out.force *= w;
  out.active *= w;
  out.carried *= w;
  out.stored *= w;
  out.damping *= w;
  last_[tool.device] = out.force;
  stored_[tool.device] = out.stored;
  return out;
}

bool LocalModelSlot::restate(std::int64_t now_ns, Command& command) const HD_RT {
  if (state_ != State::kInForce || now_.model.none()) return false;  // What is cleared has no end.
  const std::int64_t left_ns = applied_ns_ + lease_ns_ - now_ns;
  if (left_ns <= 0) return false;
  command = now_.model.command();
  command.seq = seq_;
  if (command.kind == CommandKind::kForceField) {
    command.as<hd_force_field>().lease_ns = left_ns;
  } else {
    command.as<hd_local_model>().lease_ns = left_ns;
  }
  return true;
}

hd_model_status LocalModelSlot::status(std::int64_t now_ns) const HD_RT {
  hd_model_status out{};
  if (state_ == State::kEmpty) return out;
  const double s = blend(now_ns);
  out.seq = seq_;
  out.age_ns = now_ns - applied_ns_;
  out.weight = static_cast<float>(weight(now_ns) * (now_.model.none() ? cleared_weight_ * (1 - s) : s));
  out.state = state_ == State::kFading || now_.model.none() ? 3 : (s < 1 ? 1 : 2);
  return out;
}

bool LocalModelSlot::takeExpired() HD_RT {
  const bool expired = expired_;
  expired_ = false;
  return expired;
}

}  // namespace hapticd
