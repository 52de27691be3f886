#include "tools/haptic-bench/cost/servo_stage.h"

#include "tools/haptic-bench/desktop_guard.h"
#include "tools/haptic-bench/failure.h"

namespace haptic_bench {

using namespace hapticd;  // NOLINT(google-build-using-namespace)

namespace {

constexpr int kWarmUp = 100;         // Ticks: armed, and its ramp over.
constexpr double kStiffness = 1000;  // [N/m]

}  // namespace

/** A device that is where it is put and takes every force. */
class ServoStage::Hand final : public Device {
 public:
  Vec3 place = Vec3::Zero();
  DeviceCommand given;

  [[nodiscard]] const DeviceInfo& info() const noexcept override { return info_; }
  [[nodiscard]] Result<void> open() override { return {}; }
  void close() noexcept override {}
  void read(std::int64_t now_ns, DeviceSample& sample) HD_RT override {
    sample.t_ns = now_ns;
    sample.p = place;
    sample.fresh = true;
  }
  void write(std::int64_t, const DeviceCommand& command) HD_RT override { given = command; }
  void safe() noexcept override {}

 private:
  DeviceInfo info_;
};

/**
 * The real clock, but for the time slept away; and without that in which the machine ran something else, after which
 * the guard would take the force away, as from any servo that was late.
 */
class ServoStage::NoWait final : public Clock {
 public:
  [[nodiscard]] std::int64_t now() HD_RT override {
    const std::int64_t t_ns = clock_.now();
    if (t_ns - last_ns_ > kHeldUp_ns) skipped_ns_ -= t_ns - last_ns_;
    last_ns_ = t_ns;
    return t_ns + skipped_ns_;
  }
  void sleepUntil(std::int64_t t_ns) HD_RT override {
    const std::int64_t left_ns = t_ns - now();
    if (left_ns > 0) skipped_ns_ += left_ns;
  }

 private:
  static constexpr std::int64_t kHeldUp_ns = 1'000'000;  // A hundred times what a tick takes.

  MonotonicClock clock_;
  std::int64_t last_ns_ = clock_.now();
  std::int64_t skipped_ns_ = 0;
};

ServoStage::ServoStage(MeshView& mesh, const MeshStroke& stroke) : stroke_(stroke) { meshes_.publish(0, &mesh); }
ServoStage::~ServoStage() = default;

void ServoStage::begin(double radius) {
  radius_ = radius;
  CycleConfig config;
  config.guard[0] = desktopGuard();
  clock_ = std::make_unique<NoWait>();
  hand_ = std::make_unique<Hand>();
  hand_->place = stroke_.at(0, radius + kStrokeAbove);
  servo_ = std::make_unique<Servo>(config, std::array<Device*, kMaxDevices>{hand_.get()}, meshes_, *clock_);
  const auto order = [&](CommandKind kind, const auto& payload) {
    if (!servo_->from_control.push(makeCommand(kind, payload))) throw Failure("servo", "takes no orders", "");
  };
  AddObject object{};
  object.object = makeObjectId(1, 1);
  object.flags = HD_OBJECT_ENABLED;
  object.shape.kind = static_cast<std::uint32_t>(ShapeKind::kMesh);
  object.material.stiffness = kStiffness;
  object.q[0] = 1;
  order(CommandKind::kAddObject, object);
  order(CommandKind::kDeviceRadius, DeviceRadius{0, 0, radius});
  order(CommandKind::kArm, DeviceRef{0});
  servo_->begin();
  for (int i = 0; i < kWarmUp; ++i) servo_->runOnce();
  touched_ = true;
}

void ServoStage::tick(std::size_t i) {
  hand_->place = stroke_.at(i, radius_ - kStrokeDepth);
  servo_->runOnce();
  touched_ = touched_ && hand_->given.enabled && hand_->given.force.squaredNorm() > 0;
}

}  // namespace haptic_bench
