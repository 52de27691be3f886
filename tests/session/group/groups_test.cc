// Two servos, one scene.
#include "tests/session/bench.h"
#include "tests/support/random.h"

namespace hapticd::test {
namespace {

TEST(TwoGroups, ShareTheSceneAndWhatAClientMovesMovesForBoth) {
  Bench bench;
  Session* session = bench.live();
  ASSERT_NE(session, nullptr);
  ObjectSpec spec;
  spec.name = "ball";
  spec.shape = {ShapeKind::kSphere, {0.01, 0, 0}, 0};
  spec.material = kDefaultMaterial;
  const auto id = bench.core.scene().create(spec, bench.core.client(bench.connection));
  ASSERT_TRUE(id.ok());
  auto second = bench.core.openDevice("test://second");
  ASSERT_TRUE(second.ok());
  EXPECT_EQ((*second)->name, "test2");
  ASSERT_EQ(bench.core.devices().links().size(), 2u);
  bench.step(40);
  const auto pose = [&](std::size_t group) {
    const SceneObject* object = bench.core.devices().links()[group]->group().servo().cycle().scene().find(*id);
    return object == nullptr ? -1.0 : object->X_PO.p.z();
  };
  EXPECT_EQ(pose(0), 0.0);
  EXPECT_EQ(pose(1), 0.0) << "the late servo got the scene";

  const hd_object_pose moved = poseMessage(*id, {{0, 0, 0.125}, Quat::Identity()});
  std::uint64_t seq = 0;
  ASSERT_EQ(bench.client->producer->push(HD_COMMAND_OBJECT_POSE, std::as_bytes(std::span(&moved, 1)), 0, seq),
            ErrorCode::kOk);
  bench.step(60);
  EXPECT_EQ(pose(0), 0.125);
  EXPECT_EQ(pose(1), 0.125);
  EXPECT_EQ(bench.core.scene().find("ball")->spec.X_PO.p.z(), 0.125);
  const auto sent = bench.core.devices().links()[1]->posted();
  bench.step(60);
  EXPECT_EQ(bench.core.devices().links()[1]->posted(), sent) << "handed on once, not for ever";

  ASSERT_TRUE(bench.core.scene().setPose("ball", {}).ok());
  bench.step(40);
  EXPECT_EQ(pose(0), 0.0);
  EXPECT_EQ(pose(1), 0.0);
}

/** A cycle made anew counts what clients change from the start; what the one before it told is not new. */
TEST(TwoGroups, ARecordingPutsNothingBackThatMoves) {
  Bench bench;
  ASSERT_NE(bench.live(), nullptr);
  ObjectSpec spec;
  spec.name = "parcel";
  spec.shape = {ShapeKind::kSphere, {0.01, 0, 0}, 0};
  spec.material = kDefaultMaterial;
  const auto id = bench.core.scene().create(spec, bench.core.client(bench.connection));
  ASSERT_TRUE(id.ok());
  ASSERT_TRUE(bench.core.openDevice("test://second").ok());
  const auto other = bench.core.openSession("test://second", bench.connection, "", HD_SHM_MAJOR, HD_SHM_MINOR);
  ASSERT_TRUE(other.ok()) << toString(other.error());
  const ClientSide side(**other);
  ASSERT_TRUE(bench.core.sessions().mapped((*other)->id).ok());
  bench.step(40);
  hd_object_pose moved = poseMessage(*id, {});
  moved.v[2] = 0.5;
  std::uint64_t seq = 0;
  ASSERT_EQ(side.producer->push(HD_COMMAND_OBJECT_POSE, std::as_bytes(std::span(&moved, 1)), 0, seq), ErrorCode::kOk);
  bench.step(60);
  const auto z = [&](std::size_t group) {
    return bench.core.devices().links()[group]->group().servo().cycle().scene().find(*id)->X_PO.p.z();
  };
  ASSERT_NEAR(z(0), z(1), 2e-3);
  const double before = z(0);
  ASSERT_GT(before, 0.01);
  const auto recording = bench.core.record("test://second", bench.administration);
  ASSERT_TRUE(recording.ok()) << toString(recording.error());
  // Control looks before the first cycle that is recorded: what that servo shows is of before.
  for (int i = 0; i < 5; ++i) bench.core.devices().links()[0]->group().step();
  bench.core.poll();
  double last[2] = {z(0), z(1)};
  for (int i = 0; i < 60; ++i) {
    for (const auto& link : bench.core.devices().links()) link->group().step();
    bench.core.poll();
    for (const std::size_t group : {0, 1}) {
      EXPECT_GE(z(group), last[group]) << "group " << group << ", " << i << " ms after";
      last[group] = z(group);
    }
  }
  EXPECT_NEAR(last[0], before + 0.0325, 1e-3);
  bench.core.recordings().drop(recording->id);
}

TEST(TwoGroups, ABodyThatOneHandPushesMovesForTheOther) {
  Bench bench;
  const Client& by = bench.core.client(bench.administration);
  const auto make = [&](const char* name, ShapeKind kind, const Vec3& at) {
    ObjectSpec spec;
    spec.name = name;
    spec.shape = {kind, {0.01, 0.01, 0.01}, 0};
    spec.material = kDefaultMaterial;
    spec.X_PO.p = at;
    EXPECT_TRUE(bench.core.scene().create(spec, by).ok());
  };
  make("tool", ShapeKind::kBox, {0, 0, 0});
  make("ball", ShapeKind::kSphere, {-0.03, 0, 0});
  ASSERT_TRUE(bench.core.scene().setBody("ball", {.mass = 0.2, .damping = 20}).ok());
  ASSERT_TRUE(bench.core.openDevice("test://second").ok());
  ASSERT_TRUE(bench.core.attachTool(bench.device(0), {.object = "tool"}, by).ok());
  bench.step(40);
  const auto x = [&](std::size_t group) {
    const std::uint32_t id = bench.core.scene().find("ball")->id;
    return bench.core.devices().links()[group]->group().servo().cycle().scene().find(id)->X_PO.p.x();
  };
  for (int i = 0; i < 600; ++i) {
    bench.scripted[0]->sample.p.x() = -0.1e-3 * i;
    bench.step();
    EXPECT_NEAR(x(1), x(0), 5e-3) << "it follows at once";
  }
  bench.step(1000);
  EXPECT_LT(x(0), -0.075) << "pushed by the first hand alone";
  EXPECT_EQ(x(1), x(0));
  ASSERT_TRUE(bench.core.detachTool(bench.device(0), by).ok());  // whose place is told in every tick
  bench.step(60);
  const auto sent = bench.core.devices().links()[1]->posted();
  bench.step(60);
  EXPECT_EQ(bench.core.devices().links()[1]->posted(), sent) << "at rest nothing is handed on";
  ASSERT_TRUE(bench.core.scene().setPose("ball", {{0, 0.1, 0}, Quat::Identity()}).ok());
  bench.step(40);
  EXPECT_EQ(x(0), 0);
  EXPECT_EQ(x(1), 0);
}

/** Neither hand's servo knows how hard the other pushes: the body creeps between them, but nothing grows. */
TEST(TwoGroups, ABodyThatTwoHandsSqueezeStaysBetweenThem) {
  Bench bench;
  const Client& by = bench.core.client(bench.administration);
  const auto make = [&](const char* name, ShapeKind kind, double x) {
    ObjectSpec spec;
    spec.name = name;
    spec.shape = {kind, {0.01, 0.01, 0.01}, 0};
    spec.material = kDefaultMaterial;
    spec.X_PO.p = Vec3(x, 0, 0);
    EXPECT_TRUE(bench.core.scene().create(spec, by).ok());
  };
  make("left", ShapeKind::kBox, -0.1);
  make("right", ShapeKind::kBox, 0.1);
  make("ball", ShapeKind::kSphere, 0);
  ASSERT_TRUE(bench.core.scene().setBody("ball", {.mass = 0.2, .damping = 5}).ok());
  ASSERT_TRUE(bench.core.openDevice("test://second").ok());
  const auto reach = [&](double x) {  // Both hands as far from the middle.
    bench.scripted[0]->sample.p.x() = -x;
    bench.scripted.back()->sample.p.x() = x;  // The one before it was only asked for its name.
  };
  reach(0.05);
  bench.step(40);
  ASSERT_TRUE(bench.core.attachTool(bench.device(0), {.object = "left"}, by).ok());
  ASSERT_TRUE(bench.core.attachTool(bench.device(1), {.object = "right"}, by).ok());
  bench.step(40);
  const auto cycle = [&](std::size_t group) -> const Cycle& {
    return bench.core.devices().links()[group]->group().servo().cycle();
  };
  const std::uint32_t ball = bench.core.scene().find("ball")->id;
  const double overlap = 0.005;  // Of each hand's place with the ball's, were nothing pushed away.
  double most = 0, apart = 0, away = 0;
  for (int i = 0; i < 2500; ++i) {
    reach(std::max(0.02 - overlap, 0.05 - 0.05e-3 * i));
    bench.step();
    const double x[2] = {cycle(0).scene().find(ball)->X_PO.p.x(), cycle(1).scene().find(ball)->X_PO.p.x()};
    for (const std::size_t hand : {0, 1}) most = std::max(most, cycle(hand).tool(0).last().on_device.force.norm());
    apart = std::max(apart, std::abs(x[0] - x[1]));
    away = std::max(away, std::abs(x[0]));
  }
  const double stiffness = cycle(0).tool(0).stiffness();
  EXPECT_GT(most, 0.5 * stiffness * overlap) << "they squeeze it";
  EXPECT_LT(most, 1.5 * stiffness * 2 * overlap) << "no hand holds more than all that both overlap";
  EXPECT_LT(away, 1.5 * overlap);
  EXPECT_LT(apart, 2e-3) << "both see it where it is";
}

/** Where a row of balls comes to lie, of which a tool pushes one end; in the hand's group, and in another if one is. */
struct Row {
  std::vector<double> here, there;
  double most = 0;  ///< Force that the hand feels [N].
};

Row pushedRow(bool shared) {
  Bench bench;
  const Client& by = bench.core.client(bench.administration);
  if (shared) EXPECT_TRUE(bench.core.openDevice("test://second").ok());  // Which is told what is pushed in the first.
  std::vector<std::uint32_t> balls;
  const auto make = [&](const std::string& name, double x) {
    ObjectSpec spec;
    spec.name = name;
    spec.shape = {ShapeKind::kSphere, {0.01, 0, 0}, 0};
    spec.material = kDefaultMaterial;
    spec.X_PO.p = Vec3(x, 0.001 * static_cast<double>(balls.size()), 0);
    return bench.core.scene().create(spec, by).value();
  };
  make("tool", 0.1);
  for (const char* name : {"near", "middle", "far"}) {
    balls.push_back(make(name, -0.022 * static_cast<double>(balls.size() + 1)));
    EXPECT_TRUE(bench.core.scene().setBody(name, {.mass = 0.1, .damping = 0.5}).ok());
  }
  const std::size_t hand = shared ? 1 : 0;
  bench.step(40);
  EXPECT_TRUE(bench.core.attachTool(bench.device(hand), {.object = "tool"}, by).ok());
  bench.step(40);
  Row row;
  const auto cycle = [&](std::size_t group) -> const Cycle& {
    return bench.core.devices().links()[group]->group().servo().cycle();
  };
  for (int i = 0; i < 1000; ++i) {
    bench.scripted.back()->sample.p.x() = -0.1e-3 * std::min(i, 300);
    bench.step();
    row.most = std::max(row.most, cycle(hand).tool(0).last().on_device.force.norm());
  }
  bench.step(1000);
  for (const std::uint32_t ball : balls) {
    row.here.push_back(cycle(hand).scene().find(ball)->X_WO.p.x());
    row.there.push_back(cycle(0).scene().find(ball)->X_WO.p.x());
  }
  return row;
}

TEST(TwoGroups, WhatABodyPushesThatAHandPushesMovesForTheOtherAndIsFeltNoOtherwise) {
  const Row alone = pushedRow(false), shared = pushedRow(true);
  EXPECT_LT(alone.here.back(), -0.08) << "all are pushed";
  EXPECT_NEAR(shared.most, alone.most, 1e-6);
  for (std::size_t i = 0; i < alone.here.size(); ++i) {
    EXPECT_NEAR(shared.here[i], alone.here[i], 1e-6) << i;
    EXPECT_NEAR(shared.there[i], shared.here[i], 1e-6) << i;
  }
}

/** Of what tumbles no two servos make the same. */
TEST(TwoGroups, WhatFallsComesToLieAlikeForBoth) {
  Bench bench;
  GroupConfig fast;
  fast.name = "fast";
  fast.devices = {"test://second"};
  fast.rate_hz = 4000;
  ASSERT_TRUE(bench.core.devices().openGroup(fast).ok());
  const auto step = [&](int periods) {
    for (int i = 0; i < periods; ++i) {
      for (const std::size_t group : {1, 1, 1, 1, 0}) bench.core.devices().links()[group]->group().servo().runOnce();
      for (const auto& link : bench.core.devices().links()) {
        if (i % 2 == 0) link->group().servo().collider->step(nullptr);  // As often as the thread.
      }
      bench.core.poll();
    }
  };
  const Client& by = bench.core.client(bench.administration);
  const auto make = [&](const std::string& name, ShapeKind kind, const Pose& X) {
    ObjectSpec spec;
    spec.name = name;
    spec.shape = {kind, {0.01, 0.015, 0.03}, 0};
    spec.material = kDefaultMaterial;
    spec.X_PO = X;
    return bench.core.scene().create(spec, by).value();
  };
  make("floor", ShapeKind::kPlane, {});
  ASSERT_TRUE(bench.core.scene().setGravity({0, 0, -9.81}).ok());
  Random random(9);
  std::vector<std::uint32_t> bricks;
  for (int i = 0; i < 2; ++i) {
    const std::string name = "brick" + std::to_string(i);
    bricks.push_back(make(name, ShapeKind::kBox, {Vec3(0.01 * i, 0, 0.3 + 0.08 * i), random.turn()}));
    ASSERT_TRUE(bench.core.scene().setBody(name, {.mass = 0.2}).ok());
  }
  step(1000);
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    const Pose& X = bench.core.devices().links()[0]->group().servo().cycle().scene().find(bricks[i])->X_WO;
    const Pose& seen = bench.core.devices().links()[1]->group().servo().cycle().scene().find(bricks[i])->X_WO;
    EXPECT_LT(X.p.z(), 0.1) << i << " has fallen";
    EXPECT_LT((X.p - seen.p).norm(), 1e-4) << i;
    EXPECT_LT(X.q.angularDistance(seen.q), 1e-2) << i;
    EXPECT_LT((bench.core.scene().find("brick" + std::to_string(i))->spec.X_PO.p - X.p).norm(), 1e-4) << i;
  }
}

/** Told of a tool every 5 ms, the other group has it go on for so long when it stops: 1 mm before a ball. */
TEST(TwoGroups, WhatOnlyTheOtherHasSeenPushedIsPutBack) {
  Bench bench;
  const Client& by = bench.core.client(bench.administration);
  const auto make = [&](const char* name, const Vec3& at) {
    ObjectSpec spec;
    spec.name = name;
    spec.shape = {ShapeKind::kSphere, {0.01, 0, 0}, 0};
    spec.material = kDefaultMaterial;
    spec.X_PO.p = at;
    return bench.core.scene().create(spec, by).value();
  };
  make("tool", {0.2, 0, 0});
  const std::uint32_t ball = make("ball", {-0.021, 0, 0});
  ASSERT_TRUE(bench.core.scene().setBody("ball", {.mass = 0.1, .damping = 20}).ok());
  ASSERT_TRUE(bench.core.openDevice("test://second").ok());
  bench.scripted[0]->sample.p.x() = 0.201;
  bench.step(40);
  ASSERT_TRUE(bench.core.attachTool(bench.device(0), {.object = "tool", .direct = true}, by).ok());
  bench.step(40);
  const auto x = [&](std::size_t group) {
    return bench.core.devices().links()[group]->group().servo().cycle().scene().find(ball)->X_PO.p.x();
  };
  double strayed = 0;
  for (int i = 0; i < 1000; ++i) {
    bench.scripted[0]->sample.p.x() = std::max(0.0, 0.201 - 1e-3 * i);
    for (const auto& link : bench.core.devices().links()) link->group().step();
    if (i % 5 == 0) bench.core.poll();
    strayed = std::max(strayed, x(0) - x(1));
  }
  EXPECT_EQ(x(0), -0.021) << "nothing touched it";
  EXPECT_GT(strayed, 2e-4) << "else nothing was tried";
  EXPECT_NEAR(x(1), x(0), 1e-4);
}

/** What only its servo knew: where a client had put something, and where a body had come to lie. */
TEST(AGroupThatCloses, LeavesThingsWhereItHadThem) {
  Bench bench;
  ASSERT_NE(bench.live(), nullptr);
  const auto make = [&](const char* name, const Vec3& at) {
    ObjectSpec spec;
    spec.name = name;
    spec.shape = {ShapeKind::kSphere, {0.01, 0, 0}, 0};
    spec.material = kDefaultMaterial;
    spec.X_PO.p = at;
    return bench.core.scene().create(spec, bench.core.client(bench.administration)).value();
  };
  const std::uint32_t put = make("put", {0.1, 0, 0});
  make("falls", {0, 0, 0.3});
  ASSERT_TRUE(bench.core.scene().setBody("falls", {.mass = 0.2}).ok());
  ASSERT_TRUE(bench.core.scene().setGravity({0, 0, -9.81}).ok());
  bench.step(20);
  const hd_object_pose pose = poseMessage(put, {{0.1, 0.2, 0.125}, Quat::Identity()});
  std::uint64_t seq = 0;
  ASSERT_EQ(bench.client->producer->push(HD_COMMAND_OBJECT_POSE, std::as_bytes(std::span(&pose, 1)), 0, seq),
            ErrorCode::kOk);
  bench.step(150);
  bench.core.disconnect(bench.connection);
  bench.step(100);
  ASSERT_TRUE(bench.core.closeDevice("test://first", bench.administration).ok());
  ASSERT_TRUE(bench.core.devices().links().empty());
  EXPECT_EQ(bench.core.scene().find("put")->spec.X_PO.p, Vec3(0.1, 0.2, 0.125));
  EXPECT_LT(bench.core.scene().find("falls")->spec.X_PO.p.z(), 0.1);
}

/** At once, so that its servo has not taken the end of the session, and among more than it shows in a cycle. */
TEST(AGroupThatCloses, LeavesNothingOnTheWayThatASessionGaveIt) {
  Bench bench;
  ASSERT_NE(bench.live(), nullptr);
  std::vector<std::uint32_t> ids;
  for (int i = 0; i < 100; ++i) {
    ObjectSpec spec;
    spec.name = "o" + std::to_string(i);
    spec.shape = {ShapeKind::kSphere, {0.01, 0, 0}, 0};
    spec.material = kDefaultMaterial;
    ids.push_back(bench.core.scene().create(spec, bench.core.client(bench.administration)).value());
  }
  bench.step(103);
  ids.resize(48);  // So many are taken in three ticks.
  for (const std::uint32_t id : ids) {
    const hd_object_pose pose = poseMessage(id, {{0.1, 0.2, 0.3}, Quat::Identity()}, {{0.05, 0, 0}, {0, 0, 0}});
    std::uint64_t seq = 0;
    ASSERT_EQ(bench.client->producer->push(HD_COMMAND_OBJECT_POSE, std::as_bytes(std::span(&pose, 1)), 0, seq),
              ErrorCode::kOk);
  }
  bench.step(4);
  bench.core.disconnect(bench.connection);
  ASSERT_TRUE(bench.core.closeDevice("test://first", bench.administration).ok());
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const auto now = bench.core.scene().find("o" + std::to_string(i));
    EXPECT_LT((now->spec.X_PO.p - Vec3(0.1, 0.2, 0.3)).norm(), 1e-3) << i;
    EXPECT_TRUE(now->V_PO.v.isZero(0)) << i;
  }
}

