/** @file
 * Vertices that move aside take along who sticks to their mesh, as an object does that moves.
 */
#include <gtest/gtest.h>

#include <functional>
#include <vector>

#include "tests/support/shape/test_mesh.h"
#include "tests/support/stepped/test_scene.h"

namespace hapticd {
namespace {

using test::TestMesh;
using test::TestScene;

constexpr double kStill = 0.6, kSliding = 0.4;

/** The mesh's vertices as they were made, each brought to another place. */
std::vector<hd_vertex_move> moved(const std::vector<std::array<float, 3>>& made,
                                  const std::function<Vec3(const Vec3&)>& to) {
  std::vector<hd_vertex_move> moves;
  for (std::uint32_t i = 0; i < made.size(); ++i) {
    const Vec3 x = to(Vec3(made[i][0], made[i][1], made[i][2]));
    moves.push_back({i, {static_cast<float>(x.x()), static_cast<float>(x.y()), static_cast<float>(x.z())}});
  }
  return moves;
}

/** One mesh moved by poses, another one by its vertices, told each `pace` ticks; both under a hand that rests. */
struct Pair {
  Pair(const std::function<TestMesh()>& make, double radius, std::uint32_t flags, double still, double sliding)
      : mesh{make(), make()}, made(mesh[1].vertices) {
    for (int i = 0; i < 2; ++i) {
      t[i].proxy.setRadius(radius);
      id[i] = t[i].addMesh(mesh[i].deformableView(), {}, {1000, 0, still, sliding}, flags);
    }
  }
  void rest(const Vec3& above, const Vec3& hip) {
    for (TestScene& scene : t) {
      scene.tick(above);
      scene.tick(hip);
    }
  }
  /** How far the forces are apart, at most. */
  double follow(const Vec3& hip, int ticks, int pace, const std::function<Pose(int)>& X) {
    double most = 0;
    for (int i = 1; i <= ticks; ++i) {
      if (i % pace == 0) {
        EXPECT_EQ(t[0].pose(id[0], X(i)), ErrorCode::kOk);
        EXPECT_EQ(t[1].moveVertices(id[1], moved(made, [&](const Vec3& x) { return X(i) * x; })), ErrorCode::kOk);
      }
      most = std::max(most, (t[0].tick(hip).force - t[1].tick(hip).force).norm());
    }
    return most;
  }

