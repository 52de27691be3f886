// What is round in the scene meets a tool's faces and edges between the points that the tool is sampled by.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <ostream>

#include "rt/collide/round.h"
#include "rt/geometry/nearest/nearest.h"
#include "tests/support/shape/test_mesh.h"
#include "tests/support/stepped/tool_house.h"

namespace hapticd {
namespace {

using test::kWall;
using test::object;
using House = test::ToolHouse;

constexpr double kRoundObstacle = 0.03;
/** Between four of the box's points. */
const Vec3 kBetween(0.00125, 0.0025, 0);

void addRound(House& house, const Shape& shape, const Pose& X_WO, double friction) {
  AddObject round = object(kWall, shape.kind, shape.size, X_WO.p);
  store(X_WO.q, round.q);
  round.material.friction_static = round.material.friction_dynamic = friction;
  house.send(CommandKind::kAddObject, round);
}

struct Stood {
  double gap;  ///< Between the surfaces [m].
  Vec3 n_W;    ///< From the ball to the tool.
};

/** By brute force: what is round as many balls, the nearest of them against the tool's shape. */
Stood stood(const Shape& tool, const Pose& X_WT, const Shape& round, const Pose& X_WO) {
  const int balls = round.kind != ShapeKind::kSphere ? 20'000 : 0;
  Stood least{INFINITY, Vec3::Zero()};
  for (int i = 0; i <= balls; ++i) {
    NearestQuery query;
    query.x = X_WT.inverse() * (X_WO * Vec3(0, 0, balls > 0 ? round.size.y() * (2.0 * i / balls - 1) : 0));
    query.limit = 1'000'000;
    Nearest nearest;
    EXPECT_EQ(nearestOnShape(tool, query, nearest), NearestResult::kFound);
    const double side = nearest.isInside(query.x) ? -1 : 1;
    const double gap = side * std::sqrt(nearest.squared_distance) - round.size.x();
    if (gap < least.gap) least = {gap, X_WT.q * Vec3(side * (nearest.point - query.x)).normalized()};
  }
  return least;
}

const Shape kBox{ShapeKind::kBox, {0.01, 0.02, 0.005}};
const Shape kBallObstacle{ShapeKind::kSphere, {kRoundObstacle, 0, 0}};

struct Meeting {
  const char* name;
  Shape tool, round;
  Pose X_WO;  ///< Of what is round.
  Vec3 aim, tool_turn;
};

void PrintTo(const Meeting& meeting, std::ostream* out) { *out << meeting.name; }

class RoundObstacles : public ::testing::TestWithParam<Meeting> {};

/** Where nothing rubs it slides to where it lies still, no deeper than it is let be, pushed straight off. */
TEST_P(RoundObstacles, CarryAToolBetweenItsPoints) {
  const Meeting& meeting = GetParam();
  for (const bool mesh : {false, true}) {
    if (mesh && meeting.tool.kind != ShapeKind::kBox) continue;
    House house;
    test::TestMesh block = test::boxMesh(meeting.tool.size);
    house.meshes.publish(3, block.view());
    mesh ? house.reshape(ShapeKind::kMesh, Vec3::Zero(), 3) : house.reshape(meeting.tool.kind, meeting.tool.size);
    addRound(house, meeting.round, meeting.X_WO, 0);
    house.aim({0, 0, 0.045}, meeting.tool_turn);
    house.run(800);
    house.hold();
    house.aim(meeting.aim, meeting.tool_turn);
    house.run(1500);
    Vec3 least = house.place().p, most = least;
    double deepest = 0, oblique = 0;
    for (int i = 0; i < 1000; ++i) {
      const Pose place = house.place();
      house.run(1);
      least = least.cwiseMin(house.place().p);
      most = most.cwiseMax(house.place().p);
      if (i % 50 != 0) continue;
      const Stood now = stood(meeting.tool, place, meeting.round, meeting.X_WO);
      deepest = std::max(deepest, -now.gap);
      const Vec3 force = house.servo->cycle().tool(0).last().contact.force;
      ASSERT_GT(force.norm(), 0.3) << i;
      oblique = std::max(oblique, force.normalized().cross(now.n_W).norm());
    }
    EXPECT_LT(deepest, 1.1 * Tool::kSlop) << (mesh ? "as a mesh" : "");
    // A mesh's and a pipe's contacts are also those of the tool's points.
    EXPECT_LT(oblique, mesh ? 0.03 : isRound(meeting.round) ? 3e-3 : 0.01) << (mesh ? "as a mesh" : "");
    EXPECT_LT((most - least).norm(), 2e-6) << (mesh ? "as a mesh" : "");
  }
}

const Shape kRod{ShapeKind::kCapsule, {0.01, 0.1, 0}}, kLongTool{ShapeKind::kCapsule, {0.004, 0.15, 0}};
const Shape kPipe{ShapeKind::kCylinder, {0.01, 0.1, 0}};
const Shape kCan{ShapeKind::kCylinder, {0.01, 0.02, 0}};
const double kQuarter = EIGEN_PI / 2;
const Pose kAlongY{{0, 0, 0.02}, fromRotationVector({kQuarter, 0, 0})};
const Pose kAlongX{{0, 0, 0.02}, fromRotationVector({0, kQuarter, 0})};
const Pose kUp{{0, 0, -0.08}, Quat::Identity()};
const Vec3 kOnBall = Vec3(0, 0, kRoundObstacle) + kBetween, kOnRod(0.0003, 0.0025, 0.03);

INSTANTIATE_TEST_SUITE_P(
    Lies, RoundObstacles,
    ::testing::Values(Meeting{"BoxOnBall", kBox, kBallObstacle, {}, kOnBall, {0, 0, 0}},
                      Meeting{"TiltedBoxOnBall", kBox, kBallObstacle, {}, kOnBall, {0.2, 0.1, 0}},
                      Meeting{"BoxAlongRod", kBox, kRod, kAlongY, kOnRod, {0, 0, 0}},
                      Meeting{"BoxAcrossRod", kBox, kRod, kAlongX, kOnRod, {0, 0, 0}},
                      Meeting{"BoxAskewOnRod", kBox, kRod, kAlongY, kOnRod, {0, 0, 0.6}},
                      Meeting{"TiltedBoxOnRod", kBox, kRod, kAlongY, kOnRod, {0.1, 0.05, 0}},
                      Meeting{"EdgeOnRod", kBox, kRod, kAlongY, {0.0003, 0.003, 0.035}, {0, 0.7, 1.2}},
                      Meeting{"BoxAlongPipe", kBox, kPipe, kAlongY, kOnRod, {0, 0, 0}},
                      Meeting{"BoxAcrossPipe", kBox, kPipe, kAlongX, kOnRod, {0, 0, 0}},
                      Meeting{"BoxAskewOnPipe", kBox, kPipe, kAlongY, kOnRod, {0, 0, 0.6}},
                      Meeting{"TiltedBoxOnPipe", kBox, kPipe, kAlongY, kOnRod, {0.1, 0.05, 0}},
                      Meeting{"EdgeOnPipe", kBox, kPipe, kAlongY, {0.0003, 0.003, 0.035}, {0, 0.7, 1.2}},
                      Meeting{"RodOnPipe", kLongTool, kPipe, kAlongX, {0, 0.0047, 0.03}, {kQuarter, 0, 0.4}},
                      Meeting{"BoxOnEndOfRod", kBox, kRod, kUp, kOnRod, {0, 0, 0}},
                      Meeting{"RodOnBall", kLongTool, kBallObstacle, {}, {0, 0.0047, 0.03}, {kQuarter, 0, 0}},
                      Meeting{"RodOnRod", kLongTool, kRod, kAlongX, {0, 0.0047, 0.03}, {kQuarter, 0, 0.4}},
                      Meeting{"CanOnBall", kCan, kBallObstacle, {}, {0.0003, 0.003, 0.035}, {kQuarter, 0.1, 0}}),
    [](const auto& meeting) { return meeting.param.name; });

TEST(RoundObstacle, ABoxSlidesAndRollsOverABall) {
  for (const double friction : {0.0, 0.4}) {
    for (const double rate : {0.5, 5.0}) {
      House house;
      addRound(house, {ShapeKind::kSphere, {kRoundObstacle, 0, 0}}, Pose{}, friction);
      house.hold();
      house.aim(Vec3(0, 0, kRoundObstacle) + kBetween);
      house.run(800);
      double deepest = 0, oblique = 0;
      const int ticks = static_cast<int>(4 * EIGEN_PI / rate * 1e3 / 2);
      for (int i = 0; i < ticks; ++i) {
        const double phase = rate * 1e-3 * i;
        house.aim(Vec3(0.006 * std::sin(phase), 0.01 * std::sin(0.7 * phase), kRoundObstacle) + kBetween,
                  {0.2 * std::sin(0.7 * phase), 0.15 * std::sin(phase), 0});
        const Stood now = stood(kBox, house.place(), kBallObstacle, Pose{});
        house.run(1);
        deepest = std::max(deepest, -now.gap);
        const Vec3 force = house.servo->cycle().tool(0).last().contact.force;
        if (force.norm() > 0.2) {
          const double along = force.dot(now.n_W);
          oblique = std::max(oblique, (force - along * now.n_W).norm() / along - friction);
        }
      }
      EXPECT_LT(deepest, 1.2 * Tool::kSlop) << friction << " " << rate;
      EXPECT_LT(oblique, 2e-3) << friction << " " << rate;
    }
  }
}

}  // namespace
}  // namespace hapticd
