/** @file
 * What appears, or is shaped anew, while it moves: what nobody could touch has not moved anybody, and what could be
 * touched goes on moving.
 */
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "tests/support/shape/test_mesh.h"
#include "tests/support/stepped/test_scene.h"

namespace hapticd {
namespace {

using test::kTick;
using test::TestMesh;
using test::TestScene;

const Quat kNotTurned = Quat::Identity();

std::vector<hd_vertex_move> raised(const std::vector<std::array<float, 3>>& from, float by) {
  std::vector<hd_vertex_move> moves;
  for (std::uint32_t v = 0; v < from.size(); ++v) moves.push_back({v, {from[v][0], from[v][1], from[v][2] + by}});
  return moves;
}

/** A plate below the hand, out of touch, that comes about it unseen and is seen in the tick in which it comes. */
TEST(ProxyAppear, WhatComesUnseenPushesNobody) {
  for (const double radius : {0.0, 0.002}) {
    for (const bool by_vertices : {false, true}) {
      for (const bool seen_first : {false, true}) {
        TestScene t(radius);
        TestMesh mesh = test::boxMesh(Vec3(0.02, 0.02, 0.01));
        const auto start = mesh.vertices;
        const auto id = t.addMesh(mesh.deformableView(), {Vec3(0, 0, -0.03), kNotTurned});
        const Vec3 hip(0.001, 0.002, 0);
        t.tick(hip);
        t.flags(id, HD_OBJECT_ENABLED, 0);
        for (int i = 0; i < 30; ++i) t.tick(hip);
        const auto see = [&] { t.flags(id, HD_OBJECT_ENABLED, HD_OBJECT_ENABLED); };
        if (seen_first) see();
        if (by_vertices) {
          ASSERT_EQ(t.moveVertices(id, raised(start, 0.03F)), ErrorCode::kOk);
        } else {
          ASSERT_EQ(t.pose(id, {Vec3::Zero(), kNotTurned}), ErrorCode::kOk);
        }
        if (!seen_first) see();
        for (int i = 0; i < 3; ++i) EXPECT_EQ(t.tick(hip).object, 0u) << radius << by_vertices << seen_first;
        t.tick(Vec3(0, 0, 0.1));
        EXPECT_NEAR(t.tick(Vec3(0, 0, 0.009)).force.z(), 1000 * (radius + 0.001), 1e-6) << "when it has left";
      }
    }
  }
}

/** The same of a mesh whose vertices have moved before an object is given it. */
TEST(ProxyAppear, AMeshThatMovedUnseenPushesNobody) {
  TestScene t;
  TestMesh shown = test::boxMesh(Vec3(0.02, 0.02, 0.001)), next = test::boxMesh(Vec3(0.02, 0.02, 0.01));
  const auto start = next.vertices;
  const auto other = t.addMesh(next.deformableView(), {Vec3(1, 0, 0), kNotTurned});
  const auto id = t.addMesh(shown.view(), {Vec3(0, 0, -0.03), kNotTurned});
  const Vec3 hip(0.001, 0.002, 0);
  t.tick(hip);
  ASSERT_EQ(t.moveVertices(other, raised(start, 0.03F)), ErrorCode::kOk);
  ASSERT_EQ(t.setShape(id, {static_cast<std::uint32_t>(ShapeKind::kMesh), objectSlot(other), {}}), ErrorCode::kOk);
  EXPECT_EQ(t.tick(hip).object, 0u);
}

/** A ball whose centre comes out of what has appeared about it, while vertices of that move elsewhere. */
TEST(ProxyAppear, ABallComesOutOfAMeshThatMovesWithoutAKick) {
  TestScene t(0.003);
  TestMesh mesh = test::boxMesh(Vec3(0.02, 0.02, 0.01));
  const std::array<float, 3> corner = mesh.vertices[0];
  const auto id = t.addMesh(mesh.deformableView());
  t.tick(Vec3::Zero());
  for (int i = 1; i < 200; ++i) {
    ASSERT_EQ(t.moveVertices(id, {{0, {corner[0], corner[1], corner[2] - 1e-6F * static_cast<float>(i)}}}),
              ErrorCode::kOk);
    const SurfaceContact& c = t.tick(Vec3(0.001, 0.002, 1e-4 * i));
    ASSERT_LT(c.force.norm(), 1e-6) << i;
  }
  EXPECT_NEAR(t.tick(Vec3(0.001, 0.002, 0.012)).force.z(), 1, 1e-6) << "as large as ever";
}

/**
 * A ball appears about who presses on a box deep below the top and deeper yet below its side, and reaches to both, but
 * not to the edge between them: the hand goes from the one to the other as if it were not there.
 */
TEST(ProxyAppear, AWayAroundAnEdgeLeadsPastWhatHasAppearedAboutBothItsEnds) {
  for (const double radius : {0.0, 5e-4}) {
    for (const double mu : {0.0, 0.1}) {
      const hd_material material{1000, 0, mu, 0.7 * mu};
      TestScene t(radius), plain(radius);
      const double deep = 0.01;
      for (TestScene* s : {&t, &plain})
        s->add(ShapeKind::kBox, Vec3::Constant(0.03), {Vec3::Constant(-0.03), kNotTurned}, material);
      Vec3 hip;
      const auto tick = [&](double x, double z) {
        hip = Vec3(x, -0.03, z);
        plain.tick(hip);
        return t.tick(hip).force;
      };
      for (int i = 0; i <= 100; ++i) tick(-1.2 * deep, 0.01 - (0.01 + deep) * i / 100);
      t.add(ShapeKind::kSphere, Vec3(1.4 * deep, 0, 0), {Vec3(-deep, -0.03, -deep), kNotTurned}, material);
      bool over = false;
      for (int i = 0; i <= 100; ++i) {
        const Vec3 force = tick(-(1.2 - 0.004 * i) * deep, -deep);
        ASSERT_NEAR((force - plain.contact.force).norm(), 0, 1e-6) << radius << " " << mu << ", step " << i;
        over = over || force.x() > 2 * std::abs(force.z());
      }
      EXPECT_TRUE(over) << "the edge was never passed";
    }
  }
}

/** Nor do things below one that appears lose whom they carry. */
TEST(ProxyAppear, WhatHangsOnAnObjectThatAppearsGoesOnCarrying) {
  TestScene t;
  const auto arm = t.add(ShapeKind::kSphere, Vec3(0.001, 0, 0), {Vec3(0, 0, -0.5), kNotTurned}, {1000, 0, 0, 0}, 0);
  t.add(ShapeKind::kBox, Vec3(0.02, 0.02, 0.01), {Vec3(0, 0, 0.47), kNotTurned}, {1000, 0, 0, 0}, test::kOneSided, arm);
  const Vec3 hip(0.001, 0.002, -0.019);
  t.tick(hip);
  t.pose(arm, {Vec3(0, 0, -0.5), kNotTurned}, {Vec3(0, 0, 0.1), Vec3::Zero()});
  for (int i = 1; i < 100; ++i) {
    if (i == 50) t.flags(arm, HD_OBJECT_ENABLED, HD_OBJECT_ENABLED);
    ASSERT_NEAR(t.tick(hip).force.z(), 1000 * std::max(0.0, 1e-4 * (i - 1) - 0.001), 1e-6) << i;
  }
}

/** A plate that lifts the hand and is given a shape: the same, or one that is lower. */
TEST(ProxyAppear, WhatIsShapedAnewWhileItMovesGoesOnCarrying) {
  for (const double half : {0.01, 0.0095}) {
    TestScene t;
    const auto id = t.add(ShapeKind::kBox, Vec3(0.02, 0.02, 0.01), {Vec3(0, 0, -0.02), kNotTurned});
    const Vec3 hip(0.001, 0.002, 0);
    t.tick(hip);
    t.pose(id, {Vec3(0, 0, -0.02), kNotTurned}, {Vec3(0, 0, 0.1), Vec3::Zero()});
    for (int i = 1; i < 150; ++i) {
      if (i == 120) {
        ASSERT_EQ(t.setShape(id, {static_cast<std::uint32_t>(ShapeKind::kBox), 0, {0.02, 0.02, half}}), ErrorCode::kOk);
      }
      const double top = -0.02 + 1e-4 * (i - 1) + (i < 120 ? 0.01 : half);
      ASSERT_NEAR(t.tick(hip).force.z(), 1000 * std::max(0.0, top), 1e-6) << half << " " << i;
    }
  }
}

}  // namespace
}  // namespace hapticd
