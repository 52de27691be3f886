// A device's encoder steps reach friction, on objects and on local models alike.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "rt/cycle/cycle.h"
#include "tests/support/time.h"
#include "tests/unit/rt/model_rig.h"

namespace hapticd {
namespace {

constexpr double kStroke = 3e-5, kPressed = 3e-4, kStatic = 0.6, kDynamic = 0.3;
constexpr int kTicks = 2000;

/** Of the surface: the plane z = 0 of a frame turned so. No axis of the encoders lies in it. */
Quat tilt() { return Quat(Eigen::AngleAxisd(0.6, Vec3(1, 2, 0.5).normalized())); }

/** Slope of the force on an armed hand that goes along it at 5 mm/s, 0.3 mm deep, tick by tick. */
std::array<double, kTicks> slopes(const auto& addSurface) {
  MeshTable meshes;
  CycleConfig config;
  config.guard[0].limits = {20, 1, 1e6, 1e3, 1, 10, 50, 50};
  config.guard[0].ramp_ns = kMs;
  const auto cycle = std::make_unique<Cycle>(config, meshes);
  cycle->setResolution(0, kStroke, 1e-4);
  const auto input = std::make_unique<CycleInput>();
  const auto output = std::make_unique<CycleOutput>();
  const auto put = [&](CommandKind kind, const auto& payload, std::uint32_t session) {
    Command& c = input->command[input->command_count++];
    c = Command{};
    c.kind = kind;
    c.session = session;
    c.as<std::decay_t<decltype(payload)>>() = payload;
  };
  put(CommandKind::kAddSession, SessionRef{0, 0, 1}, kControlSession);
  put(CommandKind::kArm, DeviceRef{0}, kControlSession);
  addSurface(put);
  std::array<double, kTicks> slope{};
  const Quat turn = tilt();
  for (int i = 0; i < kTicks; ++i) {
    ++input->tick;
    input->now_ns += kMs;
    const Vec3 hip = turn * Vec3(3e-6 * i, 4e-6 * i, std::max(-kPressed, 2e-4 - 2e-5 * i));
    input->device[0].t_ns = input->now_ns;
    input->device[0].p = kStroke * (hip.array() / kStroke).round();
    input->device[0].fresh = true;
    cycle->step(*input, *output);
    input->command_count = 0;
    const Vec3 force = turn.conjugate() * output->device[0].guard.command.force;
    if (force.z() > 0) slope[static_cast<std::size_t>(i)] = std::hypot(force.x(), force.y()) / force.z();
  }
  return slope;
}

void expectOneSlip(const std::array<double, kTicks>& slope) {
  const auto slip = std::max_element(slope.begin(), slope.begin() + kTicks / 4);
  EXPECT_GT(*slip, 0.75 * kStatic);
  for (auto s = slip + 50; s != slope.end(); ++s)
    ASSERT_NEAR(*s, kDynamic, 0.5 * (kStatic - kDynamic)) << s - slope.begin();
}

TEST(CycleFriction, ASlowHandReadInStepsSlidesOnAnObject) {
  expectOneSlip(slopes([](const auto& put) {
    AddObject plane{};
    plane.object = makeObjectId(1, 1);
    plane.flags = HD_OBJECT_ENABLED;
    plane.shape.kind = static_cast<std::uint32_t>(ShapeKind::kPlane);
    plane.material = {1000, 0, kStatic, kDynamic};
    store(tilt(), plane.q);
    put(CommandKind::kAddObject, plane, kControlSession);
  }));
}

TEST(CycleFriction, ASlowHandReadInStepsSlidesOnALocalModel) {
  expectOneSlip(slopes([](const auto& put) {
    hd_local_model plane = modelOf(HD_MODEL_PLANE, 1000);
    plane.lease_ns = 2 * kTicks * kMs;
    plane.material.friction_static = kStatic;
    plane.material.friction_dynamic = kDynamic;
    store(Vec3(tilt() * Vec3::UnitZ()), plane.normal);
    put(CommandKind::kLocalModel, plane, 0);
  }));
}

}  // namespace
}  // namespace hapticd
