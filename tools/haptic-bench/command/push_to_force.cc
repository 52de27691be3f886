#include "tools/haptic-bench/command/push_to_force.h"

#include <algorithm>
#include <memory>
#include <random>
#include <span>

#include "rt/cycle/servo.h"
#include "rt/ring/command_ring.h"
#include "rt/ring/state.h"

namespace haptic_bench {
namespace {

using namespace hapticd;  // NOLINT(google-build-using-namespace)

constexpr std::int64_t kPeriodNs = 1'000'000;

/** A device at rest. */
class StillDevice final : public Device {
 public:
  [[nodiscard]] const DeviceInfo& info() const noexcept override { return info_; }
  [[nodiscard]] Result<void> open() override { return {}; }
  void close() noexcept override {}
  void read(std::int64_t now_ns, DeviceSample& sample) HD_RT override {
    sample = DeviceSample{};
    sample.t_ns = now_ns;
    sample.fresh = true;
  }
  void write(std::int64_t, const DeviceCommand& command) HD_RT override { force_ = command.force; }
  void safe() noexcept override { force_.setZero(); }
  [[nodiscard]] const Vec3& force() const { return force_; }

 private:
  DeviceInfo info_;
  Vec3 force_ = Vec3::Zero();
};

/** One session on one servo, armed. */
class Rig {
 public:
  Rig() {
    initialiseRegions(a_.get(), b_.get(), {});
    CycleConfig config;
    config.period_ns = kPeriodNs;
    config.guard[0].limits = {.force = 5,
                              .torque = 1,
                              .force_slew = 1e7,
                              .torque_slew = 1e7,
                              .gripper_force = 0,
                              .velocity = 10,
                              .power = 100,
                              .active_power = 100};
    config.guard[0].ramp_ns = kPeriodNs;
    servo_ = std::make_unique<Servo>(config, std::array<Device*, kMaxDevices>{&device_}, *meshes_, clock_);
    servo_->ingest = ingest_.get();
    servo_->ports[0].region = a_.get();
    ingest_->orders.push({IngestOrder::Kind::kAttach, 0, {1, b_.get(), a_.get(), 1}});
    servo_->from_control.push(makeCommand(CommandKind::kAddSession, SessionRef{0, 0, 1}));
    servo_->from_control.push(makeCommand(CommandKind::kArm, DeviceRef{0}));
    servo_->begin();
    for (int i = 0; i < 50; ++i) tick();
  }

  /** Ticks from a push at `push_at` of the period until its force is at the device; ingest steps at `ingest_at`. */
  int trial(double push_at, double ingest_at, bool by_mailbox) {
    sign_ = -sign_;
    for (int ticks = 0; ticks < 10; ++ticks) {
      const bool ingest_first = ingest_at <= push_at;
      if (ingest_first) ingest(ingest_at);
      if (ticks == 0) push(by_mailbox);
      if (!ingest_first) ingest(ingest_at);
      tick();
      if (device_.force().x() * sign_ > 0) return ticks + 1;
    }
    return 10;
  }

 private:
  void push(bool by_mailbox) {
    hd_client_force force{};
    force.lease_ns = 1'000'000'000;
    force.force[0] = sign_;
    std::uint64_t seq = 0;
    const auto bytes = std::as_bytes(std::span(&force, 1));
    if (by_mailbox) {
      mailbox_.write(HD_COMMAND_CLIENT_FORCE, bytes, seq);
    } else {
      producer_.push(HD_COMMAND_CLIENT_FORCE, bytes, 0, seq);
    }
    producer_.heartbeat(clock_.now());
  }
  void ingest(double at) {
    ingest_->step(clock_.now() + static_cast<std::int64_t>(at * kPeriodNs), servo_->counters.tick.load());
  }
  void tick() { servo_->runOnce(); }

  std::unique_ptr<hd_region_a> a_ = std::make_unique<hd_region_a>();
  std::unique_ptr<hd_region_b> b_ = std::make_unique<hd_region_b>();
  CommandProducer producer_{b_.get(), a_.get()};
  MailboxWriter mailbox_{&b_->mailbox[0]};
  std::unique_ptr<Ingest> ingest_ = std::make_unique<Ingest>(IngestConfig{});
  std::unique_ptr<MeshTable> meshes_ = std::make_unique<MeshTable>();
  StillDevice device_;
  ManualClock clock_;
  std::unique_ptr<Servo> servo_;
  double sign_ = 1;
};

}  // namespace

double worstPushToForce(std::uint32_t seed) {
  Rig rig;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> phase(0, 1);
  int worst = 0;
  for (int n = 0; n < 100; ++n) {
    const double push_at = phase(random);
    const double ingest_at = phase(random);
    worst = std::max(worst, rig.trial(push_at, ingest_at, n % 2 == 0));
  }
  return worst;
}

}  // namespace haptic_bench
