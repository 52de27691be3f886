#include "rt/scene/scene.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/support/shape/test_mesh.h"
#include "tests/support/stepped/test_scene.h"

namespace hapticd {
namespace {

using test::kTick;
using test::TestMesh;
using test::TestScene;

const Quat kUnturned = Quat::Identity();

Command addOrder(std::uint32_t id, std::uint32_t parent = 0) {
  AddObject order = test::solid(id, ShapeKind::kSphere, {}, {}, {0.1, 0, 0});
  order.parent = parent;
  return makeCommand(CommandKind::kAddObject, order);
}

TEST(Scene, AStaleIdIsNotFound) {
  TestScene t;
  Scene& scene = *t.scene;
  EXPECT_EQ(scene.apply(addOrder(makeObjectId(7, 1))), ErrorCode::kOk);
  EXPECT_EQ(scene.apply(addOrder(makeObjectId(7, 2))), ErrorCode::kAlreadyExists);
  EXPECT_EQ(t.remove(makeObjectId(7, 2)), ErrorCode::kNotFound);
  EXPECT_EQ(t.remove(makeObjectId(7, 1)), ErrorCode::kOk);
  EXPECT_EQ(scene.apply(addOrder(makeObjectId(7, 2))), ErrorCode::kOk);
  EXPECT_EQ(scene.find(makeObjectId(7, 1)), nullptr);
  EXPECT_EQ(t.pose(makeObjectId(7, 1), {}), ErrorCode::kNotFound);
  EXPECT_EQ(t.pose(makeObjectId(7, 2), {}), ErrorCode::kOk);
  for (const std::uint32_t bad : {0u, makeObjectId(0, 1), makeObjectId(256, 1), makeObjectId(0xffff, 9)}) {
    EXPECT_EQ(t.pose(bad, {}), ErrorCode::kNotFound) << bad;
    EXPECT_EQ(scene.apply(addOrder(bad)), ErrorCode::kInvalidArgument) << bad;
  }
}

TEST(Scene, ARefusedCommandChangesNothing) {
  TestScene t;
  Scene& scene = *t.scene;
  const auto id = t.add(ShapeKind::kSphere, Vec3(0.1, 0, 0), {}, {1000, 1, 0.5, 0.4});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(t.pose(id, {Vec3(nan, 0, 0), kUnturned}), ErrorCode::kInvalidArgument);
  EXPECT_EQ(t.pose(id, {Vec3::Zero(), Quat(0, 0, 0, 0)}), ErrorCode::kInvalidArgument);
  EXPECT_EQ(t.pose(id, {}, {Vec3(0, nan, 0), Vec3::Zero()}), ErrorCode::kInvalidArgument);
  for (const hd_material& m : {hd_material{-1, 0, 0, 0}, {1, nan, 0, 0}, {1, 0, 0.3, 0.4}}) {
    EXPECT_EQ(t.apply(CommandKind::kObjectMaterial, hd_object_material{id, 0, m}), ErrorCode::kInvalidArgument);
  }
  for (const std::uint32_t kind : {7u, 0xffffffffu}) {
    Command command = addOrder(makeObjectId(9, 1));
    command.as<AddObject>().shape.kind = kind;
    EXPECT_EQ(scene.apply(command), ErrorCode::kInvalidArgument);
  }
  Command mesh = addOrder(makeObjectId(9, 1));
  mesh.as<AddObject>().shape.kind = static_cast<std::uint32_t>(ShapeKind::kMesh);
  mesh.as<AddObject>().shape.mesh = 200;
  EXPECT_EQ(scene.apply(mesh), ErrorCode::kNotFound);
  Command orphan = addOrder(makeObjectId(9, 1), makeObjectId(99, 1));
  EXPECT_EQ(scene.apply(orphan), ErrorCode::kNotFound);
  hd_object_vertices vertices{};
  vertices.object = id;
  EXPECT_EQ(t.apply(CommandKind::kObjectVertices, vertices), ErrorCode::kUnsupported);
  vertices.count = HD_VERTEX_MOVES + 1;
  EXPECT_EQ(t.apply(CommandKind::kObjectVertices, vertices), ErrorCode::kInvalidArgument);
  EXPECT_EQ(scene.apply(Command{}), ErrorCode::kUnsupported);
  scene.advance(kTick);
  EXPECT_EQ(scene.touchable().size(), 1u);
  EXPECT_EQ(scene.find(id)->X_WO.p, Vec3(Vec3::Zero()));
  EXPECT_EQ(scene.find(id)->material.stiffness, 1000);
}

/** Whichever of them it is that cannot be meant. */
TEST(Scene, AMoveOfVerticesIsRefusedAsAWhole) {
  constexpr std::uint32_t kMoves = 11;
  const auto above = static_cast<std::uint32_t>(test::sphereMesh(0.1, 8).vertices.size());
  const auto moves = [](std::uint32_t id) {
    hd_object_vertices order{id, kMoves, {}};
    for (std::uint32_t i = 0; i < kMoves; ++i) order.move[i] = {i, {0.2f, 0.1f, 0}};
    return order;
  };
  for (const std::uint32_t bad : {0u, 5u, kMoves - 1}) {
    TestMesh mesh = test::sphereMesh(0.1, 8);
    TestScene t;
    const auto id = t.addMesh(mesh.deformableView());
    const auto before = mesh.vertices;
    hd_object_vertices order = moves(id);
    order.move[bad].index = above;
    EXPECT_EQ(t.apply(CommandKind::kObjectVertices, order), ErrorCode::kNotFound) << bad;
    order = moves(id);
    order.move[bad].p[1] = 1e9f;
    EXPECT_EQ(t.apply(CommandKind::kObjectVertices, order), ErrorCode::kInvalidArgument) << bad;
    EXPECT_EQ(mesh.vertices, before) << bad;
    EXPECT_EQ(t.apply(CommandKind::kObjectVertices, moves(id)), ErrorCode::kOk) << bad;
    EXPECT_NE(mesh.vertices, before) << bad;
  }
}

TEST(Scene, ChildrenAreRemovedFirst) {
  TestScene t;
  const auto a = t.add(ShapeKind::kGroup, Vec3::Zero());
  const auto b = t.add(ShapeKind::kSphere, Vec3(1, 0, 0), {}, {}, HD_OBJECT_ENABLED, a);
  EXPECT_EQ(t.remove(a), ErrorCode::kInvalidArgument);
  EXPECT_EQ(t.remove(b), ErrorCode::kOk);
  EXPECT_EQ(t.remove(a), ErrorCode::kOk);
  EXPECT_TRUE(t.scene->touchable().empty());
}

TEST(Scene, ParentsComeFirstWhateverTheSlots) {
  TestScene t;
  EXPECT_EQ(t.scene->apply(addOrder(makeObjectId(200, 1))), ErrorCode::kOk);
  EXPECT_EQ(t.scene->apply(addOrder(makeObjectId(3, 1), makeObjectId(200, 1))), ErrorCode::kOk);
  EXPECT_EQ(t.scene->apply(addOrder(makeObjectId(100, 1), makeObjectId(3, 1))), ErrorCode::kOk);
  const Quat turn(Eigen::AngleAxisd(M_PI / 2, Vec3::UnitZ()));
  t.pose(makeObjectId(200, 1), {Vec3(1, 0, 0), turn});
  t.pose(makeObjectId(3, 1), {Vec3(1, 0, 0), turn});
  t.pose(makeObjectId(100, 1), {Vec3(1, 0, 0), kUnturned});
  t.scene->advance(kTick);
  EXPECT_LT((t.scene->find(makeObjectId(100, 1))->X_WO.p - Vec3(0, 1, 0)).norm(), 1e-12);
  const auto touchable = t.scene->touchable();
  EXPECT_EQ(std::vector<int>(touchable.begin(), touchable.end()), (std::vector<int>{3, 100, 200}));
}

TEST(Scene, VelocityMovesOnAndComposesUpTheTree) {
  TestScene t;
  const auto arm = t.add(ShapeKind::kGroup, Vec3::Zero(), {Vec3(0.1, 0, 0), kUnturned});
  const auto tip = t.add(ShapeKind::kSphere, Vec3(0.1, 0, 0), {Vec3(0, 1, 0), kUnturned}, {}, HD_OBJECT_ENABLED, arm);
  t.pose(arm, {Vec3(0.1, 0, 0), kUnturned}, {Vec3(0.5, 0, 0), Vec3(0, 0, 2)});
  t.pose(tip, {Vec3(0, 1, 0), kUnturned}, {Vec3(0, 0.25, 0), Vec3::Zero()});
  t.scene->advance(kTick);
  EXPECT_EQ(t.scene->find(tip)->X_WO.p, Vec3(0.1, 1, 0)) << "the tick of the command stands at the command";
  for (int i = 0; i < 500; ++i) t.scene->advance(kTick);
  const double a = 2 * 0.5, r = 1 + 0.25 * 0.5;
  const SceneObject& o = *t.scene->find(tip);
  EXPECT_LT((o.X_WO.p - Vec3(0.1 + 0.25 - r * std::sin(a), r * std::cos(a), 0)).norm(), 1e-9);
  const Vec3 v(0.5 - 2 * r * std::cos(a) - 0.25 * std::sin(a), -2 * r * std::sin(a) + 0.25 * std::cos(a), 0);
  EXPECT_LT((o.V_WO.v - v).norm(), 1e-9);
  EXPECT_LT((o.V_WO.w - Vec3(0, 0, 2)).norm(), 1e-12);
  EXPECT_LT(((o.X_WO.p - o.X_WO_before.p) / kTick - v).norm(), 3e-3);
  EXPECT_TRUE(o.moved);
  EXPECT_LT((o.velocityAt(o.X_WO.p + Vec3(1, 0, 0)) - v - Vec3(0, 2, 0)).norm(), 1e-9);
}

/** Though nothing has moved yet in the tick of the order, nor in that of the one to stay. */
TEST(Scene, PartsHaveTheVelocityThatTheirGroupIsGivenFromThatTickOn) {
  for (const bool turns : {false, true}) {
    TestScene t;
    const auto group = t.add(ShapeKind::kGroup, Vec3::Zero());
    const auto inner = t.add(ShapeKind::kGroup, Vec3::Zero(), {}, {}, HD_OBJECT_ENABLED, group);
    const auto part =
        t.add(ShapeKind::kSphere, Vec3(0.1, 0, 0), {Vec3(0.5, 0, 0), kUnturned}, {}, HD_OBJECT_ENABLED, inner);
    for (int i = 0; i < 5; ++i) t.scene->advance(kTick);
    const SceneObject& o = *t.scene->find(part);
    const Twist V = turns ? Twist{Vec3::Zero(), Vec3(0, 0, 2)} : Twist{Vec3(0, 0.25, 0), Vec3::Zero()};
    for (const double way : {1.0, -1.0, 0.0, 1.0, 0.0}) {
      SCOPED_TRACE(way);
      const Pose before = o.X_WO;
      t.pose(group, t.scene->find(group)->X_PO, {way * V.v, way * V.w});
      t.scene->advance(kTick);
      EXPECT_EQ(o.X_WO.p, before.p);
      const Vec3 arm = o.X_WO.p - t.scene->find(group)->X_WO.p;
      EXPECT_LT((o.V_WO.w - way * V.w).norm(), 1e-12);
      EXPECT_LT((o.V_WO.v - way * (V.v + V.w.cross(arm))).norm(), 1e-12);
    }
    t.scene->advance(kTick);
    EXPECT_EQ(o.V_WO.v, Vec3(Vec3::Zero()));
    EXPECT_EQ(o.V_WO.w, Vec3(Vec3::Zero()));
  }
}

TEST(Scene, PosesWithoutVelocityGiveTheirDifferenceAndThenRest) {
  TestScene t;
  const auto id = t.add(ShapeKind::kSphere, Vec3(0.1, 0, 0));
  t.scene->advance(kTick);
  t.pose(id, {});
  t.scene->advance(kTick);
  const Quat turn(Eigen::AngleAxisd(0.01, Vec3::UnitX()));
  t.pose(id, {Vec3(0, 0, 0.001), turn});
  t.scene->advance(kTick);
  const SceneObject& o = *t.scene->find(id);
  EXPECT_LT((o.V_WO.v - Vec3(0, 0, 1)).norm(), 1e-12);
  EXPECT_LT((o.V_WO.w - Vec3(10, 0, 0)).norm(), 1e-9);
  EXPECT_EQ(o.X_WO_before.p, Vec3(Vec3::Zero()));
  for (int i = 0; i < 2; ++i) t.scene->advance(kTick);
  EXPECT_EQ(o.V_WO.v, Vec3(Vec3::Zero()));
  EXPECT_EQ(o.X_WO_before.p, o.X_WO.p);
  EXPECT_FALSE(o.moved);
}

/** At 20 poses a second and more, a few milliseconds early or late: the speed is the motion's, not the step's in its
 * tick. */
TEST(Scene, PosesAtAClientsPaceCountAsTheMotionTheyAreSamplesOf) {
  constexpr double kSpeed = 0.1, kTurn = 2;  // m/s, rad/s
  for (const int pace : {1, 4, 17, 33, 44}) {
    SCOPED_TRACE(pace);
    const int late = pace / 8;
    TestScene t;
    const auto arm = t.add(ShapeKind::kGroup, Vec3::Zero());
    const auto tip =
        t.add(ShapeKind::kSphere, Vec3(0.1, 0, 0), {Vec3(0.5, 0, 0), kUnturned}, {}, HD_OBJECT_ENABLED, arm);
    const SceneObject& o = *t.scene->find(tip);
    int told = 0, next = 0;
    for (int i = 0; i < 20 * pace; ++i) {
      if (i == next) {
        const double time = i * kTick;
        t.pose(arm, {Vec3(0, 0, kSpeed * time), Quat(Eigen::AngleAxisd(kTurn * time, Vec3::UnitZ()))});
        next += pace + (++told % 2 == 0 ? late : -late);
      }
      t.scene->advance(kTick);
      if (told < 3) continue;
      ASSERT_NEAR(o.V_WO.v.z(), kSpeed, 1e-9) << i;
      ASSERT_NEAR(o.V_WO.w.z(), kTurn, 1e-9) << i;
      ASSERT_NEAR(o.V_WO.v.head<2>().norm(), 0.5 * kTurn, 1e-9) << i;
    }
    for (int i = 0; i < 2 * (pace + late); ++i) t.scene->advance(kTick);
    EXPECT_EQ(o.V_WO.v, Vec3(Vec3::Zero())) << "poses that come no more are a rest";
    EXPECT_EQ(o.V_WO.w, Vec3(Vec3::Zero()));
  }
}

TEST(Scene, AStepIsAMotionIfCredibleOverTheTimeSinceTheLastPose) {
  struct Case {
    int ticks;
    double step;
    bool motion;
  };
  for (const Case& c : {Case{1, 0.009, true},
                        {1, 0.011, false},
                        {16, 0.15, true},
                        {16, 0.17, false},
                        {1000, 0.19, true},
                        {1000, 0.21, false}}) {
    TestScene t;
    const auto arm = t.add(ShapeKind::kGroup, Vec3::Zero());
    const auto id = t.add(ShapeKind::kSphere, Vec3(0.1, 0, 0), {}, {}, HD_OBJECT_ENABLED, arm);
    t.scene->advance(kTick);
    t.pose(arm, {});
    for (int i = 0; i < c.ticks; ++i) t.scene->advance(kTick);
    t.pose(arm, {Vec3(c.step, 0, 0), kUnturned});
    t.scene->advance(kTick);
    EXPECT_EQ(t.scene->find(id)->moved, c.motion) << c.ticks << " " << c.step;
    EXPECT_EQ(t.scene->find(id)->X_WO.p, Vec3(c.step, 0, 0));
    EXPECT_EQ(t.scene->find(id)->V_WO.v.isZero(0), !c.motion);
  }
}

TEST(Scene, CreationAndShapeChangeAreNoMotion) {
  TestScene t;
  const auto id = t.add(ShapeKind::kSphere, Vec3(0.1, 0, 0), {Vec3(1, 0, 0), kUnturned});
  t.scene->advance(kTick);
  EXPECT_FALSE(t.scene->find(id)->moved);
  EXPECT_EQ(t.setShape(id, {static_cast<std::uint32_t>(ShapeKind::kBox), 0, {0.1, 0.2, 0.2}}), ErrorCode::kOk);
  t.scene->advance(kTick);
  EXPECT_FALSE(t.scene->find(id)->moved);
  EXPECT_NEAR(t.scene->find(id)->radius, 0.3, 1e-12);
}

/** In that tick and no other, also where all rests; one that it shows already does not come anew. */
TEST(Scene, AMeshThatAnObjectIsGivenAppears) {
  TestMesh one = test::sphereMesh(0.1, 4), other = test::sphereMesh(0.2, 4);
  TestScene t;
  const auto id = t.addMesh(one.view());
  t.table->publish(20, other.view());
  const SceneObject& o = *t.scene->find(id);
  const auto mesh = static_cast<std::uint32_t>(ShapeKind::kMesh);
  t.scene->advance(kTick);
  EXPECT_TRUE(o.appeared);
  for (int i = 0; i < 5; ++i) t.scene->advance(kTick);
  for (const bool another : {true, false}) {
    EXPECT_FALSE(o.appeared);
    ASSERT_EQ(t.setShape(id, {mesh, 20, {}}), ErrorCode::kOk);
    t.scene->advance(kTick);
    EXPECT_EQ(o.appeared, another);
    EXPECT_FALSE(o.moved);
    for (int i = 0; i < 5; ++i) t.scene->advance(kTick);
  }
  t.flags(id, HD_OBJECT_ENABLED, 0);
  t.scene->advance(kTick);
  EXPECT_FALSE(o.appeared);
  t.flags(id, HD_OBJECT_ENABLED, HD_OBJECT_ENABLED);
  t.scene->advance(kTick);
  EXPECT_TRUE(o.appeared);
  t.scene->advance(kTick);
  EXPECT_FALSE(o.appeared);
}

TEST(Scene, TheBallHoldsTheMeshWhereverItIs) {
  TestMesh mesh = test::sphereMesh(0.1, 8, Vec3(1, 2, 3));
  TestScene t;
  const auto id = t.addMesh(mesh.view(), {Vec3(0.5, 0, 0), Quat(Eigen::AngleAxisd(1, Vec3::UnitY()))});
  t.scene->advance(kTick);
  const SceneObject& o = *t.scene->find(id);
  for (const auto& v : mesh.vertices) {
    EXPECT_LE((o.X_WO * Vec3(v[0], v[1], v[2]) - o.center_W).norm(), o.radius * (1 + 1e-12));
  }
}

}  // namespace
}  // namespace hapticd
