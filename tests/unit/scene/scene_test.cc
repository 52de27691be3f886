#include "rt/scene/scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

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

/** Whose first pose is that of its creation, in that tick: there it was since the scene began, or a tick before. */
TEST(Scene, PosesTellTheMotionOfWhatHasJustBeenMadeToo) {
  for (const int since : {1, 2, 7, 40}) {
    for (const double speed : {0.5, 9.0, 11.0}) {
      TestScene t;
      for (int i = 0; i < 300; ++i) t.scene->advance(kTick);
      const auto id = t.add(ShapeKind::kSphere, Vec3(0.1, 0, 0), {Vec3(0, 1, 0), kUnturned});
      for (int i = 0; i < since; ++i) t.scene->advance(kTick);
      const double time = since * kTick;
      t.pose(id, {Vec3(speed * std::min(time, 0.02), 1, 0), kUnturned});
      t.scene->advance(kTick);
      const SceneObject& o = *t.scene->find(id);
      EXPECT_EQ(o.moved, speed < 10) << since << " " << speed;
      EXPECT_NEAR(o.V_WO.v.x(), speed < 10 ? speed * std::min(time, 0.02) / time : 0, 1e-9) << since << " " << speed;
    }
  }
}

/** Two quaternions are the same turn. */
TEST(Scene, AVelocityToldByPosesIsTheShorterWayRound) {
  TestScene t;
  t.scene->expect(kTick);
  const auto id = t.add(ShapeKind::kSphere, Vec3(0.1, 0, 0));
  t.scene->advance(kTick);
  for (int i = 1; i <= 20; ++i) {
    Quat q(Eigen::AngleAxisd(0.003 * i, Vec3::UnitY()));
    if (i % 3 == 0) q.coeffs() = -q.coeffs();
    t.pose(id, {Vec3::Zero(), q});
    t.scene->advance(kTick);
    ASSERT_LT((t.scene->find(id)->V_WO.w - Vec3(0, 3, 0)).norm(), 1e-9) << i;
    ASSERT_LT(t.scene->sinceUnmet(objectSlot(id)), (i + 0.5) * kTick) << "since it was made";
    ASSERT_GT(t.scene->sinceUnmet(objectSlot(id)), (i - 0.5) * kTick);
  }
}

TEST(Scene, OnlyTheFlagsThatAreMeantChange) {
  TestScene t;
  const auto id = t.add(ShapeKind::kSphere, Vec3(0.1, 0, 0), {}, {}, HD_OBJECT_ENABLED | HD_OBJECT_VISIBLE);
  t.flags(id, HD_OBJECT_TWO_SIDED | HD_OBJECT_VISIBLE, HD_OBJECT_TWO_SIDED);
  EXPECT_EQ(t.scene->find(id)->flags, std::uint32_t{HD_OBJECT_ENABLED | HD_OBJECT_TWO_SIDED});
  t.flags(id, HD_OBJECT_TWO_SIDED, HD_OBJECT_VISIBLE);
  EXPECT_EQ(t.scene->find(id)->flags, std::uint32_t{HD_OBJECT_ENABLED});
}

