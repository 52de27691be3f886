/** @file
 * A solid that gets another shape under the hand that presses it goes on holding it.
 */
#include <gtest/gtest.h>

#include "tests/support/random.h"
#include "tests/support/shape/test_mesh.h"
#include "tests/support/stepped/test_scene.h"

namespace hapticd {
namespace {

using test::kTick;
using test::TestMesh;

constexpr double kOldStiffness = 1000;
constexpr std::uint32_t kOtherMesh = 20;

class Reshaped : public test::TestScene {
 public:
  using TestScene::TestScene;
  const SurfaceContact& tick(const Vec3& hip) {
    scene->expect(kTick, ++number_);
    return TestScene::tick(hip);
  }
  const SurfaceContact& rest(const Vec3& hip) {
    for (int i = 0; i < 20; ++i) tick(hip);
    return tick(hip);
  }
  const SurfaceContact& press(const Vec3& from, const Vec3& hip) {
    for (int i = 0; i <= 100; ++i) tick(from + 0.01 * i * (hip - from));
    return rest(hip);
  }
  ErrorCode become(std::uint32_t id, MeshView* mesh) {
    table->publish(kOtherMesh, mesh);
    ShapeParameters shape{};
    shape.kind = static_cast<std::uint32_t>(ShapeKind::kMesh);
    shape.mesh = kOtherMesh;
    return setShape(id, shape);
  }
  ErrorCode becomeBox(std::uint32_t id, const Vec3& half) {
    ShapeParameters shape{};
    shape.kind = static_cast<std::uint32_t>(ShapeKind::kBox);
    for (int axis = 0; axis < 3; ++axis) shape.size[axis] = half[axis];
    return setShape(id, shape);
  }

 private:
  std::uint64_t number_ = 0;
};

// Wherever the new facets stood out by some micrometres the force ended within a tick, and the hand fell through.
TEST(ProxyReshape, OtherTrianglesOfOneSurfaceHoldTheHandAsIfTheyHadBeenThere) {
  Random random(5);
  TestMesh coarse = test::sphereMesh(0.05, 24), fine = test::sphereMesh(0.05, 60);
  int outside = 0;
  for (int i = 0; i < 60; ++i) {
    const double radius = i % 2 == 0 ? 0 : 0.001;
    const Vec3 n = random.vector(1).normalized(), hip = 0.047 * n;
    Reshaped t(radius), fresh(radius);
    const auto id = t.addMesh(coarse.view(), {}, {kOldStiffness, 0, 0, 0});
    fresh.addMesh(fine.view(), {}, {kOldStiffness, 0, 0, 0});
    const Vec3 before = t.press(0.06 * n, hip).force, wanted = fresh.press(0.06 * n, hip).force;
    ASSERT_GT(before.norm(), 2);
    if (wanted.norm() > before.norm()) ++outside;
    ASSERT_EQ(t.become(id, fine.view()), ErrorCode::kOk);
    const Vec3 at_once = t.tick(hip).force;
    EXPECT_NEAR(at_once.norm(), before.norm(), kOldStiffness * 0.001) << i;
    EXPECT_LT((t.rest(hip).force - wanted).norm(), 0.02 * wanted.norm()) << radius << ", " << i;
  }
  EXPECT_GT(outside, 20) << "the fine one stands out, for it has its corners on the same sphere";
}

TEST(ProxyReshape, WhatGrowsByLessThanTheHandPressesPushesItAndByMoreIsNotFelt) {
  for (const double radius : {0.0, 0.001}) {
    for (const double grown : {-0.001, 0.0005, 0.0015, 0.003}) {
      Reshaped t(radius);
      const auto id = t.add(ShapeKind::kBox, {0.02, 0.02, 0.02}, {}, {kOldStiffness, 0, 0, 0});
      const Vec3 hip(0.001, 0.002, 0.018 + radius);
      EXPECT_NEAR(t.press({0.001, 0.002, 0.03}, hip).force.z(), 2, 1e-6);
      ASSERT_EQ(t.becomeBox(id, {0.02, 0.02, 0.02 + grown}), ErrorCode::kOk);
      if (radius > 0 && grown > 0.002) continue;  // The ball shrinks where it is.
      const double wanted = grown < 0.002 ? kOldStiffness * (0.002 + grown) : 0;
      EXPECT_NEAR(t.tick(hip).force.z(), wanted, 1e-5) << radius << ", " << grown;
      EXPECT_NEAR(t.rest(hip).force.z(), wanted, 1e-5) << radius << ", " << grown;
    }
  }
}

TEST(ProxyReshape, NobodyIsPushedThroughSomethingElse) {
  Reshaped t;
  const auto id = t.add(ShapeKind::kBox, {0.02, 0.02, 0.02}, {}, {kOldStiffness, 0, 0, 0});
  const Vec3 hip(0.001, 0.002, 0.018);
  t.press({0.001, 0.002, 0.03}, hip);
  t.add(ShapeKind::kBox, {0.05, 0.05, 0.0001}, {Vec3(0, 0, 0.0203), Quat::Identity()}, {kOldStiffness, 0, 0, 0});
  t.rest(hip);
  ASSERT_EQ(t.becomeBox(id, {0.02, 0.02, 0.021}), ErrorCode::kOk);
  for (int i = 0; i < 20; ++i) EXPECT_LT(t.tick(hip).proxy.z(), 0.0203) << i;
}

TEST(ProxyReshape, WhatHasJumpedAsWellIsNotFollowed) {
  Reshaped t;
  const auto id = t.add(ShapeKind::kBox, {0.02, 0.02, 0.02}, {}, {kOldStiffness, 0, 0, 0});
  const Vec3 hip(0.001, 0.002, 0.018);
  t.press({0.001, 0.002, 0.03}, hip);
  ASSERT_EQ(t.becomeBox(id, {0.02, 0.02, 0.0205}), ErrorCode::kOk);
  ASSERT_EQ(t.pose(id, {Vec3(0.001, 0, 0), Quat::Identity()}), ErrorCode::kOk);
  EXPECT_EQ(t.rest(hip).object, 0u);
}

}  // namespace
}  // namespace hapticd