  TestMesh mesh[2];
  std::vector<std::array<float, 3>> made;
  TestScene t[2];
  std::uint32_t id[2];
};

TestMesh flatSheet() {
  return test::heightMesh(0.05, 10, [](double, double) { return 0.0; });
}

TEST(ProxyDrag, ASheetThatSlidesAwayTakesTheHandAlongAndThenSlipsUnderIt) {
  for (const double radius : {0.0, 0.002}) {
    for (const std::uint32_t flags : {test::kOneSided, test::kTwoSided}) {
      for (const int pace : {1, 10}) {
        Pair pair(flatSheet, radius, flags, kStill, kSliding);
        const Vec3 hip(0.0013, 0.0021, radius - 0.001);
        pair.rest(hip + Vec3(0, 0, 0.005), hip);
        const auto slide = [](int i) { return Pose{Vec3(2e-5 * i, -1e-5 * i, 0), Quat::Identity()}; };
        EXPECT_LT(pair.follow(hip, 20, pace, slide), 1e-5);
        const Vec3 lag = pair.t[1].contact.proxy - hip, along = Vec3(4e-4, -2e-4, 0);
        EXPECT_LT((lag - Vec3(along.x(), along.y(), 0.001)).norm(), 1e-8) << lag.transpose();
        EXPECT_FALSE(pair.t[1].contact.slip);
        EXPECT_LT(pair.follow(hip, 200, pace, [&](int i) { return slide(20 + i); }), 1e-5);
        EXPECT_TRUE(pair.t[1].contact.slip);
        EXPECT_NEAR(pair.t[1].contact.force.head<2>().norm(), kSliding * 1.0, 1e-5);
      }
    }
  }
}

TEST(ProxyDrag, AMeshThatTurnsTiltsAndRisesDoesAsAnObjectDoes) {
  for (const double radius : {0.0, 0.002}) {
    for (const bool ball : {false, true}) {
      for (const int pace : {1, 10}) {
        const auto make = [&] { return ball ? test::sphereMesh(0.03, 12) : flatSheet(); };
        Pair pair(make, radius, test::kOneSided, 5, 5);
        const Vec3 hip = Vec3(0.0033, 0.0021, ball ? 0.0285 : -0.001) + Vec3(0, 0, radius);
        pair.rest(hip + Vec3(0, 0, 0.01), hip);
        const auto turn = [](int i) {
          return Pose{Vec3(1e-5 * i, 0, 5e-6 * i), Quat(Eigen::AngleAxisd(4e-4 * i, Vec3(0.1, -0.2, 1).normalized()))};
        };
        EXPECT_LT(pair.follow(hip, 100, pace, turn), 1e-5) << radius << " " << ball << " " << pace;
        EXPECT_GT((pair.t[1].contact.proxy - hip).head<2>().norm(), 5e-4);
      }
    }
  }
}

/** It goes with the place on which it lies, not with the nearest vertex. */
TEST(ProxyDrag, AHandGoesWithThePlaceOfASheetThatStretches) {
  for (const double radius : {0.0, 0.002}) {
    TestMesh mesh = flatSheet();
    const auto made = mesh.vertices;
    TestScene t(radius);
    const auto id = t.addMesh(mesh.deformableView(), {}, {1000, 0, 50, 50});
    const Vec3 hip(0.0123, -0.0071, radius - 0.001);
    t.tick(hip + Vec3(0, 0, 0.005));
    t.tick(hip);
    for (int i = 1; i <= 100; ++i) {
      const double by = 1 + 1e-3 * i;
      ASSERT_EQ(t.moveVertices(id, moved(made, [&](const Vec3& x) { return Vec3(by * x.x(), x.y() / by, x.z()); })),
                ErrorCode::kOk);
      const Vec3 proxy = t.tick(hip).proxy;
      ASSERT_NEAR(proxy.x(), by * hip.x(), 1e-7) << i;
      ASSERT_NEAR(proxy.y(), hip.y() / by, 1e-7) << i;
      ASSERT_NEAR(proxy.z(), radius, 1e-9);
    }
  }
}

/** As a pose that is a teleport takes nobody along. */
TEST(ProxyDrag, VerticesThatJumpTakeNobodyAlong) {
  TestMesh mesh = test::heightMesh(1, 10, [](double, double) { return 0.0; });
  const auto made = mesh.vertices;
  TestScene t;
  const auto id = t.addMesh(mesh.deformableView(), {}, {1000, 0, 5, 5});
  const Vec3 hip(0.0013, 0.0021, -0.001);
  t.tick(hip + Vec3(0, 0, 0.005));
  t.tick(hip);
  for (const int rest : {0, 1000}) {  // That says nothing of how long the step took.
    for (const double x : {0.3, 0.0}) {
      for (int i = 0; i < rest; ++i) t.tick(hip);
      ASSERT_EQ(t.moveVertices(id, moved(made, [&](const Vec3& v) { return Vec3(v + Vec3(x, 0, 0)); })),
                ErrorCode::kOk);
      EXPECT_LT((t.tick(hip).proxy - Vec3(hip.x(), hip.y(), 0)).norm(), 1e-8) << rest << " " << x;
    }
  }
}

/** What is beside does not let a hand through that is dragged against it. */
TEST(ProxyDrag, AWallBesideStopsWhoIsTakenAlong) {
  for (const double radius : {0.0, 0.002}) {
    for (const double step : {1e-5, 1e-3}) {
      TestMesh mesh = flatSheet();
      const auto made = mesh.vertices;
      TestScene t(radius);
      const auto id = t.addMesh(mesh.deformableView(), {}, {1000, 0, 5, 5});
      t.add(ShapeKind::kBox, Vec3(0.0005, 0.02, 0.02), {Vec3(0.01, 0, 0), Quat::Identity()});
      const Vec3 hip(0.0013, 0.0021, radius - 0.002);
      t.tick(hip + Vec3(0, 0, 0.005));
      t.tick(hip);
      double x = 0;
      for (int i = 0; i < 2000 && x < 0.015; ++i) {
        x += step;
        ASSERT_EQ(t.moveVertices(id, moved(made, [&](const Vec3& v) { return Vec3(v + Vec3(x, 0, 0)); })),
                  ErrorCode::kOk);
        ASSERT_LT(t.tick(hip).proxy.x(), 0.0095 - radius + 1e-9);
      }
      EXPECT_GT(t.contact.proxy.x(), 0.0094 - radius);
    }
  }
}

}  // namespace
}  // namespace hapticd