/** Beyond those it moves, but is not swept; nobody looks for moves of a mesh of which none was noted. */
TEST(Scene, OfMovesThereAreNoMoreThanFit) {
  TestMesh one = test::sphereMesh(0.1, 4), other = test::sphereMesh(0.2, 4);
  TestScene t;
  const auto id = t.addMesh(one.deformableView()), late = t.addMesh(other.deformableView());
  const MeshView &mesh = *t.scene->find(id)->shape.mesh, &after = *t.scene->find(late)->shape.mesh;
  t.scene->advance(kTick);
  const auto count = static_cast<std::uint32_t>(one.vertices.size());
  std::vector<hd_vertex_move> moves;
  for (std::uint32_t i = 0; i < 2 * Scene::kMaxTriangleMoves; ++i)
    moves.push_back({i % count, {0.01F, 0.02F, 1e-6F * static_cast<float>(i)}});
  ASSERT_EQ(t.moveVertices(id, moves), ErrorCode::kOk);
  ASSERT_EQ(t.moveVertices(late, {moves.back()}), ErrorCode::kOk);
  t.scene->advance(kTick);
  EXPECT_EQ(t.scene->triangleMoves().size(), std::size_t{Scene::kMaxTriangleMoves});
  EXPECT_TRUE(t.scene->movesTriangles(mesh));
  EXPECT_FALSE(t.scene->movesTriangles(after));
  EXPECT_EQ(other.vertices[moves.back().index][2], moves.back().p[2]);
  t.scene->advance(kTick);
  EXPECT_TRUE(t.scene->triangleMoves().empty());
  EXPECT_FALSE(t.scene->movesTriangles(mesh));
  ASSERT_EQ(t.moveVertices(late, {moves.front()}), ErrorCode::kOk);
  t.scene->advance(kTick);
  EXPECT_FALSE(t.scene->triangleMoves().empty());
  EXPECT_TRUE(t.scene->movesTriangles(after));
  EXPECT_FALSE(t.scene->movesTriangles(mesh));
}

/** As poses tell an object's: the step over the time since the one before, and half as long again. */
TEST(Scene, AVertexTellsTheVelocityAboutIt) {
  TestMesh mesh;
  mesh.addTriangle(mesh.addVertex({0, 0, 0}), mesh.addVertex({0.3, 0, 0}), mesh.addVertex({0, 0.3, 0}));
  TestScene t;
  const Quat turn(Eigen::AngleAxisd(M_PI / 2, Vec3::UnitX()));
  const auto id = t.addMesh(mesh.deformableView(), {Vec3(1, 0, 0), turn});
  const auto at = [&](double x, double y) {
    const SceneObject& o = *t.scene->find(id);
    return Vec3(turn.conjugate() * t.scene->velocityAt(o, 0, o.toWorld(Vec3(x, y, 0))));
  };
  const auto put = [&](double x) {
    ASSERT_EQ(t.moveVertices(id, {{1, {static_cast<float>(x), 0, 0}}}), ErrorCode::kOk);
  };
  for (int i = 0; i < 100; ++i) t.scene->advance(kTick);
  struct Case {
    int ticks;
    double step, told;  // [m], [m/s]
  };
  double x = 0.3;
  for (const Case& c : {Case{1, 0.009, 9}, Case{1, 0.011, 0}, Case{16, 0.15, 0.15 / 0.016}, Case{16, 0.17, 0},
                        Case{40, 0.19, 0.19 / 0.04}, Case{40, 0.21, 0}, Case{90, 0.19, 0.19 / 0.05}}) {
    SCOPED_TRACE(c.step);
    put(x);
    for (int i = 0; i < c.ticks; ++i) t.scene->advance(kTick);
    put(x + 0.3);  // Twice in a tick is once.
    put(x += c.step);
    int told = 0;
    for (int i = 0; i < 100; ++i) {
      t.scene->advance(kTick);
      if (at(x, 0).isZero(0)) continue;
      told = i + 1;
      EXPECT_LT((at(x, 0) - Vec3(c.told, 0, 0)).norm(), 2e-4 * c.told);
      EXPECT_LT((at(x / 3, 0.1) - Vec3(c.told / 3, 0, 0)).norm(), 2e-4 * c.told);
      EXPECT_LT(at(0, 0.2).norm(), 2e-4 * c.told);
      EXPECT_LT((at(2 * x, 0) - Vec3(c.told, 0, 0)).norm(), 2e-4 * c.told) << "no more than its corners";
    }
    EXPECT_NEAR(told, c.told > 0 ? 1.5 * std::min(c.ticks, 50) : 0, c.told > 0 ? 1 : 0);
    put(x = 0.3);
    for (int i = 0; i < 100; ++i) t.scene->advance(kTick);
  }
}

