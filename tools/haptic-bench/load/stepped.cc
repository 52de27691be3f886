#include "tools/haptic-bench/load/stepped.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <deque>
#include <memory>
#include <numbers>

#include "rt/cycle/cycle.h"

namespace haptic_bench {
namespace {

using namespace hapticd;  // NOLINT(google-build-using-namespace)

const std::int64_t kTickNs = std::llround(kTick_s * 1e9);

/** One device at given places, one session, armed while the hand is still in the air. */
class Stepper {
 public:
  explicit Stepper(const MeshTable& meshes) {
    CycleConfig config;
    config.period_ns = kTickNs;
    config.guard[0].limits = {.force = 50,
                              .torque = 1,
                              .force_slew = 1e6,
                              .torque_slew = 1e3,
                              .gripper_force = 0,
                              .velocity = 10,
                              .power = 1e3,
                              .active_power = 1e3};
    config.guard[0].ramp_ns = kTickNs;
    config.guard[0].passivity = false;  // What is asked for is compared, not what is done about it.
    cycle_ = std::make_unique<Cycle>(config, meshes);
    order(CommandKind::kAddSession, SessionRef{0, 0, 1});
    order(CommandKind::kArm, DeviceRef{0});
  }

  template <class T>
  void order(CommandKind kind, const T& payload) {
    add(kind, kControlSession, payload);
  }
  /** From the client, as ingest would hand it on. */
  template <class T>
  void send(CommandKind kind, const T& payload) {
    add(kind, 0, payload);
  }

  void step(const Vec3& hip) {
    input_.tick++;
    input_.now_ns += kTickNs;
    DeviceSample& sample = input_.device[0];
    sample.t_ns = input_.now_ns;
    sample.fresh = true;
    sample.p = hip;
    cycle_->step(input_, output_);
    input_.command_count = 0;
  }

  [[nodiscard]] const Vec3& force(std::uint32_t source) const { return output_.device[0].guard.by_source[source]; }
  [[nodiscard]] const Vec3& velocity() const { return output_.device[0].velocity.v; }

 private:
  template <class T>
  void add(CommandKind kind, std::uint32_t session, const T& payload) {
    Command& command = input_.command[input_.command_count++] = makeCommand(kind, payload, session);
    command.seq = ++seq_;
  }

  std::unique_ptr<Cycle> cycle_;
  CycleInput input_;
  CycleOutput output_;
  std::uint64_t seq_ = 0;
};

}  // namespace

std::vector<Vec3> nativeForces(const MeshTable& meshes, double stiffness, std::span<const Vec3> hips, Facets facets) {
  Stepper stepper(meshes);
  AddObject object{};
  object.object = makeObjectId(1, 1);
  object.flags = HD_OBJECT_ENABLED;
  object.shape.kind = static_cast<std::uint32_t>(ShapeKind::kMesh);
  object.material.stiffness = stiffness;
  object.q[0] = 1;
  stepper.order(CommandKind::kAddObject, object);
  if (facets == Facets::kShaded) {
    SetSurface surface{};
    surface.object = object.object;
    surface.surface.smooth_cosine = std::cos(std::numbers::pi / 6);
    stepper.order(CommandKind::kSetSurface, surface);
  }
  std::vector<Vec3> forces;
  for (const Vec3& hip : hips) {
    stepper.step(hip);
    forces.push_back(stepper.force(HD_SOURCE_SURFACE));
  }
  return forces;
}

std::vector<Vec3> nearestForces(const haptic::SurfaceMesh& mesh, double stiffness, std::span<const Vec3> hips) {
  std::vector<Vec3> forces;
  for (const Vec3& hip : hips) forces.emplace_back(vec3(fitForce(mesh, hip, {1, 0, stiffness}).force));
  return forces;
}

double steppedLatency_s(double asked_s) {
  return static_cast<double>(std::max(1LL, std::llround(asked_s / kTick_s))) * kTick_s;
}

std::vector<Vec3> clientForces(Source source, const haptic::SurfaceMesh& mesh, const ClientTiming& asked,
                               std::span<const Vec3> hips) {
  static_assert(sizeof(haptic_local_model) == sizeof(hd_local_model));
  static_assert(sizeof(haptic_client_force) == sizeof(hd_client_force));
  struct Sent {
    std::size_t tick;
    hd_local_model model;
    hd_client_force force;
  };
  const auto meshes = std::make_unique<MeshTable>();
  Stepper stepper(*meshes);
  std::deque<Sent> under_way;
  ClientTiming timing = asked;
  timing.latency_s = steppedLatency_s(asked.latency_s);
  const auto latency = static_cast<std::size_t>(std::llround(timing.latency_s / kTick_s));
  std::size_t sent = 0;
  std::vector<Vec3> forces;
  for (std::size_t tick = 0; tick < hips.size(); ++tick) {
    while (!under_way.empty() && under_way.front().tick <= tick) {
      if (source == Source::kForce) {
        stepper.send(CommandKind::kClientForce, under_way.front().force);
      } else {
        stepper.send(CommandKind::kLocalModel, under_way.front().model);
      }
      under_way.pop_front();
    }
    stepper.step(hips[tick]);
    forces.push_back(stepper.force(source == Source::kForce ? HD_SOURCE_CLIENT : HD_SOURCE_LOCAL_MODEL));
    if (static_cast<double>(tick) * kTick_s < static_cast<double>(sent) * timing.period_s) continue;
    ++sent;
    Sent message{tick + latency, {}, {}};
    if (source == Source::kForce) {
      message.force = std::bit_cast<hd_client_force>(fitForce(mesh, hips[tick], timing));
    } else {
      message.model = std::bit_cast<hd_local_model>(fitModel(source, mesh, hips[tick], stepper.velocity(), timing));
    }
    under_way.push_back(message);
  }
  return forces;
}

ForceError compareForces(std::span<const Vec3> forces, std::span<const Vec3> reference) {
  ForceError e;
  const std::size_t n = std::min(forces.size(), reference.size());
  double squares = 0;
  Vec3 before = Vec3::Zero();
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3 off = forces[i] - reference[i];
    squares += off.squaredNorm();
    e.max = std::max(e.max, off.norm());
    e.mean += reference[i].norm() / static_cast<double>(n);
    if (i > 0) e.change_max = std::max(e.change_max, (off - before).norm());
    before = off;
  }
  e.rms = std::sqrt(squares / static_cast<double>(std::max<std::size_t>(n, 1))) / e.mean;
  e.change_max /= e.mean;
  e.max /= e.mean;
  return e;
}

}  // namespace haptic_bench
