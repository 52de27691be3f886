/** @file
 * Meshes whose vertices move under the hand.
 */
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <utility>
#include <vector>

#include "tests/support/shape/test_mesh.h"
#include "tests/support/stepped/test_scene.h"

namespace hapticd {
namespace {

using test::TestMesh;
using test::TestScene;

/** A sheet of n x n quads at z = 0, and its vertices moved to z = f(x, y). */
struct Sheet {
  explicit Sheet(std::uint32_t n) : mesh(test::heightMesh(0.05, n, [](double, double) { return 0.0; })) {}

  template <class F>
  std::vector<hd_vertex_move> at(F f) const {
    std::vector<hd_vertex_move> moves;
    for (std::uint32_t i = 0; i < mesh.vertices.size(); ++i) {
      const auto& v = mesh.vertices[i];
      moves.push_back({i, {v[0], v[1], static_cast<float>(f(v[0], v[1]))}});
    }
    return moves;
  }

  TestMesh mesh;
};

TEST(ProxyOnDeformable, ARisingSheetPushesTheHandItTouchesAndTheOneItMeets) {
  for (const bool two_sided : {false, true}) {
    for (const Vec3& hip : {Vec3(0.0013, 0.0021, -0.001), Vec3(0.0013, 0.0021, 0.0023), Vec3(0.01, 0.01, 0.0023)}) {
      Sheet sheet(10);
      TestScene t;
      const auto id = t.addMesh(sheet.mesh.deformableView(), {}, {1000, 0, 0, 0},
                                two_sided ? 0u + HD_OBJECT_ENABLED + HD_OBJECT_TWO_SIDED : 0u + HD_OBJECT_ENABLED);
      t.tick(Vec3(hip.x(), hip.y(), 0.005));
      t.tick(hip);
      for (int i = 1; i <= 60; ++i) {  // Up by 6 mm in steps of 0.1 mm, down again in steps of 1 mm, up in one.
        const double z = i <= 40 ? 1e-4 * i : (i <= 44 ? 4e-3 - 1e-3 * (i - 40) : (i < 50 ? 0 : 0.004));
        ASSERT_EQ(t.moveVertices(id, sheet.at([&](double, double) { return z; })), ErrorCode::kOk);
        const double force = t.tick(hip).force.z();
        ASSERT_NEAR(force, 1000 * std::max(0.0, double{static_cast<float>(z)} - hip.z()), 1e-8) << i << " " << z;
      }
    }
  }
}

/** More triangles come near the hand than are swept past it. */
TEST(ProxyOnDeformable, ASheetThatRisesByManyOfItsEdgesPushesTheHand) {
  for (const Vec3& hip : {Vec3(0.0013, 0.0021, -0.002), Vec3(-0.041, 0.032, -0.011), Vec3(0.043, 0.046, -0.017)}) {
    Sheet sheet(36);
    TestScene t;
    const auto id = t.addMesh(sheet.mesh.deformableView(), {}, {1000, 0, 0, 0});
    ASSERT_EQ(t.moveVertices(id, sheet.at([](double, double) { return -0.02; })), ErrorCode::kOk);
    t.tick(hip);
    ASSERT_EQ(t.contact.object, 0u);
    ASSERT_EQ(t.moveVertices(id, sheet.at([](double, double) { return 0; })), ErrorCode::kOk);
    ASSERT_NEAR(t.tick(hip).force.z(), -1000 * hip.z(), 1e-8);
  }
}

TEST(ProxyOnDeformable, AWaveNeverPassesTheProxy) {
  for (const auto& [mu, speed] : {std::pair(0.0, 0.05), {0.5, 0.05}, {0.0, 0.3}, {0.5, 1.0}}) {
    Sheet sheet(24);
    TestScene t;
    const auto id = t.addMesh(sheet.mesh.deformableView(), {}, {1000, 0, mu, mu});
    t.tick(Vec3(0, 0, 0.02));
    int contacts = 0;
    for (int i = 1; i <= 300; ++i) {
      const double phase = speed * i;
      const auto wave = [phase](double x, double y) { return 0.003 * std::sin(100 * x - phase) * std::cos(60 * y); };
      ASSERT_EQ(t.moveVertices(id, sheet.at(wave)), ErrorCode::kOk);
      const Vec3 hip(0.02 * std::sin(0.02 * i), 0.02 * std::cos(0.033 * i), -0.001 + 0.003 * std::sin(0.1 * i));
      const SurfaceContact& c = t.tick(hip);
      contacts += c.object != 0;
      // From far above straight down onto the sheet: the proxy is not below where that arrives.
      Sweep sweep;
      sweep.a = Vec3(c.proxy.x(), c.proxy.y(), 1);
      sweep.d = Vec3(0, 0, -2);
      sweep.limit = 100000;
      SweepHit hit;
      ASSERT_EQ(sweepMesh(*t.scene->find(id)->shape.mesh, sweep, hit), SweepResult::kHit);
      ASSERT_GT(c.proxy.z(), 1 - 2 * hit.t - 1e-9) << i;
    }
    EXPECT_GT(contacts, 100);
  }
}

/** A ball over a sheet of which one row or vertex rises. */
TEST(ProxyOnDeformable, AnEdgeAndAVertexThatRisePushABallUp) {
  constexpr double kRadius = 0.004;
  for (const bool one_vertex : {false, true}) {
    for (const double step : {1e-4, 1e-3, 3e-3}) {
      Sheet sheet(10);
      TestScene t(kRadius);
      const auto id = t.addMesh(sheet.mesh.deformableView(), {}, {1000, 0, 0, 0});
      const Vec3 hip(0, 0, kRadius - 0.001);
      t.tick(hip + Vec3(0, 0, 0.01));
      t.tick(hip);
      for (int i = 1; i <= 8; ++i) {  // Up, and at once down again.
        const double z = i < 8 ? std::min(step * i, 0.003) : 0;
        const auto moves = sheet.at(
            [&](double x, double y) { return std::abs(x) < 1e-4 && (!one_vertex || std::abs(y) < 1e-4) ? z : 0.0; });
        ASSERT_EQ(t.moveVertices(id, moves), ErrorCode::kOk);
        const SurfaceContact& c = t.tick(hip);
        ASSERT_NEAR(c.force.z(), 1000 * (double{static_cast<float>(z)} + 0.001), 1e-8)
            << one_vertex << " " << step << " " << i;
        ASSERT_LT(c.force.head<2>().norm(), 1e-8);
      }
    }
  }
}

/** Two plates of one mesh close on a ball: it stays between them, in the middle, as large as there is room, and is let
 * go unharmed. */
TEST(ProxyOnDeformable, PlatesThatCloseOnABallKeepItBetweenThem) {
  constexpr double kRadius = 0.002;
  for (const double step : {1e-4, 1e-3, 3e-3}) {
    TestMesh mesh = test::boxMesh(Vec3(0.02, 0.02, 0.001), Vec3(0, 0, -0.006));
    const auto lower = static_cast<std::uint32_t>(mesh.vertices.size());
    const TestMesh above = test::boxMesh(Vec3(0.02, 0.02, 0.001), Vec3(0, 0, 0.006));
    for (const auto& v : above.vertices) mesh.vertices.push_back(v);
    for (const auto& f : above.triangles) mesh.addTriangle(lower + f[0], lower + f[1], lower + f[2]);
    const auto start = mesh.vertices;
    TestScene t(kRadius);
    const auto id = t.addMesh(mesh.deformableView());
    t.tick(Vec3::Zero());
    for (int i = 1; i < 220; ++i) {
      const double rise = std::clamp(std::min(step * i, 0.0095 - step * (i - 110)), 0.0, 0.0095);
      std::vector<hd_vertex_move> moves;
      for (std::uint32_t v = 0; v < lower; ++v)
        moves.push_back({v, {start[v][0], start[v][1], static_cast<float>(start[v][2] + rise)}});
      ASSERT_EQ(t.moveVertices(id, moves), ErrorCode::kOk);
      const double z = t.tick(Vec3::Zero()).proxy.z(), floor = -0.005 + rise, room = 0.005 - floor;
      const double radius = i < 110 ? std::min(kRadius, 0.4 * room) : 0;  // It grows again when it lifts.
      ASSERT_GT(z, floor + radius - 1e-8) << step << " " << i;
      ASSERT_LT(z, 0.005 - radius + 1e-8) << step << " " << i;
    }
    EXPECT_EQ(t.contact.object, 0u);
    EXPECT_NEAR(t.tick(Vec3(0, 0, -0.005)).proxy.z(), kRadius - 0.005, 1e-8);
  }
}

/** Vertices that move out of touch change not a bit of what is felt. */
TEST(ProxyOnDeformable, WhatMovesElsewhereIsNotFelt) {
  for (const double radius : {0.0, 0.002}) {
    for (const double friction : {0.0, 0.6}) {
      TestScene still, moving;
      TestMesh mesh = test::sphereMesh(0.03, 5), far = test::sphereMesh(0.03, 5);
      const Pose X{Vec3(0.01, 0.02, 0.03), Quat(Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()))};
      MeshView* const view = mesh.view();
      for (TestScene* t : {&still, &moving}) {
        t->addMesh(view, X, {1000, 0, friction, 0.7 * friction});
        t->proxy.setRadius(radius);
        t->tick(Vec3(0, 0, 0.2));
      }
      const auto id = moving.addMesh(far.deformableView(), {Vec3(0.5, 0.5, 0.5), Quat::Identity()});
      int contacts = 0;
      for (int i = 0; i < 2000; ++i) {
        const auto by = static_cast<float>(1 + 0.1 * std::sin(i));
        const auto& v = mesh.vertices[7];
        ASSERT_EQ(moving.moveVertices(id, {{7, {by * v[0], by * v[1], by * v[2]}}}), ErrorCode::kOk);
        const Vec3 hip = X * Vec3(0.03 * std::sin(0.011 * i), 0.03 * std::sin(0.017 * i), 0.03 * std::cos(0.007 * i));
        const SurfaceContact &one = still.tick(hip), &other = moving.tick(hip);
        contacts += one.object != 0;
        ASSERT_EQ(one.proxy, other.proxy) << i;
        ASSERT_EQ(one.force, other.force) << i;
        ASSERT_EQ(one.slip, other.slip) << i;
      }
      EXPECT_GT(contacts, 300);
    }
  }
}

/** A vertex of the same mesh that jumps far away widens the search, but leaves out nothing of what is at the hand. */
TEST(ProxyOnDeformable, AVertexThatJumpsElsewhereIsNotFeltOnARisingSheet) {
  for (const Vec3& hip : {Vec3(0.0003, 0.0002, 0), Vec3(0.0143, 0.0136, 0), Vec3(-0.0152, 0.0111, 0)}) {
    Sheet plain(33), jumping(33);
    for (Sheet* s : {&plain, &jumping}) {
      for (auto& v : s->mesh.vertices) v = {v[0] * 0.33F, v[1] * 0.33F, 0};  // 1 mm apart.
      const auto a = s->mesh.addVertex({0.7, 0, 0}), b = s->mesh.addVertex({0.7, 0.001, 0});
      s->mesh.addTriangle(a, b, s->mesh.addVertex({0.701, 0, 0}));
    }
    TestScene still, moving;
    const auto sheet = still.addMesh(plain.mesh.deformableView()),
               other = moving.addMesh(jumping.mesh.deformableView());
    for (TestScene* t : {&still, &moving}) {
      t->tick(hip + Vec3(0, 0, 0.001));
      t->tick(hip);
    }
    for (int i = 1; i <= 30; ++i) {
      auto moves = plain.at([&](double x, double) { return x < 0.5 ? 2e-4 * i : 0.0; });
      ASSERT_EQ(still.moveVertices(sheet, moves), ErrorCode::kOk);
      moves.back().p[2] = i % 2 == 0 ? 0.0F : 0.5F;
      ASSERT_EQ(moving.moveVertices(other, moves), ErrorCode::kOk);
      const SurfaceContact &one = still.tick(hip), &two = moving.tick(hip);
      ASSERT_NEAR(one.force.z(), 0.2 * i, 1e-6) << i;
      ASSERT_EQ(one.force, two.force) << i;
    }
  }
}

/** A tick's moves are gone through for the mesh that moves, not for all that stand about. */
TEST(ProxyOnDeformable, MeshesThatDoNotMoveCostNextToNothing) {
  const auto cost = [](int others, double radius) {
    Sheet sheet(30);
    TestMesh box = test::boxMesh(Vec3(0.01, 0.01, 0.01)), still = test::boxMesh(Vec3(0.01, 0.01, 0.01));
    MeshView *const rigid = box.view(), *const deformable = still.deformableView();
    TestScene t(radius);
    const auto id = t.addMesh(sheet.mesh.deformableView());
    for (int i = 0; i < others; ++i)
      t.addMesh(i % 2 == 0 ? rigid : deformable, {Vec3(1 + 0.1 * i, 0, 0), Quat::Identity()});
    t.tick(Vec3(0, 0, 0.02));
    double least = 1;
    for (int i = 0; i < 40; ++i) {
      EXPECT_EQ(t.moveVertices(id, sheet.at([&](double, double) { return 1e-5 * i; })), ErrorCode::kOk);
      t.scene->advance(test::kTick);
      timespec begin{}, end{};
      clock_gettime(CLOCK_THREAD_CPUTIME_ID, &begin);
      t.proxy.step(*t.scene, Vec3(0, 0, 0.02), Vec3::Zero(), test::kTick, t.contact);
      clock_gettime(CLOCK_THREAD_CPUTIME_ID, &end);
      least = std::min(least, double(end.tv_sec - begin.tv_sec) + 1e-9 * double(end.tv_nsec - begin.tv_nsec));
    }
    return least;
  };
  for (const double radius : {0.0, 0.001}) EXPECT_LT(cost(100, radius), 4 * cost(1, radius)) << radius;
}

TEST(ProxyOnDeformable, OnlyThisTicksMovesAreSwept) {
  Sheet sheet(2);
  TestScene t;
  const auto id = t.addMesh(sheet.mesh.deformableView());
  t.tick(Vec3(0, 0, 0.01));
  EXPECT_TRUE(t.scene->triangleMoves().empty());
  t.moveVertices(id, {{4, {0, 0, 0.001f}}});
  t.tick(Vec3(0, 0, 0.01));
  EXPECT_EQ(t.scene->triangleMoves().size(), 6u);
  t.tick(Vec3(0, 0, 0.01));
  EXPECT_TRUE(t.scene->triangleMoves().empty());
  EXPECT_EQ(t.moveVertices(id, {{9, {0, 0, 0}}}), ErrorCode::kNotFound);
  EXPECT_EQ(t.moveVertices(id, {{4, {0, 0, NAN}}}), ErrorCode::kInvalidArgument);
  EXPECT_TRUE(t.scene->triangleMoves().empty());
  // Nor are those of the last tick swept once more because this one's were refused.
  const hd_vertex_move good{4, {0, 0, 0.001f}}, bad{4, {0, 0, NAN}};
  for (const auto& refused : {std::vector{bad}, std::vector{good, bad}}) {
    t.moveVertices(id, {{4, {0, 0, 0.002f}}});
    t.tick(Vec3(0, 0, 0.01));
    EXPECT_EQ(t.moveVertices(id, refused), ErrorCode::kInvalidArgument);
    t.tick(Vec3(0, 0, 0.01));
    EXPECT_TRUE(t.scene->triangleMoves().empty()) << refused.size();
  }
}

/** A sheet that turns about its border, each place at a speed of its own, at the pace of a client or of every tick. */
TEST(ProxyOnDeformable, DampingIsThatOfTheMotionItsVerticesAreSamplesOf) {
  constexpr double kDamping = 20, kSpeed = 0.05, kWidth = 0.05;
  for (const int pace : {1, 17, 40}) {
    for (const double friction : {0.0, 0.5}) {
      for (const double x : {-0.031, 0.002, 0.043}) {
        Sheet sheet(10);
        TestScene t;
        const auto id =
            t.addMesh(sheet.mesh.deformableView(), {Vec3(0, 0, -0.02), Quat(Eigen::AngleAxisd(0.4, Vec3::UnitZ()))},
                      {1000, kDamping, friction, friction});
        const Vec3 hip = Quat(Eigen::AngleAxisd(0.4, Vec3::UnitZ())) * Vec3(x, 0.003, -0.015);
        t.tick(Vec3::Zero());
        t.tick(hip);
        int felt = 0;
        for (int i = 0; i < 400; ++i) {
          const double risen = 0.002 + kSpeed * test::kTick * (i - i % pace);
          if (i % pace == 0) {
            ASSERT_EQ(t.moveVertices(id, sheet.at([&](double at, double) { return risen * (1 + at / kWidth); })),
                      ErrorCode::kOk);
          }
          const SurfaceContact& c = t.tick(hip);
          if (c.object == 0 || i <= pace) continue;
          ++felt;
          const double at = (t.scene->find(id)->X_WO.q.conjugate() * c.point).x();
          ASSERT_NEAR(c.damping, kDamping * kSpeed * (1 + at / kWidth) * c.normal.z(), 1e-4) << pace << " " << i;
        }
        EXPECT_GT(felt, 50) << x;
        for (int i = 0; i < 100; ++i) t.tick(hip);
        EXPECT_EQ(t.contact.damping, 0) << "at rest again";
      }
    }
  }
}

}  // namespace
}  // namespace hapticd
