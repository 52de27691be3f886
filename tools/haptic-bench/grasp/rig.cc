#include "tools/haptic-bench/grasp/rig.h"

#include <cmath>
#include <numbers>

#include "daemon/config/config.h"
#include "daemon/device/limits.h"
#include "drivers/registry.h"
#include "rt/body/rigid_body.h"
#include "tools/haptic-bench/failure.h"

namespace haptic_bench::grasp {
namespace {

using namespace hapticd;  // NOLINT(google-build-using-namespace)

constexpr std::uint32_t kBlock = makeObjectId(1, 1);
constexpr int kGround_ticks = 500;  // In which the ground goes.
constexpr int kStill_ticks = 500;

SimSetup setupOf(const Hand& hand) {
  DeviceUri uri = orFail(parseDeviceUri("sim://default?rate=1000"));
  uri.query.emplace_back("hand_stiffness", fmt::format("{}", hand.stiffness));
  return orFail(resolveSim(uri));
}

CycleConfig configOf(const DeviceInfo& info) {
  LimitsConfig limits;
  limits.force_n = info.max_force;  // Blocks of 0.4 kg on slippery faces ask for it.
  CycleConfig config;
  config.period_ns = std::llround(kPeriod_s * 1e9);
  config.device_count = 2;
  GuardConfig guard;
  guard.limits = startLimits(limits, info);
  guard.ramp_ns = config.period_ns;
  guard.delay = info.latency_s / kPeriod_s;
  if (info.max_damping > 0) guard.max_damping = info.max_damping;
  config.guard.fill(guard);
  return config;
}

}  // namespace

Unrest::Unrest(double rms, std::mt19937_64& random) : amplitude_(rms / std::sqrt(kTones)) {
  std::uniform_real_distribution<double> part(0, 1);
  for (int i = 0; i < 2 * kTones; ++i) {
    const auto at = static_cast<std::size_t>(i);
    rate_hz_[at] = i < kTones ? 0.1 + part(random) : 8 + 4 * part(random);
    phase_[at] = 2 * std::numbers::pi * part(random);
  }
}

double Unrest::at(double t_s) const {
  double sum = 0;  // Six tones of the same power rms^2 / 6 each: amplitude rms / sqrt(3).
  for (std::size_t i = 0; i < rate_hz_.size(); ++i)
    sum += std::sin(2 * std::numbers::pi * rate_hz_[i] * t_s + phase_[i]);
  return amplitude_ * sum;
}

Rig::Rig(const Block& block, const Hand& hand, const SetFinger& finger)
    : block_(block),
      hand_(hand),
      device_{SimDevice(setupOf(hand)), SimDevice(setupOf(hand))},
      random_(hand.seed),
      unrest_{Unrest(hand.unsteady, random_), Unrest(hand.unsteady, random_)},
      depth_(-2e-3),
      meshes_(std::make_unique<MeshTable>()),
      input_(std::make_unique<CycleInput>()),
      output_(std::make_unique<CycleOutput>()) {
  const DeviceInfo& info = device_[0].info();
  cycle_ = std::make_unique<Cycle>(configOf(info), *meshes_);
  for (std::uint32_t d = 0; d < 2; ++d) {
    if (const Result<void> opened = device_[d].open(); !opened) throw Failure(opened.error());
    cycle_->setResolution(d, info.position_resolution, info.rotation_resolution);
  }
  for (int i = 0; i < 1000; ++i) tick();  // The hand comes to where it begins, and nothing is there yet.

  AddObject object{};
  object.object = kBlock;
  object.flags = HD_OBJECT_ENABLED;
  object.shape.kind = static_cast<std::uint32_t>(ShapeKind::kBox);
  store(block_.half, object.shape.size);
  object.material = block_.material;
  object.q[0] = 1;
  send(CommandKind::kAddObject, object);
  SetBody body{};
  body.object = kBlock;
  body.falls = 1;
  body.mass = block_.mass;
  store(Vec3(0, block_.lever, 0), body.com);
  const MassProperties mass = MassProperties::ofBox(block_.mass, 2 * block_.half);
  for (int i = 0; i < 3; ++i) body.inertia[i] = mass.inertia_O(i, i);
  send(CommandKind::kSetBody, body);
  for (std::uint32_t d = 0; d < 2; ++d) {
    SetFinger order = finger;
    order.device = d;
    if (finger.law != static_cast<std::uint32_t>(PadLaw::kNone)) send(CommandKind::kSetFinger, order);
    send(CommandKind::kArm, DeviceRef{d});
  }
  tick();
}

void Rig::grasp(double force) {
  const double open = depth_, deep = depthFor(force);
  for (int i = 0; i <= kGround_ticks; ++i) {
    want(open + (deep - open) * i / kGround_ticks);
    tick();
  }
  for (int i = 0; i < kStill_ticks; ++i) tick();
  for (int i = 1; i <= kGround_ticks; ++i) {
    send(CommandKind::kSetGravity, SetGravity{{0, 0, -kGravity * i / kGround_ticks}});
    tick();
  }
  for (int i = 0; i < kStill_ticks; ++i) tick();
  start_ = middle();
}

double Rig::depthFor(double force) const { return force / block_.material.stiffness + force / hand_.stiffness; }

void Rig::tick() {
  ++input_->tick;
  input_->now_ns += cycle_->config().period_ns;
  for (std::size_t d = 0; d < 2; ++d) {
    const double side = d == 0 ? 1 : -1;
    const double deep = depth_ + unrest_[d].at(time());
    device_[d].setIntent({Vec3(side * (block_.half.x() - deep), 0, 0), Quat::Identity(), 0});
    input_->device[d].fresh = false;
    device_[d].read(input_->now_ns, input_->device[d]);
  }
  ToolContacts none{};  // As collision detection would answer: what touches the block are fingers alone.
  none.device = kMaxDevices;
  none.object = kBlock;
  none.tick = input_->tick - 1;
  send(CommandKind::kToolContacts, none);
  cycle_->step(*input_, *output_);
  input_->command_count = 0;
  for (std::size_t d = 0; d < 2; ++d) {
    if (output_->device[d].guard.fault != HD_FAULT_NONE) throw Failure("grasp", "the guard has latched a fault", "");
    device_[d].write(input_->now_ns, output_->device[d].command);
  }
}

double Rig::grip() const {
  double sum = 0;
  for (std::size_t d = 0; d < 2; ++d) {
    const SurfaceContact& contact = output_->device[d].contact;
    sum += std::max(0.0, contact.force.dot(contact.normal));
  }
  return sum / 2;
}

Pose Rig::place() const { return cycle_->scene().find(kBlock)->X_WO; }

Vec3 Rig::middle() const {
  return place().inverse() * Vec3((output_->device[0].contact.point + output_->device[1].contact.point) / 2);
}

double Rig::turned() const {
  const Quat q = place().q;
  return std::remainder(2 * std::atan2(q.x(), q.w()), 2 * std::numbers::pi);
}

bool Rig::slips() const {
  bool slips = false;
  for (std::uint32_t d = 0; d < 2; ++d) slips = slips || output_->device[d].contact.slip || cycle_->finger(d).turning();
  return slips;
}

bool Rig::held() const { return output_->device[0].contact.object != 0 && output_->device[1].contact.object != 0; }

}  // namespace haptic_bench::grasp
