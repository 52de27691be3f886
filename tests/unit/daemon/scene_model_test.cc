#include "daemon/scene/scene_model.h"

#include <gmock/gmock.h>

#include <functional>
#include <limits>

#include "drivers/did_you_mean.h"
#include "tests/unit/daemon/fake_sink.h"

namespace hapticd::test {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

class SceneModelTest : public ::testing::Test {
 protected:
  SceneModelTest() { scene.attach(sink); }
  static Client client(std::uint64_t connection, std::uint32_t uid = 1000, bool administration = false) {
    return {connection, "c" + std::to_string(connection), 1, uid, administration};
  }
  static ObjectSpec sphere(std::string name, std::string parent = {}) {
    ObjectSpec spec;
    spec.name = std::move(name);
    spec.parent = std::move(parent);
    spec.shape = {ShapeKind::kSphere, {0.01, 0, 0}, 0};
    spec.material = kDefaultMaterial;
    return spec;
  }
  /** Of one of sphere()'s. */
  static PosedObject asMade(std::uint32_t id) {
    PosedObject posed;
    posed.object = id;
    posed.flags = HD_OBJECT_ENABLED | HD_OBJECT_VISIBLE;
    posed.material = kDefaultMaterial;
    posed.q_PO[0] = 1;
    return posed;
  }
  /** By a client of that servo. */
  static void move(FakeSink& servo, double x) {
    servo.board.p_PO[0] = x;
    ++servo.board.client_edits[SceneObject::kPlace];
  }
  std::vector<CommandKind> kinds(const FakeSink& of) const {
    std::vector<CommandKind> out;
    for (const Command& c : of.orders) out.push_back(c.kind);
    return out;
  }
  MeshStore meshes;
  SceneModel scene{meshes};
  FakeSink sink;
};

TEST_F(SceneModelTest, WhoseMoverIsGoneStandsUnlessAnotherMovesIt) {
  scene.attach(sink);
  const std::uint32_t id = scene.create(sphere("a"), client(1)).value();
  const Twist V{{0.1, 0, 0}, {0, 0, 0}};
  ASSERT_TRUE(scene.setVelocity("a", V).ok());
  scene.stand(id, {{0.1, 0, 0.1}, {0, 0, 0}});
  EXPECT_EQ(scene.find("a")->V_PO.v, V.v);
  scene.stand(id, V);
  EXPECT_TRUE(scene.find("a")->V_PO.v.isZero(0));
}

TEST_F(SceneModelTest, EveryEditGoesToEveryServoInOrder) {
  FakeSink second;
  scene.attach(second);
  ASSERT_TRUE(scene.create(sphere("a"), client(1)).ok());
  ASSERT_TRUE(scene.setPose("a", {{0, 0, 1}, Quat::Identity()}).ok());
  ASSERT_TRUE(scene.setMaterial("a", {100, 1, 0.5, 0.5}).ok());
  ASSERT_TRUE(scene.setFlags("a", {.enabled = false}).ok());
  ASSERT_TRUE(scene.setShape("a", {ShapeKind::kBox, {1, 1, 1}, 0}).ok());
  ASSERT_TRUE(scene.remove("a", client(1)).ok());
  const auto expected =
      testing::ElementsAre(CommandKind::kAddObject, CommandKind::kObjectPose, CommandKind::kObjectMaterial,
                           CommandKind::kObjectFlags, CommandKind::kSetShape, CommandKind::kRemoveObject);
  EXPECT_THAT(kinds(sink), expected);
  EXPECT_THAT(kinds(second), expected);
}

TEST_F(SceneModelTest, ALateServoGetsParentsBeforeChildren) {
  ASSERT_TRUE(scene.create(sphere("z_root"), client(1)).ok());
  ASSERT_TRUE(scene.create(sphere("a_child", "z_root"), client(1)).ok());
  ASSERT_TRUE(scene.create(sphere("a_grandchild", "a_child"), client(1)).ok());
  FakeSink late;
  scene.attach(late);
  ASSERT_EQ(late.orders.size(), 3u);
  std::uint32_t parent = 0;
  for (const Command& order : late.orders) {
    EXPECT_EQ(order.kind, CommandKind::kAddObject);
    EXPECT_EQ(order.as<AddObject>().parent, parent);
    parent = order.as<AddObject>().object;
  }
}

TEST_F(SceneModelTest, RemovingTakesChildrenFirst) {
  const auto a = scene.create(sphere("a"), client(1));
  const auto b = scene.create(sphere("b", "a"), client(1));
  sink.orders.clear();
  ASSERT_TRUE(scene.remove("a", client(1)).ok());
  ASSERT_EQ(sink.orders.size(), 2u);
  EXPECT_EQ(sink.orders[0].as<ObjectRef>().object, *b);
  EXPECT_EQ(sink.orders[1].as<ObjectRef>().object, *a);
  EXPECT_EQ(scene.size(), 0u);
}

TEST_F(SceneModelTest, AReusedSlotHasAnotherId) {
  const auto first = scene.create(sphere("a"), client(1));
  std::vector<std::uint32_t> seen{*first};
  for (int i = 0; i < 600; ++i) {
    ASSERT_TRUE(scene.remove("a", client(1)).ok());
    const auto id = scene.create(sphere("a"), client(1));
    ASSERT_TRUE(id.ok());
    EXPECT_NE(objectSlot(*id), 0u);
    EXPECT_LT(objectSlot(*id), kMaxObjects);
    EXPECT_THAT(seen, testing::Not(testing::Contains(*id)));
    seen.push_back(*id);
  }
}

TEST_F(SceneModelTest, BadSpecsAreRefusedByFieldAndChangeNothing) {
  ASSERT_TRUE(scene.create(sphere("there"), client(1)).ok());
  const std::size_t orders = sink.orders.size();
  const auto refused = [&](const std::function<void(ObjectSpec&)>& spoil) {
    ObjectSpec spec = sphere("x");
    spoil(spec);
    const auto r = scene.create(spec, client(1));
    EXPECT_TRUE(r.ok() || !r.error().remedy.empty()) << toString(r.error());
    return r.ok() ? std::string("accepted") : r.error().where;
  };
  EXPECT_EQ(refused([](auto& s) { s.name = ""; }), "object.name");
  EXPECT_EQ(refused([](auto& s) { s.name = "a/b"; }), "object.name");
  EXPECT_EQ(refused([](auto& s) { s.name = ".."; }), "object.name");
  EXPECT_EQ(refused([](auto& s) { s.name = std::string(64, 'a'); }), "object.name");
  EXPECT_EQ(refused([](auto& s) { s.name = "there"; }), "object.name");
  EXPECT_EQ(refused([](auto& s) { s.parent = "nobody"; }), "object.parent");
  EXPECT_EQ(refused([](auto& s) { s.X_PO.p.y() = kNaN; }), "object.pose.p.y");
  EXPECT_EQ(refused([](auto& s) { s.X_PO.p.z() = 1e9; }), "object.pose.p.z");
  EXPECT_EQ(refused([](auto& s) { s.X_PO.q = Quat(0, 0, 0, 0); }), "object.pose.q");
  EXPECT_EQ(refused([](auto& s) { s.X_PO.q = Quat(kNaN, 0, 0, 0); }), "object.pose.q");
  EXPECT_EQ(refused([](auto& s) { s.shape.size.x() = 0; }), "object.shape.size.x");
  EXPECT_EQ(refused([](auto& s) { s.shape.size.x() = kNaN; }), "object.shape.size.x");
  EXPECT_EQ(refused([](auto& s) { s.shape = {ShapeKind::kBox, {1, -1, 1}, 0}; }), "object.shape.size.y");
  EXPECT_EQ(refused([](auto& s) { s.shape = {ShapeKind::kCapsule, {1, 0, 0}, 0}; }), "object.shape.size.y");
  EXPECT_EQ(refused([](auto& s) { s.shape = {ShapeKind::kMesh, Vec3::Zero(), 77}; }), "object.shape.mesh");
  EXPECT_EQ(refused([](auto& s) { s.shape.kind = static_cast<ShapeKind>(99); }), "object.shape.kind");
  EXPECT_EQ(refused([](auto& s) { s.material.stiffness = -1; }), "object.material.stiffness");
  EXPECT_EQ(refused([](auto& s) { s.material.damping = kNaN; }), "object.material.damping");
  EXPECT_EQ(refused([](auto& s) { s.material.friction_dynamic = 0.9; }), "object.material.frictionDynamic");
  EXPECT_EQ(sink.orders.size(), orders);
  EXPECT_EQ(scene.size(), 1u);
}

TEST_F(SceneModelTest, ANearlyUnitQuaternionIsMadeUnit) {
  ObjectSpec spec = sphere("a");
  spec.X_PO.q = Quat(1.0005, 0, 0, 0);
  ASSERT_TRUE(scene.create(spec, client(1)).ok());
  EXPECT_EQ(sink.orders[0].as<AddObject>().q[0], 1.0);
}

TEST_F(SceneModelTest, QuotaCountsPerUser) {
  scene.setQuota(2);
  ASSERT_TRUE(scene.create(sphere("a"), client(1, 1000)).ok());
  ASSERT_TRUE(scene.create(sphere("b"), client(2, 1000)).ok());
  const Error full = scene.create(sphere("c"), client(3, 1000)).error();
  EXPECT_EQ(full.code, ErrorCode::kQuotaExceeded);
  EXPECT_THAT(full.remedy, testing::HasSubstr("quotas.objects")) << "as the configuration calls it";
  EXPECT_TRUE(scene.create(sphere("c"), client(4, 1001)).ok());
}

TEST_F(SceneModelTest, TheSceneHoldsItsMostAndThenRefuses) {
  for (std::uint32_t i = 1; i < kMaxObjects; ++i) {
    ASSERT_TRUE(scene.create(sphere("o" + std::to_string(i)), client(1)).ok()) << i;
  }
  EXPECT_EQ(scene.create(sphere("more"), client(2, 5)).error().code, ErrorCode::kQuotaExceeded);
  ASSERT_TRUE(scene.remove("o7", client(1)).ok());
  EXPECT_TRUE(scene.create(sphere("more"), client(2, 5)).ok());
}

TEST_F(SceneModelTest, OnlyTheMakersUserOrAdministrationRemoves) {
  ASSERT_TRUE(scene.create(sphere("a"), client(1, 1000)).ok());
  ASSERT_TRUE(scene.create(sphere("b", "a"), client(2, 1001)).ok());
  EXPECT_EQ(scene.remove("b", client(1, 1000)).error().code, ErrorCode::kPermissionDenied);
  EXPECT_EQ(scene.remove("a", client(1, 1000)).error().code, ErrorCode::kPermissionDenied) << "it carries another's";
  EXPECT_EQ(scene.size(), 2u);
  EXPECT_TRUE(scene.remove("a", client(9, 0, true)).ok());
  EXPECT_EQ(scene.size(), 0u);
}

TEST_F(SceneModelTest, LeavingTakesOnesObjectsButNotThoseKeptOrCarryingOthers) {
  ASSERT_TRUE(scene.create(sphere("mine"), client(1)).ok());
  ASSERT_TRUE(scene.create(sphere("below", "mine"), client(1)).ok());
  ObjectSpec kept = sphere("kept");
  kept.keep = true;
  ASSERT_TRUE(scene.create(kept, client(1)).ok());
  ASSERT_TRUE(scene.create(sphere("carrier"), client(1)).ok());
  ASSERT_TRUE(scene.create(sphere("rider", "carrier"), client(2)).ok());
  ASSERT_TRUE(scene.create(sphere("shelf"), client(1)).ok());
  kept.name = "on_shelf";
  kept.parent = "shelf";
  ASSERT_TRUE(scene.create(kept, client(1)).ok());
  scene.clientLeft(1);
  EXPECT_THAT(scene.names(), testing::ElementsAre("carrier", "kept", "on_shelf", "rider", "shelf"));
  for (const char* name : {"shelf", "on_shelf"}) EXPECT_EQ(scene.find(name)->owner, "") << name;
  EXPECT_EQ(scene.find("carrier")->owner, "c2");
  EXPECT_EQ(scene.find("kept")->owner, "");
  EXPECT_EQ(scene.remove("kept", client(3, 1001)).error().what, "'kept' belongs to user 1000");
  EXPECT_EQ(scene.remove("rider", client(3, 1001)).error().what, "'rider' belongs to 'c2' of user 1000");
  scene.clientLeft(2);
  EXPECT_THAT(scene.names(), testing::ElementsAre("kept", "on_shelf", "shelf"));
}

TEST_F(SceneModelTest, ADeadServoRefusesEditsBeforeTheyHappen) {
  ASSERT_TRUE(scene.create(sphere("a"), client(1)).ok());
  sink.accepts = false;
  EXPECT_EQ(scene.create(sphere("b"), client(1)).error().code, ErrorCode::kWouldBlock);
  EXPECT_EQ(scene.setPose("a", {}).error().code, ErrorCode::kWouldBlock);
  EXPECT_EQ(scene.remove("a", client(1)).error().code, ErrorCode::kWouldBlock);
  EXPECT_EQ(sink.orders.size(), 1u);
  EXPECT_EQ(scene.size(), 1u);
}

TEST_F(SceneModelTest, ThePoseInForceWinsOnceTheLastEditHasPassed) {
  const auto id = scene.create(sphere("a"), client(1));
  sink.board.object = *id;
  sink.board.p_PO[0] = 0.5;
  sink.board.q_PO[0] = 1;
  sink.board.material = {250, 0, 0, 0};
  sink.board.flags = HD_OBJECT_ENABLED;
  EXPECT_EQ(scene.find("a")->spec.X_PO.p.x(), 0.0) << "the board is from before the edit";
  sink.taken = sink.orders.size();
  EXPECT_EQ(scene.find("a")->spec.X_PO.p.x(), 0.5);
  EXPECT_EQ(scene.find("a")->spec.material.stiffness, 250);
  EXPECT_FALSE(scene.find("a")->spec.flags.visible);
  ASSERT_TRUE(scene.setPose("a", {{0.1, 0, 0}, Quat::Identity()}).ok());
  EXPECT_EQ(scene.find("a")->spec.X_PO.p.x(), 0.1) << "what was set is what is answered";
}

TEST_F(SceneModelTest, AnEditKeepsWhatClientsChangedThroughTheirRings) {
  const auto id = *scene.create(sphere("ball"), client(1));
  const struct {
    const char* what;
    std::function<Result<void>()> edit;
  } edits[] = {{"material",
                [&] {
                  return scene.setMaterial("ball", {700, 1, 0, 0});
                }},
               {"surface", [&] { return scene.setSurface("ball", SurfaceSpec{}); }},
               {"body", [&] { return scene.setBody("ball", BodySpec{}); }},
               {"flags", [&] { return scene.setFlags("ball", {}); }},
               {"shape", [&] { return scene.setShape("ball", sphere("ball").shape); }}};
  for (const auto& [what, edit] : edits) {
    sink.taken = sink.orders.size();
    sink.board = {};
    sink.board.object = id;
    sink.board.p_PO[0] += 7;
    sink.board.q_PO[0] = 1;
    sink.board.flags = HD_OBJECT_ENABLED;
    ASSERT_TRUE(edit().ok()) << what;  // The servo takes it later than the question below.
    EXPECT_EQ(scene.find("ball")->spec.X_PO.p.x(), 7) << what;
    ASSERT_TRUE(scene.setPose("ball", Pose{}).ok());
  }
  sink.taken = sink.orders.size();
  sink.board.material.stiffness = 123;
  ASSERT_TRUE(scene.setPose("ball", Pose{}).ok());
  EXPECT_EQ(scene.find("ball")->spec.material.stiffness, 123);
}

/** Of a full scene the board is 128 ticks old, and a program may give a velocity each of them. */
TEST_F(SceneModelTest, AVelocityPutsAnObjectOnItsWayNotBackOnIt) {
  const auto id = *scene.create(sphere("ball"), client(1));
  sink.board = asMade(id);
  sink.board.p_PO[0] = 0.5;
  sink.board.v_PO[0] = 0.1;
  sink.board.w_PO[2] = 2;
  sink.board.tick = 1000;
  sink.taken = sink.orders.size();
  sink.next_tick = 1040;
  const auto give = [&](double v) {
    EXPECT_TRUE(scene.setVelocity("ball", {{v, 0, 0}, {0, 0, 0}}).ok());
    return sink.orders.back().as<hd_object_pose>();
  };
  hd_object_pose pose = give(0.3);
  EXPECT_NEAR(pose.p[0], 0.504, 1e-12);
  EXPECT_NEAR(2 * std::atan2(pose.q[3], pose.q[0]), 0.08, 1e-9) << "it turns on as well";
  // The next ones come before the board tells of the last.
  sink.next_tick = 1050;
  pose = give(0.7);
  EXPECT_NEAR(pose.p[0], 0.507, 1e-12);
  EXPECT_NEAR(2 * std::atan2(pose.q[3], pose.q[0]), 0.08, 1e-9);
  EXPECT_NEAR(give(0.7).p[0], 0.507, 1e-12) << "in the same tick";
  ASSERT_TRUE(scene.setPose("ball", {}).ok());
  sink.next_tick = 1060;
  EXPECT_EQ(give(1).p[0], 0) << "where it rested";
}

TEST_F(SceneModelTest, AVelocityPutsABodyNotThroughWhatItMayHaveMetMeanwhile) {
  const auto id = *scene.create(sphere("ball"), client(1));
  BodySpec body;
  body.mass = 0.1;
  ASSERT_TRUE(scene.setBody("ball", body).ok());
  sink.board = asMade(id);
  sink.board.v_PO[2] = -2;
  sink.board.tick = 1000;
  sink.taken = sink.orders.size();
  sink.next_tick = 1016;
  ASSERT_TRUE(scene.setVelocity("ball", {}).ok());
  EXPECT_EQ(sink.orders.back().as<hd_object_pose>().p[2], 0);
}

TEST_F(SceneModelTest, TheTicksOfAServoThatHasGoneMoveNothing) {
  const auto id = *scene.create(sphere("ball"), client(1));
  sink.board = asMade(id);
  sink.board.v_PO[0] = 0.1;
  sink.board.tick = 1000;
  sink.taken = sink.orders.size();
  EXPECT_EQ(scene.find("ball")->V_PO.v.x(), 0.1);
  scene.detach(sink);
  FakeSink next;
  next.next_tick = 1'000'000;
  scene.attach(next);
  ASSERT_TRUE(scene.setVelocity("ball", {}).ok());
  EXPECT_EQ(next.orders.back().as<hd_object_pose>().p[0], 0);
}

/** One program moves it through one servo, another hides it through a second one. */
TEST_F(SceneModelTest, WhoMovesAnObjectPutsNothingBackThatOthersChange) {
  FakeSink second;
  scene.attach(second);
  const auto id = *scene.create(sphere("heart"), client(1));
  for (FakeSink* each : {&sink, &second}) {
    each->board = asMade(id);
    each->taken = 1;  // Only what made it.
  }
  second.board.flags = HD_OBJECT_ENABLED;
  ++second.board.client_edits[SceneObject::kFlags];
  for (int i = 1; i <= 3; ++i) {
    move(sink, 0.01 * i);
    scene.followClients();
  }
  constexpr auto kAdd = CommandKind::kAddObject, kPose = CommandKind::kObjectPose;
  EXPECT_THAT(kinds(second), testing::ElementsAre(kAdd, kPose));
  ASSERT_THAT(kinds(sink), testing::ElementsAre(kAdd, CommandKind::kObjectFlags));
  EXPECT_EQ(sink.orders.back().as<hd_object_flags>().value, HD_OBJECT_ENABLED + 0u);
  EXPECT_EQ(scene.find("heart")->spec.X_PO.p.x(), 0.03);
  EXPECT_FALSE(scene.find("heart")->spec.flags.visible);
}

/** A recording makes a servo's cycle anew, which then counts from the start. */
TEST_F(SceneModelTest, WhatIsChangedAfterACycleWasMadeAnewIsHandedOn) {
  FakeSink second;
  scene.attach(second);
  sink.board = asMade(*scene.create(sphere("heart"), client(1)));
  sink.taken = second.taken = 1;
  for (const double x : {0.1, 0.2}) {
    sink.board.p_PO[0] = x;
    sink.board.client_edits[SceneObject::kPlace] = 1;
    scene.followClients();
    ASSERT_EQ(second.orders.back().kind, CommandKind::kObjectPose);
    EXPECT_EQ(second.orders.back().as<hd_object_pose>().p[0], x);
    second.taken = second.orders.size();
    scene.madeAnew(sink);
  }
}

/** On a conveyor, say: that its place is another than it was is nobody's edit. */
TEST_F(SceneModelTest, AnEditOfOnePartHandsOnNoOtherThatMovesByItself) {
  FakeSink second;
  scene.attach(second);
  const auto id = *scene.create(sphere("parcel"), client(1));
  for (FakeSink* each : {&sink, &second}) {
    each->board = asMade(id);
    each->board.p_PO[0] = 0.001;
    each->board.v_PO[0] = 0.1;
    each->taken = 1;
  }
  move(second, 0.5);
  sink.board.material.stiffness = 123;
  ++sink.board.client_edits[SceneObject::kMaterial];
  scene.followClients();
  ASSERT_THAT(kinds(second), testing::ElementsAre(CommandKind::kAddObject, CommandKind::kObjectMaterial));
  ASSERT_THAT(kinds(sink), testing::ElementsAre(CommandKind::kAddObject, CommandKind::kObjectPose));
  EXPECT_EQ(sink.orders.back().as<hd_object_pose>().p[0], 0.5);
  EXPECT_EQ(scene.find("parcel")->spec.X_PO.p.x(), 0.5);
}

TEST_F(SceneModelTest, ALateServoHearsOfAnObjectBeforeWhatClientsChangeOfIt) {
  sink.board = asMade(*scene.create(sphere("heart"), client(1)));
  sink.taken = 1;
  move(sink, 0.3);
  FakeSink late;
  scene.attach(late);
  ASSERT_THAT(kinds(late), testing::ElementsAre(CommandKind::kAddObject));
  EXPECT_EQ(late.orders[0].as<AddObject>().p[0], 0.3);
}

/** A servo four times slower than the one whose clients move things gets no more orders than it takes. */
TEST_F(SceneModelTest, AServoThatLagsIsToldTheNewestWhenItHasTakenTheLast) {
  FakeSink slow;
  scene.attach(slow);
  sink.board = asMade(*scene.create(sphere("heart"), client(1)));
  sink.taken = slow.taken = 1;
  for (int i = 1; i <= 100; ++i) {
    move(sink, 0.01 * i);
    scene.followClients();
  }
  ASSERT_EQ(slow.orders.size(), 2u);
  EXPECT_EQ(slow.orders.back().as<hd_object_pose>().p[0], 0.01);
  slow.taken = 2;
  scene.followClients();
  ASSERT_EQ(slow.orders.size(), 3u);
  EXPECT_EQ(slow.orders.back().as<hd_object_pose>().p[0], 1);
  slow.taken = 3;
  scene.followClients();
  EXPECT_EQ(slow.orders.size(), 3u) << "it knows";
}

TEST_F(SceneModelTest, AServoThatTookNoOrdersIsToldWhenItDoesAgain) {
  FakeSink stuck;
  scene.attach(stuck);
  sink.board = asMade(*scene.create(sphere("heart"), client(1)));
  sink.taken = stuck.taken = 1;
  stuck.board = sink.board;
  stuck.accepts = false;
  move(sink, 0.4);
  scene.followClients();
  EXPECT_EQ(stuck.orders.size(), 1u);
  EXPECT_EQ(scene.find("heart")->spec.X_PO.p.x(), 0.4);
  stuck.accepts = true;
  scene.followClients();
  ASSERT_EQ(stuck.orders.size(), 2u);
  EXPECT_EQ(stuck.orders.back().as<hd_object_pose>().p[0], 0.4);
}

/** What a servo shows after an order of ours may be that order, though its clients have changed something, too. */
TEST_F(SceneModelTest, AnEditThatCrossedAnOrderPutsNothingNewerBack) {
  for (const bool first : {true, false}) {  // Whichever servo comes first.
    SCOPED_TRACE(first);
    MeshStore none;
    SceneModel world(none);
    FakeSink mover, crossed;
    world.attach(first ? mover : crossed);
    world.attach(first ? crossed : mover);
    mover.board = crossed.board = asMade(*world.create(sphere("heart"), client(1)));
    mover.taken = crossed.taken = 1;
    move(mover, 0.1);
    world.followClients();
    ASSERT_EQ(crossed.orders.size(), 2u);
    crossed.taken = 2;
    move(crossed, 0.1);  // Its client's edit came before the order.
    move(mover, 0.2);
    world.followClients();
    EXPECT_EQ(mover.orders.size(), 1u);
    ASSERT_EQ(crossed.orders.size(), 3u);
    EXPECT_EQ(crossed.orders.back().as<hd_object_pose>().p[0], 0.2);
    crossed.taken = 3;
    move(crossed, 0.3);  // Or after it.
    world.followClients();
    ASSERT_EQ(mover.orders.size(), 2u);
    EXPECT_EQ(mover.orders.back().as<hd_object_pose>().p[0], 0.3);
  }
}

TEST_F(SceneModelTest, WorldPosesMultiplyDownTheTree) {
  ObjectSpec turned = sphere("turned");
  turned.X_PO = {{1, 0, 0}, Quat(std::sqrt(0.5), 0, 0, std::sqrt(0.5))};  // 90 degrees about z
  ASSERT_TRUE(scene.create(turned, client(1)).ok());
  ObjectSpec below = sphere("below", "turned");
  below.X_PO.p = {2, 0, 0};
  ASSERT_TRUE(scene.create(below, client(1)).ok());
  const auto now = scene.find("below");
  EXPECT_TRUE(now->X_WO.p.isApprox(Vec3(1, 2, 0), 1e-12));
  EXPECT_EQ(now->path, "/_objects/turned/below");
}

TEST_F(SceneModelTest, UnknownNamesSuggestTheNearest) {
  ASSERT_TRUE(scene.create(sphere("motor"), client(1)).ok());
  const auto r = scene.find("moter");
  ASSERT_FALSE(r.ok());
  EXPECT_EQ(r.error().code, ErrorCode::kNotFound);
  EXPECT_NE(r.error().remedy.find("motor"), std::string::npos);
  EXPECT_EQ(nearestNames("pos", {"rot", "pose", "zzzz", "possible", "pox", "a", "b"}, 2), "pose, pox");
  EXPECT_EQ(nearestNames("friction", {"vibration", "motion", "falls", "friction_static", "friction_dynamic"}, 2),
            "friction_dynamic, friction_static");
  EXPECT_EQ(nearestNames("clutch_button", {"buttons", "contact", "counts", "clutch", "battery"}, 1), "clutch");
}

}  // namespace
}  // namespace hapticd::test
