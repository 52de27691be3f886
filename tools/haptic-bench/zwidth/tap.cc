#include "tools/haptic-bench/zwidth/tap.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/device/limits.h"
#include "drivers/sim/sim_device.h"
#include "rt/cycle/cycle.h"
#include "rt/guard/damping_left.h"
#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/zwidth/buzz.h"

namespace haptic_bench::zwidth {
namespace {

using namespace hapticd;  // NOLINT(google-build-using-namespace)

constexpr double kRest_s = 0.05;  // Before the tap; the device is armed in it.

/** The wall is the plane z = 0, solid below. */
class Bench {
 public:
  Bench(const Loop& loop, const Wall& wall) : period_ns_(std::llround(1e9 / loop.rate_hz)), device_(loop.device) {
    if (const Result<void> opened = device_.open(); !opened) throw Failure(opened.error());
    aim(kGap);
    CycleConfig config;
    config.period_ns = period_ns_;
    config.guard[0] = guardOf(loop, wall, device_.info());
    config.guard[0].ramp_ns = period_ns_;
    cycle_ = std::make_unique<Cycle>(config, *meshes_);
    cycle_->setResolution(0, device_.info().position_resolution, device_.info().rotation_resolution);
    AddObject plane{};
    plane.object = makeObjectId(1, 1);
    plane.flags = HD_OBJECT_ENABLED;
    plane.shape.kind = static_cast<std::uint32_t>(ShapeKind::kPlane);
    plane.material = {wall.stiffness, wall.damping, 0, 0};
    plane.q[0] = 1;
    send(CommandKind::kAddObject, plane);
    send(CommandKind::kArm, DeviceRef{0});
  }

  /** Where the hand wants to be. */
  void aim(double z) { device_.setIntent({Vec3(0, 0, z), Quat::Identity(), 0}); }

  void tick() {
    ++input_->tick;
    input_->now_ns += period_ns_;
    input_->device[0].fresh = false;
    device_.read(input_->now_ns, input_->device[0]);
    cycle_->step(*input_, *output_);
    input_->command_count = 0;
    device_.write(input_->now_ns, output_->device[0].command);
  }

  [[nodiscard]] double place() const { return device_.body().position().z(); }
  [[nodiscard]] double depthRead() const { return -input_->device[0].p.z(); }
  [[nodiscard]] double force() const { return output_->device[0].command.force.z(); }
  [[nodiscard]] bool faulted() const { return output_->device[0].guard.fault != HD_FAULT_NONE; }

 private:
  /** As the daemon sets it, with power, slew and what motors bear for ever out of the way: no properties of the loop.
   */
  static GuardConfig guardOf(const Loop& loop, const Wall& wall, DeviceInfo info) {
    info.continuous_force = 0;  // A hand that presses with more than this went through every wall, and all were stable.
    LimitsConfig open;
    open.force_n = info.max_force;
    open.force_slew_n_per_s = loop.force_slew;
    open.power_w = 1000;
    GuardConfig guard;
    guard.limits = startLimits(open, info);
    guard.passivity = loop.passivity;
    guard.delay = info.latency_s * loop.rate_hz;
    // The wall damps as it is told to, more than the device says it bears too: the limit is what is looked for.
    guard.max_damping = std::max(info.max_damping, wall.damping / kMostDampingTogether);
    return guard;
  }

  template <class T>
  void send(CommandKind kind, const T& payload) {
    input_->command[input_->command_count++] = makeCommand(kind, payload);
  }

  std::int64_t period_ns_;
  SimDevice device_;
  std::unique_ptr<MeshTable> meshes_ = std::make_unique<MeshTable>();
  std::unique_ptr<Cycle> cycle_;
  std::unique_ptr<CycleInput> input_ = std::make_unique<CycleInput>();
  std::unique_ptr<CycleOutput> output_ = std::make_unique<CycleOutput>();
};

/** Peak to peak. */
class Span {
 public:
  void add(double x) {
    low_ = std::min(low_, x);
    high_ = std::max(high_, x);
  }
  [[nodiscard]] double size() const { return std::max(0.0, high_ - low_); }

 private:
  double low_ = std::numeric_limits<double>::infinity(), high_ = -std::numeric_limits<double>::infinity();
};

}  // namespace

double trialLength(const Loop& loop) {
  constexpr double kTimes = 50, kLongest_s = 30;
  const SimParameters& p = loop.device.parameters;
  return std::clamp(kTimes * (p.mass + p.hand_mass) / (p.viscous + p.hand_damping), kTrial_s, kLongest_s);
}

Tap tap(const Loop& loop, const Wall& wall) {
  Bench bench(loop, wall);
  const auto ticks = [&](double seconds) { return static_cast<int>(std::lround(seconds * loop.rate_hz)); };
  for (int i = 0; i < ticks(kRest_s); ++i) bench.tick();
  bench.aim(-loop.push / loop.device.parameters.hand_stiffness);

  Span early, late;
  std::vector<double> force;
  double depth = 0, sum = 0;
  bool held = true;
  const int end = ticks(trialLength(loop)), early_begin = ticks(trialLength(loop) / 6);
  for (int i = 0; i < end; ++i) {
    bench.tick();
    if (bench.faulted()) return Tap{};
    if (i >= early_begin && i < early_begin + ticks(kWindow_s)) early.add(bench.place());
    if (i < end - ticks(kWindow_s)) continue;
    late.add(bench.place());
    held = held && bench.force() > 0;
    force.push_back(bench.force());
    sum += bench.force();
    depth += bench.depthRead();
  }
  Tap result;
  result.early_m = early.size();
  result.late_m = late.size();
  result.displayed = depth > 0 ? sum / depth : 0;
  result.buzz = powerAbove(force, loop.rate_hz, kBuzz_hz);
  const double hunting = std::max(kStill, kSteps * loop.device.parameters.resolution);
  result.stable = held && (result.late_m <= kDecay * result.early_m || result.late_m <= hunting);
  return result;
}

}  // namespace haptic_bench::zwidth
