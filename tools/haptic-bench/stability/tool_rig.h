/** @file
 * A tool on the simulated device with its hand, against a solid: servo and collision at their own rates, stepped by
 * hand, books kept at the port.
 */
#pragma once

#include <cmath>
#include <cstdlib>
#include <memory>
#include <string>

#include "drivers/sim/sim_device.h"
#include "rt/body/contact_model.h"
#include "rt/body/tool.h"
#include "rt/contact/detector.h"

namespace haptic_bench {

using namespace hapticd;  // NOLINT(google-build-using-namespace)

struct RigOptions {
  std::string uri = "sim://default?dof=6";
  double rate_hz = 1000;
  int collide_every = 1;  ///< Servo ticks for each collision query ...
  int late = 0;           ///< ... whose contacts come so many ticks later.
  double mass = 0.2;
  double stiffness = 0;  ///< CouplingNeeds::wanted.
  double friction = 0.4;
  Vec3 size = Vec3(0.03, 0.03, 0.03);  ///< Box whose inertia the tool has ...
  Vec3 middle = Vec3::Zero();          ///< ... and where it is in the tool's frame: there the hand holds it.
  Vec3 weight = Vec3::Zero();
  bool follow_touches = true;  ///< False: gaps stay as the detector saw them until it answers again.
};

class ToolRig {
 public:
  /** `tool` and `base` null: the detector knows its shapes itself. All outlive the rig. */
  ToolRig(const RigOptions& options, Detector& detector, const VolumeView* tool, const VolumeView* base,
          Response& response)
      : options_(options),
        dt_(1 / options.rate_hz),
        device_(resolveSim(parseDeviceUri(options.uri).value()).value()),
        detector_(detector),
        response_(response) {
    detector_.reset();
    query_.a.volume = tool;
    query_.b.volume = base;
    ToolSetup setup;
    setup.mass = MassProperties::ofBox(options.mass, options.size);
    setup.weight = options.weight;
    setup.mass.com_O = options.middle;
    setup.grip_O = options.middle;
    CouplingNeeds needs{options.mass, setup.mass.inertia_O.trace() / 3, dt_, options.stiffness};
    setup.gains = chooseGains(device_.info(), needs);
    tool_ = std::make_unique<Tool>(setup);
    if (!device_.open()) std::abort();
    device_.read(now_ns_, sample_);
    tool_->reset(handle());
  }

  /** Where the hand wants to be from now on. */
  void aim(const Vec3& p, const Vec3& turn = Vec3::Zero()) { device_.setIntent({p, fromRotationVector(turn), 0}); }
  /** Puts hand, device and tool there. */
  void start(const Vec3& p, const Vec3& turn = Vec3::Zero()) {
    aim(p, turn);
    for (int i = 0; i < 3000; ++i) tick(false);
    tool_->reset(handle());
    detector_.reset();
    asked_ = tool_->body().pose();
    model_.count = pending_.count = 0;
    step_ = ToolStep{};
    created_ = -1;
    fastest_ = strongest_ = 0;
  }