/** Of two scenes the clocks are not one: what moved at a time of the first does not move then in the next. */
TEST(Scene, AMeshWhoseMotionIsForgottenRests) {
  for (const bool forgotten : {false, true}) {
    TestMesh mesh = test::sphereMesh(0.1, 4);
    MeshView* const view = mesh.deformableView();
    const std::uint32_t triangle = view->deform.vertex_triangles[view->deform.vertex_first[3]];
    TestScene scenes[2];
    std::uint32_t id[2];
    for (int i = 0; i < 2; ++i) {
      id[i] = scenes[i].addMesh(view);
      for (int k = 0; k < 100; ++k) scenes[i].scene->advance(kTick);
      for (int k = 0; i == 0 && k < 2; ++k) {
        ASSERT_EQ(scenes[0].moveVertices(id[0], {{3, {0.01F, 0.02F, 0.1F + 0.001F * static_cast<float>(k)}}}),
                  ErrorCode::kOk);
        scenes[0].scene->advance(kTick);
      }
      if (forgotten) forgetMotion(*view);
    }
    for (int k = 0; k < 2; ++k) scenes[1].scene->advance(kTick);
    EXPECT_EQ(scenes[1].scene->movesTriangles(*view), !forgotten);
    ASSERT_EQ(scenes[1].moveVertices(id[1], {{9, {-0.1F, 0, 0}}}), ErrorCode::kOk);  // Far from there.
    scenes[1].scene->advance(kTick);
    const Scene& next = *scenes[1].scene;
    EXPECT_EQ(next.velocityAt(*next.find(id[1]), triangle, Vec3(0.01, 0.02, 0.101)).isZero(0), forgotten);
  }
}

TEST(Scene, ASurfaceThatCannotBeMeantIsRefused) {
  TestScene t;
  const auto id = t.add(ShapeKind::kSphere, Vec3(0.1, 0, 0));
  const SurfaceParameters good{0.5, 10, -0.9, -1.7, 0.8, 0.001, {0.1, 0.1}, 0.05, 0, 0};
  ASSERT_EQ(t.setSurface(id, good), ErrorCode::kOk);
  const auto refused = [&](auto&& change) {
    SurfaceParameters s = good;
    change(s);
    return t.setSurface(id, s) == ErrorCode::kInvalidArgument;
  };
  const double inf = std::numeric_limits<double>::infinity(), nan = std::numeric_limits<double>::quiet_NaN();
  for (double SurfaceParameters::*const field :
       {&SurfaceParameters::smooth_cosine, &SurfaceParameters::transient_gain, &SurfaceParameters::transient_decay,
        &SurfaceParameters::relief_depth, &SurfaceParameters::vibration_mass}) {
    for (const double bad : {-1e-9, inf, nan}) EXPECT_TRUE(refused([&](auto& s) { s.*field = bad; })) << bad;
  }
  for (const int i : {0, 1}) {
    for (const double bad : {-1e-9, inf, nan}) EXPECT_TRUE(refused([&](auto& s) { s.relief_size[i] = bad; })) << bad;
    EXPECT_FALSE(refused([&](auto& s) { s.relief_size[i] = 0; }));
    EXPECT_TRUE(refused([&](auto& s) { s.relief_size[i] = 0, s.relief = 1; })) << "of a relief that there is not, too";
  }
  EXPECT_TRUE(refused([](auto& s) { s.transient_decay = 1; })) << "it would never end";
  for (const double sign : {-1.0, 1.0}) {
    EXPECT_FALSE(refused([&](auto& s) { s.transient_turn = sign * 1.788; })) << "2 r is 1.7889";
    EXPECT_TRUE(refused([&](auto& s) { s.transient_turn = sign * 1.789; }));
    EXPECT_FALSE(refused([&](auto& s) { s.transient_first = sign; }));
    EXPECT_TRUE(refused([&](auto& s) { s.transient_first = sign * 1.001; }));
  }
  SurfaceParameters none = good;
  none.relief = 9;
  EXPECT_EQ(t.setSurface(id, none), ErrorCode::kNotFound);
  none = good;
  none.vibration = 9;
  EXPECT_EQ(t.setSurface(id, none), ErrorCode::kNotFound);
  EXPECT_EQ(t.scene->find(id)->surface.parameters.transient_gain, 10);
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