TEST(AGroupThatCloses, LeavesItsToolWhereTheHandHadIt) {
  Bench bench;
  const Client& by = bench.core.client(bench.administration);
  ObjectSpec spec;
  spec.name = "tool";
  spec.shape = {ShapeKind::kBox, {0.01, 0.01, 0.01}, 0};
  spec.material = kDefaultMaterial;
  ASSERT_TRUE(bench.core.scene().create(spec, by).ok());
  ASSERT_TRUE(bench.core.openDevice("test://second").ok());
  ASSERT_TRUE(bench.core.attachTool(bench.device(0), {.object = "tool"}, by).ok());
  for (int i = 0; i < 200; ++i) {
    bench.scripted[0]->sample.p.x() = 2e-4 * i;
    bench.step();
  }
  const auto seen = [&]() -> const SceneObject& {
    return *bench.core.devices().links().back()->group().servo().cycle().scene().find(
        bench.core.scene().find("tool")->id);
  };
  ASSERT_GT(seen().V_WO.v.x(), 0.1) << "by the other group";
  ASSERT_TRUE(bench.core.closeDevice("test://first", bench.administration).ok());
  bench.step(20);
  const Vec3 let_go = seen().X_WO.p;
  bench.step(500);
  EXPECT_EQ(seen().X_WO.p, let_go);
  EXPECT_TRUE(bench.core.scene().find("tool")->V_PO.v.isZero(0));
}

}  // namespace
}  // namespace hapticd::test
