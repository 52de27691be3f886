/** @file
 * Commands of local models, as ingest hands them to the cycle.
 */
#pragma once

#include "rt/render/model/local_model.h"
#include "tests/support/time.h"

namespace hapticd {

inline hd_local_model modelOf(hd_model_kind kind, double stiffness = 500, double damping = 0) {
  hd_local_model m{};
  m.kind = kind;
  m.lease_ns = 1000 * kMs;
  m.blend_ns = 10 * kMs;
  m.material.stiffness = stiffness;
  m.material.damping = damping;
  m.normal[2] = 1;
  m.radius = kind == HD_MODEL_SPHERE ? 0.02 : 0;
  return m;
}

inline Command commandOf(const hd_local_model& m, std::uint64_t seq = 1) {
  Command c = makeCommand(CommandKind::kLocalModel, m);
  c.seq = seq;
  return c;
}
inline Command commandOf(const hd_force_field& f) { return makeCommand(CommandKind::kForceField, f); }

inline void setHalfspace(hd_local_model& m, const Vec3& n, double d) {
  const Vec3 unit = n.normalized();
  for (int i = 0; i < 3; ++i) m.halfspace[m.count][i] = static_cast<float>(unit[i]);
  m.halfspace[m.count++][3] = static_cast<float>(d);
}

/** A model on its own, in the world. */
struct LoneModel {
  LocalModel model;
  explicit LoneModel(const hd_local_model& m) { (void)model.set(commandOf(m)); }
  explicit LoneModel(const hd_force_field& f) { (void)model.set(commandOf(f)); }
  Vec3 at(const Vec3& p, const Vec3& v = Vec3::Zero()) { return model.evaluate(p, v, {}).force; }
};

}  // namespace hapticd