  void tick(bool touching = true) {
    now_ns_ += std::llround(dt_ * 1e9);
    const Pose before = handle();
    device_.read(now_ns_, sample_);
    if (touching) observe();
    std::array<Touch, kMaxTouches> touches;
    const std::uint32_t n = touching ? model_.count : 0;
    const Pose seen = options_.follow_touches ? tool_->body().pose() : seen_;
    for (std::uint32_t i = 0; i < n; ++i) touches[i] = model_.touch(i, seen, tool_->body().com(), Pose{}, Twist{});
    for (std::uint32_t i = 0; i < n; ++i) touches[i].friction = options_.friction;

    const double held = books();
    const Wrench sent = step_.on_device;
    const Pose now = handle();
    const Vec3 dx = now.p - before.p;
    const Vec3 turn = rotationVector(now.q * before.q.conjugate());
    tool_->step(now, {touches.data(), n}, dt_, response_, step_);
    DeviceCommand command;
    command.force = step_.on_device.force;
    command.torque = step_.on_device.torque;
    command.enabled = true;
    device_.write(now_ns_, command);
    ++ticks_;

    // Beyond what the hand gave and what a held force may leak (coupling.h).
    const CouplingGains& g = tool_->setup().gains;
    const double given = -sent.force.dot(dx) - sent.torque.dot(turn);
    const double leak = 0.5 * (g.outer * dx.squaredNorm() + g.angular_outer * turn.squaredNorm());
    // The leak of the turn is to second order; what is beyond goes with the cube.
    const double rounding = 1e-12 + 0.01 * leak;
    created_ = std::max(created_, books() - held - given - leak - rounding);
    fastest_ = std::max(fastest_, tool_->body().twist().v.norm());
    strongest_ = std::max(strongest_, step_.on_device.force.norm());
    finite_ = finite_ && isFinite(step_.on_device.force) && isFinite(step_.on_device.torque) &&
              isFinite(tool_->body().com()) && isFinite(tool_->body().orientation());
  }
  void run(double seconds) {
    for (auto n = std::llround(seconds / dt_); n > 0; --n) tick();
  }
  /** Peak to peak of the device point and of the tool over so long [m]. */
  struct Unrest {
    double device = 0, tool = 0;
  };
  Unrest watch(double seconds) {
    const auto box = [](const Vec3& x, Vec3& low, Vec3& high) {
      low = low.cwiseMin(x);
      high = high.cwiseMax(x);
    };
    Vec3 d0 = device_.body().position(), d1 = d0, t0 = tool_->body().com(), t1 = t0;
    for (auto n = std::llround(seconds / dt_); n > 0; --n) {
      tick();
      box(device_.body().position(), d0, d1);
      box(tool_->body().com(), t0, t1);
    }
    return {(d1 - d0).norm(), (t1 - t0).norm()};
  }

  [[nodiscard]] Tool& tool() { return *tool_; }
  [[nodiscard]] SimDevice& device() { return device_; }
  [[nodiscard]] const ToolStep& last() const { return step_; }
  [[nodiscard]] double created() const { return created_; }  ///< Most energy that one tick made of nothing [J].
  [[nodiscard]] double fastest() const { return fastest_; }
  [[nodiscard]] double strongest() const { return strongest_; }
  [[nodiscard]] bool finite() const { return finite_; }
  [[nodiscard]] std::uint64_t ticks() const { return ticks_; }

 private:
  [[nodiscard]] Pose handle() const { return {sample_.p, sample_.q}; }
  [[nodiscard]] double books() const {
    return tool_->energy() + tool_->reserve() - options_.weight.dot(tool_->body().com());
  }
  /** Asks the detector when it is its turn, and hands its answer over when that is due. */
  void observe() {
    const auto every = static_cast<std::uint64_t>(options_.collide_every);
    if (ticks_ % every == 0) {
      DetectorQuery& query = query_;
      query.a.X_WO_before = asked_;
      query.a.X_WO = tool_->body().pose();
      query.a.V_WO = tool_->body().twist();
      const double reach = 1.5 * (options_.collide_every + options_.late) * dt_ *
                           (query.a.V_WO.v.norm() + query.a.V_WO.w.norm() * options_.size.norm() / 2);
      query.margin = 0.002 + reach;
      detector_.find(query, found_);
      const ContactBody body;
      pending_.build(found_, query.a.X_WO, {&body, 1}, reach);
      asked_ = query.a.X_WO;
    }
    if (ticks_ % every == static_cast<std::uint64_t>(options_.late) % every) {
      model_ = pending_;
      seen_ = asked_;
    }
  }

  RigOptions options_;
  double dt_;
  SimDevice device_;
  Detector& detector_;
  DetectorQuery query_;
  Response& response_;
  std::unique_ptr<Tool> tool_;
  ContactSet found_;
  ContactModel model_, pending_;
  Pose asked_, seen_;  ///< Tool's pose at the last query, and at that of model_.
  DeviceSample sample_;
  ToolStep step_;
  std::int64_t now_ns_ = 0;
  std::uint64_t ticks_ = 0;
  double created_ = -1, fastest_ = 0, strongest_ = 0;
  bool finite_ = true;
};

}  // namespace haptic_bench
