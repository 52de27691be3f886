// A device's encoder steps reach friction, on objects and on local models alike.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "tests/support/stepped/stepped_cycle.h"
#include "tests/support/time.h"
#include "tests/unit/render/model_rig.h"

namespace hapticd {
namespace {

constexpr double kStroke = 3e-5, kPressed = 3e-4, kStatic = 0.6, kDynamic = 0.3;
constexpr int kTicks = 2000;

/** Of the surface: the plane z = 0 of a frame turned so. No axis of the encoders lies in it. */
Quat tilt() { return Quat(Eigen::AngleAxisd(0.6, Vec3(1, 2, 0.5).normalized())); }

/** Slope of the force on an armed hand that goes along it at 5 mm/s, 0.3 mm deep, tick by tick. */
std::array<double, kTicks> slopes(const auto& addSurface) {
  test::SteppedCycle hand(test::openConfig(20));
  hand.cycle->setResolution(0, kStroke, 1e-4);
  hand.put(CommandKind::kAddSession, SessionRef{0, 0, 1});
  hand.arm();
  addSurface(hand);
  std::array<double, kTicks> slope{};
  const Quat turn = tilt();
  for (int i = 0; i < kTicks; ++i) {
    const Vec3 hip = turn * Vec3(3e-6 * i, 4e-6 * i, std::max(-kPressed, 2e-4 - 2e-5 * i));
    const DeviceOutput& out = hand.at(kStroke * (hip.array() / kStroke).round());
    const Vec3 force = turn.conjugate() * out.guard.command.force;
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
  expectOneSlip(slopes([](test::SteppedCycle& hand) {
    const hd_material material{1000, 0, kStatic, kDynamic};
    hand.add(test::solid(makeObjectId(1, 1), ShapeKind::kPlane, material, {Vec3::Zero(), tilt()}));
  }));
}

TEST(CycleFriction, ASlowHandReadInStepsSlidesOnALocalModel) {
  expectOneSlip(slopes([](test::SteppedCycle& hand) {
    hd_local_model plane = modelOf(HD_MODEL_PLANE, 1000);
    plane.lease_ns = 2 * kTicks * kMs;
    plane.material.friction_static = kStatic;
    plane.material.friction_dynamic = kDynamic;
    store(Vec3(tilt() * Vec3::UnitZ()), plane.normal);
    hand.put(CommandKind::kLocalModel, plane, 0);
  }));
}

}  // namespace
}  // namespace hapticd
