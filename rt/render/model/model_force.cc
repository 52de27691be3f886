#include "rt/render/model/model_force.h"

#include <algorithm>
#include <cstring>

#include "rt/render/friction_cone.h"
#include "rt/render/model/model_solid.h"

namespace hapticd {
namespace {

constexpr double kCore = 0.1;          ///< Part of a radius over which a direction fades toward a centre.
constexpr double kFieldEdge = 0.2;     ///< Outer part of a field's radius over which it fades.
constexpr double kRounding = 0.5e-3;   ///< Of the edges between half-spaces, unless the client says [m].
constexpr double kLeastLength = 1e-9;  ///< Keeps divisions finite [m].
constexpr double kMiddle = 0.5;        ///< Share of k d below which what holds a hand is the middle of a solid.

/** x / |x|, shrinking to zero over the inner `core`. */
Vec3 fadedDirection(const Vec3& x, double distance, double core) HD_RT {
  return x / std::max({distance, core, kLeastLength});
}

/** Depth d for which k d^2 / 2 is what a sphere stores within its core, at `share` of the core's radius. */
double fullInCore(double radius, double share) HD_RT {
  const double border = (1 - kCore) * radius;
  // Twice the integral of (radius - r) r / core from there to the core's border.
  const double within = kCore * radius * radius * ((1 - share * share) - 2.0 / 3 * kCore * (1 - share * share * share));
  return std::sqrt(border * border + within);
}

/** False when x is no direction at all. What this made stays as it is to the bit: recordings state models anew. */
template <class T>
bool makeUnit(T (&n)[3]) HD_RT {
  const Vec3 x(n[0], n[1], n[2]);
  const double length = x.norm();
  if (!(length > 0.5 && length < 2)) return false;
  if (std::abs(length - 1) <= std::numeric_limits<T>::epsilon()) return true;
  for (int i = 0; i < 3; ++i) n[i] = static_cast<T>(x[i] / length);
  return true;
}

bool prepare(hd_local_model& m) HD_RT {
  switch (m.kind) {
    case HD_MODEL_PLANE:
      return makeUnit(m.normal);
    case HD_MODEL_SPRING:
      return m.radius >= 0;
    case HD_MODEL_SPHERE:
      return m.radius != 0;
    case HD_MODEL_HALFSPACES:
    case HD_MODEL_CORNER: {
      if (m.kind == HD_MODEL_HALFSPACES && !(m.radius >= 0)) return false;
      if (m.radius == 0) m.radius = kRounding;
      if (m.count < 1 || m.count > HD_HALFSPACES) return false;
      for (std::uint32_t i = 0; i < m.count; ++i) {
        float n[3] = {m.halfspace[i][0], m.halfspace[i][1], m.halfspace[i][2]};
        if (!makeUnit(n)) return false;
        std::copy(n, n + 3, m.halfspace[i]);
      }
      return true;
    }
    default:
      return false;
  }
}

/** What of the command makes the force. */
template <class Model>
Model lawOf(Model model) HD_RT {
  model.lease_ns = model.blend_ns = 0;
  return model;
}

hd_local_model shapeOf(const hd_local_model& model) HD_RT {
  hd_local_model shape = lawOf(model);
  shape.material = {};
  return shape;
}

template <class T>
bool sameBytes(const T& one, const T& other) HD_RT {
  return std::memcmp(&one, &other, sizeof(T)) == 0;  // NOLINT(bugprone-suspicious-memory-comparison): bit for bit
}

}  // namespace

ErrorCode LocalModel::set(const Command& command) HD_RT {
  LocalModel next;
  next.kind_ = command.kind;
  if (command.kind == CommandKind::kLocalModel) {
    next.local_ = command.as<hd_local_model>();
    if (next.local_.device >= kMaxDevices || !prepare(next.local_)) return ErrorCode::kInvalidArgument;
  } else if (command.kind == CommandKind::kForceField) {
    next.field_ = command.as<hd_force_field>();
    if (next.field_.device >= kMaxDevices || !(next.field_.radius > 0)) return ErrorCode::kInvalidArgument;
  } else {
    return ErrorCode::kInvalidArgument;
  }
  *this = next;
  return ErrorCode::kOk;
}

Command LocalModel::command() const HD_RT {
  Command out;
  out.kind = kind_;
  if (kind_ == CommandKind::kLocalModel) out.as<hd_local_model>() = local_;
  if (kind_ == CommandKind::kForceField) out.as<hd_force_field>() = field_;
  return out;
}

bool LocalModel::isSame(const LocalModel& other) const HD_RT {
  if (none() || kind_ != other.kind_) return false;
  return kind_ == CommandKind::kForceField ? sameBytes(lawOf(field_), lawOf(other.field_))
                                           : sameBytes(lawOf(local_), lawOf(other.local_));
}

void LocalModel::inherit(const LocalModel& former, const ModelFrame& former_frame, const ModelFrame& frame) HD_RT {
  if (!isContact() || !former.isContact() || !former.touching_ || device() != former.device()) return;
  touching_ = true;
  slip_ = former.slip_;
  if (sameBytes(shapeOf(local_), shapeOf(former.local_))) {
    anchor_ = former.anchor_;
    beyond_ = former.beyond_;
    left_ = former.left_;
    inherited_ = former.inherited_;
  } else {
    anchor_ = frame.X_WF.inverse() * (former_frame.X_WF * former.anchor_);
    inherited_ = true;
  }
}

std::uint32_t LocalModel::frame() const HD_RT {
  return kind_ == CommandKind::kForceField ? field_.frame : local_.frame;
}
std::uint32_t LocalModel::device() const HD_RT {
  return kind_ == CommandKind::kForceField ? field_.device : local_.device;
}
std::int64_t LocalModel::lease_ns() const HD_RT {
  return std::max<std::int64_t>(0, kind_ == CommandKind::kForceField ? field_.lease_ns : local_.lease_ns);
}
std::int64_t LocalModel::blend_ns() const HD_RT {
  return std::max<std::int64_t>(0, kind_ == CommandKind::kForceField ? field_.blend_ns : local_.blend_ns);
}

bool LocalModel::isContact() const HD_RT { return kind_ == CommandKind::kLocalModel && local_.kind != HD_MODEL_SPRING; }

LocalModel::Contact LocalModel::findContact(const Vec3& x) const HD_RT {
  const double k = local_.material.stiffness;
  const Vec3 from_origin = x - vec3(local_.origin);
  Contact c;
  double share = 1;  // Of the full elastic force: below one at edges and near a sphere's centre.
  switch (local_.kind) {
    case HD_MODEL_PLANE:
      c.normal = vec3(local_.normal);
      c.depth = -c.normal.dot(from_origin);
      break;
    case HD_MODEL_SPHERE: {
      const double distance = from_origin.norm();
      if (local_.radius > 0) {
        c.depth = local_.radius - distance;
        share = std::min(1.0, distance / (kCore * local_.radius));
        c.normal = from_origin / std::max(distance, kLeastLength);
      } else {
        c.depth = distance + local_.radius;
        c.normal = -from_origin / std::max(distance, kLeastLength);
      }
      break;
    }
    case HD_MODEL_HALFSPACES: {
      const SolidDepth solid =
          solidDepth(local_.halfspace, local_.count, std::max(local_.radius, kLeastLength), from_origin);
      c.depth = solid.depth;
      share = solid.normal.norm();
      c.normal = solid.normal / std::max(share, kLeastLength);
      break;
    }
    case HD_MODEL_CORNER: {
      const Vec3 out = wayOut(local_.halfspace, local_.count, from_origin);
      c.depth = out.norm();
      c.normal = out / std::max(c.depth, kLeastLength);
      break;
    }
    default:
      return c;
  }
  c.full = std::max(0.0, c.depth);
  c.elastic = k * c.full * share;
  c.depth *= share;  // The friction cone closes where the normal force vanishes.
  if (share < 1 && local_.kind == HD_MODEL_SPHERE) c.full = fullInCore(local_.radius, share);
  // Toward a sphere's middle, where its force fades, the limit of a sticking hand's force falls linearly with it.
  if (share < kMiddle) c.most = c.depth * (1 + std::clamp(2 * share / kMiddle - 1, 0.0, 1.0));
  return c;
}

Vec3 LocalModel::contactForce(const Contact& contact, const Vec3& x, const Vec3& v, double resolution, double b,
                              ModelForce& out) HD_RT {
  if (!(contact.depth > 0)) {
    touching_ = false;
    return Vec3::Zero();
  }
  const double k = local_.material.stiffness;
  const Vec3& n = contact.normal;
  const auto holdAt = [&](const Vec3& t, double along) HD_RT {
    anchor_ = x + along * n + t;
    beyond_ = contact.full * contact.full - along * along;
  };
  if (!touching_) {
    holdAt(Vec3::Zero(), contact.depth);
    touching_ = true;
    slip_ = false;
  }
  const double v_n = n.dot(v);
  double damping = std::clamp(-b * v_n, -contact.elastic, contact.elastic);
  // Friction is in proportion to what damping leaves of the normal force when the hand withdraws.
  const double left = damping < 0 ? 1 + damping / contact.elastic : 1.0;
  const double mu_d = std::max(0.0, local_.material.friction_dynamic);
  const double mu_s = std::max(mu_d, local_.material.friction_static);
  const double slides = left * mu_d * contact.depth, sticks = left * mu_s * contact.depth;
  Vec3 t = anchor_ - x;
  t -= n * n.dot(t);
  const double r = t.norm();
  if (inherited_) {
    left_ = r / contact.depth;
    holdAt(t, contact.depth);
  }
  inherited_ = false;
  slip_ = r > 0 && r >= (slip_ ? slipEnds(left_, left * mu_d, contact.depth, resolution) : sticks);
  // The spring gains nothing. Without friction nothing is held, nor on the other side of a solid, where it would pull.
  const double along = n.dot(anchor_ - x);
  const double most2 = (anchor_ - x).squaredNorm() + beyond_ - contact.full * contact.full;
  if (!(along > 0 && sticks > 0) || (slip_ && r > slides)) {
    const double keeps = std::min(slip_ ? std::min(slides, r) : r, std::sqrt(std::max(0.0, most2)));
    holdAt(r > 0 ? Vec3(keeps / r * t) : Vec3::Zero(), contact.depth);
  } else if (along > contact.most) {
    holdAt(std::min(1.0, std::sqrt(std::max(0.0, most2)) / std::max(r, kLeastLength)) * t, contact.most);
  } else if (beyond_ > 0 && along < contact.depth && most2 > r * r) {  // It was held less deep than the contact is now.
    holdAt(t, contact.depth);
    beyond_ += most2 - r * r;
  }
  left_ = std::min(left * mu_d, r / contact.depth);
  const Vec3 spring = anchor_ - x;
  out.stored = 0.5 * k * (spring.squaredNorm() + beyond_);
  const double push = k * std::max(0.0, n.dot(spring));
  damping = std::clamp(damping, -push, push);
  const double most = std::min(push, contact.elastic);
  out.damping = b * std::abs(v_n) > most ? most / std::abs(v_n) : b;
  return k * spring + damping * n;
}

Vec3 LocalModel::springForce(const Vec3& x, const Vec3& v, double b, ModelForce& out) const HD_RT {
  const double k = local_.material.stiffness;
  const Vec3 r = x - vec3(local_.origin);
  out.damping = b;
  if (local_.radius == 0) return -k * r - b * v;
  const double distance = r.norm();
  const Vec3 u = fadedDirection(r, distance, kCore * local_.radius);
  out.damping *= u.squaredNorm();
  return (-k * (distance - local_.radius) - b * u.dot(v)) * u;
}

Vec3 LocalModel::fieldForce(const Vec3& x) const HD_RT {
  const Vec3 r = x - vec3(field_.x0);
  const double weight = std::clamp((1 - r.norm() / field_.radius) / kFieldEdge, 0.0, 1.0);
  if (weight == 0) return Vec3::Zero();
  using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  const Eigen::Map<const RowMajor, Eigen::Unaligned> J(field_.jacobian);
  return weight * (vec3(field_.f0) + J * r);
}

ModelForce LocalModel::evaluate(const Vec3& p, const Vec3& v, const ModelFrame& frame, double resolution,
                                double most_damping) HD_RT {
  ModelForce out;
  if (none()) return out;
  const Quat R_FW = frame.X_WF.q.conjugate();
  const Vec3 v_frame = frame.V_WF.v + frame.V_WF.w.cross(p - frame.X_WF.p);
  const Vec3 x = R_FW * (p - frame.X_WF.p);
  const Vec3 v_F = R_FW * (v - v_frame);
  if (kind_ == CommandKind::kForceField) {
    out.force = frame.X_WF.q * fieldForce(x);
    out.active = out.force;
  } else if (local_.kind == HD_MODEL_SPRING) {
    out.force = frame.X_WF.q * springForce(x, v_F, std::min(local_.material.damping, most_damping), out);
    out.active = out.force;
  } else {
    out.force = frame.X_WF.q *
                contactForce(findContact(x), x, v_F, resolution, std::min(local_.material.damping, most_damping), out);
    out.carried = out.force.cwiseProduct(v_frame);
  }
  return out;
}

}  // namespace hapticd
