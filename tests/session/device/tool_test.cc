// An object put into a device's hand by name.
#include <cstring>
#include <functional>
#include <nlohmann/json.hpp>

#include "daemon/builder/build.h"
#include "daemon/resource/resource_tree.h"
#include "tests/session/bench.h"
#include "tests/unit/builder/meshes.h"

namespace hapticd::test {
namespace {

struct ToolBench : testing::Test {
  ToolBench() {
    add("box", ShapeKind::kBox);
    add("table", ShapeKind::kPlane);
    bench.step(3);
  }
  void add(const char* name, ShapeKind kind) {
    ObjectSpec spec;
    spec.name = name;
    spec.shape.kind = kind;
    spec.shape.size = Vec3(0.01, 0.01, 0.01);
    spec.material = kDefaultMaterial;
    const auto made = bench.core.scene().create(spec, anybody);
    ASSERT_TRUE(made.ok()) << toString(made.error());
  }
  [[nodiscard]] std::string path() const { return "/devices/" + device.name + "/tool"; }
  [[nodiscard]] bool held() {
    bool out = false;
    EXPECT_TRUE(device.link->group().betweenCycles([&](Servo& s) { out = s.cycle().tool(0).held(); }).ok());
    return out;
  }

  Bench bench;
  ResourceTree tree{bench.core};
  OpenDevice& device = *bench.core.devices().devices().front();
  Client anybody{.uid = 1000};
};

TEST_F(ToolBench, IsAttachedReadAndDetachedByName) {
  EXPECT_EQ(*tree.get(path(), anybody), "null");
  const auto set = tree.set(path() + "?value=box,0.2,300", anybody);
  ASSERT_TRUE(set.ok()) << toString(set.error());
  const auto json = nlohmann::json::parse(*set);
  EXPECT_EQ(json["object"], "box");
  EXPECT_EQ(json["mass"], 0.2);
  EXPECT_LE(json["stiffness"], 300);
  EXPECT_EQ(json["torque_shown"], device.info().actuated_rotation);
  bench.step(3);
  EXPECT_TRUE(held());
  ASSERT_TRUE(tree.set(path() + "?value=", anybody).ok());
  bench.step(3);
  EXPECT_FALSE(held());
  EXPECT_EQ(*tree.get(path(), anybody), "null");
}

// The answer was the place asked for, and the next one the hand's.
TEST_F(ToolBench, IsWhereTheHandIsAndIsNotPutElsewhere) {
  ASSERT_TRUE(tree.set(path() + "?value=box", anybody).ok());
  bench.step(3);
  for (const char* const place : {"pos?value=0.1,0,0", "rot?value=0,1,0,0", "pose?value=0.1,0,0,1,0,0,0",
                                  "worldpos?value=0.1,0,0", "velocity?value=0.1,0,0"}) {
    const auto refused = tree.set(std::string("/objects/box/") + place, anybody);
    ASSERT_FALSE(refused.ok()) << place << *refused;
    EXPECT_EQ(refused.error().code, ErrorCode::kWouldBlock) << place;
    EXPECT_NE(refused.error().what.find("in the hand of " + device.name), std::string::npos) << refused.error().what;
  }
  EXPECT_TRUE(tree.set("/objects/table/pos?value=0,0,-0.1", anybody).ok());
  ASSERT_TRUE(tree.set(path() + "?value=", anybody).ok());
  bench.step(3);
  EXPECT_EQ(*tree.set("/objects/box/pos?value=0.5,0,0", anybody), "[0.5,0.0,0.0]");
}

TEST_F(ToolBench, KeepsAShapeThatCanBeHeld) {
  ASSERT_TRUE(tree.set(path() + "?value=box", anybody).ok());
  for (const ShapeKind kind : {ShapeKind::kPlane, ShapeKind::kGroup}) {
    const auto refused = bench.core.setShape("box", {kind, {}, 0});
    ASSERT_FALSE(refused.ok());
    EXPECT_NE(refused.error().what.find("in the hand of " + device.name), std::string::npos) << refused.error().what;
  }
  const auto missing = bench.core.setShape("box", {ShapeKind::kMesh, {}, 999});
  ASSERT_FALSE(missing.ok());
  EXPECT_EQ(missing.error().code, ErrorCode::kNotFound) << "not that it deforms: there is none";
  EXPECT_EQ(missing.error().where, "shape.mesh");
  EXPECT_EQ(bench.core.scene().find("box")->spec.shape.kind, ShapeKind::kBox);
  EXPECT_TRUE(bench.core.setShape("box", {ShapeKind::kSphere, {0.01, 0, 0}, 0}).ok());
  ASSERT_TRUE(tree.set(path() + "?value=", anybody).ok());
  EXPECT_TRUE(bench.core.setShape("box", {ShapeKind::kPlane, {}, 0}).ok());
  EXPECT_FALSE(bench.core.setShape("nothing", {ShapeKind::kPlane, {}, 0}).ok());
}

TEST_F(ToolBench, ItsNoteIsThatOfTheShapeItHas) {
  BuildMonitor monitor;
  const auto built = buildSnapshot(upload(torus(12, 8)), monitor);
  ASSERT_TRUE(built.ok());
  const auto mesh = bench.core.meshes().add(std::move(*built->memfd.share()), MeshInfo{.owner = anybody});
  ASSERT_TRUE(mesh.ok());
  ASSERT_TRUE(tree.set(path() + "?value=box", anybody).ok());
  const auto told = [&] { return device.tool.note.find("'box' has no volume") != std::string::npos; };
  EXPECT_FALSE(told());
  ASSERT_TRUE(bench.core.setShape("box", {ShapeKind::kMesh, {}, *mesh}).ok());
  EXPECT_TRUE(told());
  ASSERT_TRUE(bench.core.setShape("box", {ShapeKind::kSphere, {0.01, 0, 0}, 0}).ok());
  EXPECT_FALSE(told());
}

// 5000 N/m were taken without a word.
TEST_F(ToolBench, ItsNoteTellsThatItIsSofterThanAskedFor) {
  for (const char* const asked : {"0", "100", "5000"}) {
    const auto set = tree.set(path() + "?value=box,0.1," + asked, anybody);
    ASSERT_TRUE(set.ok()) << toString(set.error());
    const auto json = nlohmann::json::parse(*set);
    const bool softer = json["stiffness"].get<double>() < 0.99 * std::stod(asked);
    EXPECT_EQ(softer, asked == std::string("5000")) << *set;
    EXPECT_EQ(json["note"].get<std::string>().find("not the 5000 asked for") != std::string::npos, softer) << *set;
  }
}

/** As if it had been attached with that shape. */
TEST_F(ToolBench, WeighsWhatTheShapeItHasWeighs) {
  const auto order = [&] {
    AttachTool out{};
    EXPECT_TRUE(device.link->group().betweenCycles([&](Servo& s) { out = s.cycle().tool(0).order(); }).ok());
    return out;
  };
  const auto attach = [&] {
    ASSERT_TRUE(tree.set(path() + "?value=box,0.2,300,weighs", anybody).ok());
    bench.step(3);
  };
  attach();
  const AttachTool box = order();
  ASSERT_TRUE(bench.core.setShape("box", {ShapeKind::kCapsule, {0.01, 0.1, 0}, 0}).ok());
  bench.step(3);
  const AttachTool capsule = order();
  EXPECT_GT(capsule.inertia[0], 5 * box.inertia[0]);
  const double told = device.tool.stiffness;
  attach();
  const AttachTool anew = order();
  EXPECT_EQ(std::memcmp(&capsule, &anew, sizeof anew), 0) << "with all that was wished for it";
  EXPECT_EQ(told, device.tool.stiffness);
}

TEST_F(ToolBench, IsToldWhenItComesAndWhenItGoes) {
  const auto id = bench.core.events().subscribe(1u << static_cast<unsigned>(EventKind::kObjectChanged), [] {});
  const auto told = [&] {
    std::vector<std::string> all;
    for (const Event& e : bench.core.events().take(id).events) all.push_back(e.device + " " + e.object + " " + e.text);
    return all;
  };
  ASSERT_TRUE(tree.set(path() + "?value=box", anybody).ok());
  EXPECT_EQ(told().size(), 1u);
  ASSERT_TRUE(tree.set(path() + "?value=", anybody).ok());
  EXPECT_EQ(told(), std::vector{device.name + " box tool detached"});
  ASSERT_TRUE(tree.set(path() + "?value=box", anybody).ok());
  add("other", ShapeKind::kBox);
  (void)told();
  ASSERT_TRUE(tree.set(path() + "?value=other", anybody).ok());
  const auto instead = told();
  ASSERT_EQ(instead.size(), 2u);
  EXPECT_EQ(instead.front(), device.name + " box tool detached") << "the hand has put it away for the other";
  ASSERT_TRUE(tree.set(path() + "?value=box", anybody).ok());
  (void)told();
  ASSERT_TRUE(tree.set(path() + "?value=box", anybody).ok());
  EXPECT_EQ(told().size(), 1u) << "as it was";
  ASSERT_TRUE(bench.core.scene().remove("box", anybody).ok());
  add("box", ShapeKind::kBox);
  (void)told();
  ASSERT_TRUE(tree.set(path() + "?value=", anybody).ok());
  EXPECT_TRUE(told().empty()) << "that box never was in a hand";
  ASSERT_TRUE(tree.set(path() + "?value=", anybody).ok());
  EXPECT_TRUE(told().empty()) << "nothing was held";
}

TEST_F(ToolBench, IsToldToBeGoneWithItsHand) {
  ASSERT_TRUE(tree.set(path() + "?value=box", anybody).ok());
  const std::string name = device.name;
  const auto id = bench.core.events().subscribe(1u << static_cast<unsigned>(EventKind::kObjectChanged), [] {});
  bench.client.reset();
  bench.core.disconnect(bench.connection);
  bench.step(3);
  ASSERT_TRUE(bench.core.closeDevice(name, bench.administration).ok());
  const auto told = bench.core.events().take(id).events;
  ASSERT_EQ(told.size(), 1u);
  EXPECT_EQ(told.front().device + " " + told.front().object + " " + told.front().text, name + " box tool detached");
}

TEST_F(ToolBench, WhatIsNoToolIsRefusedByItsReason) {
  const auto code = [&](const char* value) { return tree.set(path() + "?value=" + value, anybody).error().code; };
  EXPECT_EQ(code("nothing"), ErrorCode::kNotFound);
  EXPECT_EQ(code("table"), ErrorCode::kInvalidArgument);
  EXPECT_EQ(code("box,0"), ErrorCode::kInvalidArgument);
  EXPECT_EQ(code("box,nan"), ErrorCode::kInvalidArgument);
  EXPECT_EQ(code("box,0.1,-5"), ErrorCode::kInvalidArgument);
  EXPECT_EQ(code("box,0.1,500,1"), ErrorCode::kInvalidArgument);
  bench.step(3);
  EXPECT_FALSE(held());
}

TEST_F(ToolBench, GoesWithItsObjectAndItsMemoryIsGivenBack) {
  ASSERT_TRUE(tree.set(path() + "?value=box", anybody).ok());
  bench.step(5);
  ASSERT_TRUE(held());
  const std::uint64_t before = device.link->group().taken();
  ASSERT_TRUE(bench.core.scene().remove("box", anybody).ok());
  bench.step(5);
  EXPECT_FALSE(held());
  EXPECT_GT(device.link->group().taken(), before) << "the collide thread holds nothing back";
  EXPECT_EQ(*tree.get(path(), anybody), "null");
}

TEST_F(ToolBench, WeightAndRenderingAreChosenByWords) {
  const auto json = [&](const char* value) {
    const auto set = tree.set(path() + "?value=" + value, anybody);
    EXPECT_TRUE(set.ok()) << toString(set.error());
    bench.step(3);
    return nlohmann::json::parse(set.ok() ? *set : "{}");
  };
  const auto plain = json("box");
  EXPECT_EQ(plain["weight"], "compensated");
  EXPECT_EQ(plain["rendering"], "coupled");
  const auto words = json("box,0.3,direct,weighs");
  EXPECT_EQ(words["mass"], 0.3);
  EXPECT_EQ(words["weight"], "felt");
  EXPECT_EQ(words["rendering"], "direct");
  std::uint32_t flags = 0;
  EXPECT_TRUE(device.link->group().betweenCycles([&](Servo& s) { flags = s.cycle().tool(0).order().flags; }).ok());
  EXPECT_EQ(flags, kToolWeighs | kToolDirect);
  EXPECT_EQ(tree.set(path() + "?value=box,heavy", anybody).error().code, ErrorCode::kInvalidArgument);
}

TEST_F(ToolBench, ThatTorqueIsNotShownIsToldByAnEvent) {
  ASSERT_FALSE(device.info().actuated_rotation);
  const std::uint64_t id = bench.core.events().subscribe(0, [] {});
  ASSERT_TRUE(tree.set(path() + "?value=box", anybody).ok());
  const std::vector<Event> told = bench.core.events().take(id).events;
  ASSERT_FALSE(told.empty());
  EXPECT_EQ(told.back().object, "box");
  EXPECT_EQ(told.back().device, device.name);
  EXPECT_NE(told.back().text.find("cannot show torque"), std::string::npos);
}

/** Runs something while the collide thread finds an answer, which asks for the time. */
class DuringAnswer final : public Clock {
 public:
  explicit DuringAnswer(std::function<void()> work) : work_(std::move(work)) {}
  [[nodiscard]] std::int64_t now() HD_RT override {
    if (auto work = std::exchange(work_, nullptr)) work();
    return 0;
  }
  void sleepUntil(std::int64_t) HD_RT override {}

 private:
  std::function<void()> work_;
};

/** Else the memory of a mesh that an order drops would be gone under the answer. */
TEST_F(ToolBench, WhatTheCollideThreadStillReadsIsNotTaken) {
  ASSERT_TRUE(tree.set(path() + "?value=box,0.2,300", anybody).ok());
  bench.step(3);
  DeviceGroup& group = device.link->group();
  group.servo().runOnce();
  ASSERT_EQ(group.taken(), group.sent());
  std::uint64_t during = 0;
  DuringAnswer clock([&] {
    device.applyRadius();
    group.servo().runOnce();
    during = group.taken();
  });
  group.servo().collider->step(&clock);
  EXPECT_EQ(during + 1, group.sent()) << "the servo has passed the order, the answer is older than it";
  EXPECT_EQ(group.taken(), group.sent());
}

TEST_F(ToolBench, AGripTakesAGripperThatCanPush) {
  const std::string grip = "/devices/" + device.name + "/grip";
  EXPECT_EQ(*tree.get(grip, anybody), "null");
  ASSERT_FALSE(device.info().actuated_gripper);
  EXPECT_EQ(tree.set(grip + "?value=10,0.1", anybody).error().code, ErrorCode::kUnsupported);
  EXPECT_EQ(tree.set(grip + "?value=-1,0", anybody).error().code, ErrorCode::kInvalidArgument);
  EXPECT_TRUE(tree.set(grip + "?value=", anybody).ok());
}

TEST_F(ToolBench, AMassMakesAnObjectMoveAndGravityMakesItFall) {
  const auto set = [&](const std::string& uri) { return tree.set(uri, anybody); };
  const auto z = [&] { return bench.core.scene().find("box")->X_WO.p.z(); };
  EXPECT_EQ(*tree.get("/objects/box/mass", anybody), "0.0");
  ASSERT_TRUE(set("/objects/box/mass?value=0.2").ok());
  ASSERT_TRUE(set("/objects/box/pos?value=0,0,0.5").ok());
  ASSERT_TRUE(set("/world/gravity?value=0,0,-9.81").ok());
  EXPECT_EQ(*tree.get("/world/gravity", anybody), "[0.0,0.0,-9.81]");
  const auto group = [&](int ticks) {
    for (int i = 0; i < ticks; ++i) {
      bench.step(1);
      EXPECT_TRUE(device.link->group().betweenCycles([](Servo& s) { s.collider->step(nullptr); }).ok());
    }
  };
  group(100);
  EXPECT_LT(z(), 0.49);
  // A servo that comes later, and a recording's start, get it with its mass.
  const auto orders = bench.core.scene().orders(*bench.core.devices().links().front());
  const auto count = [&](CommandKind kind) {
    return std::count_if(orders.begin(), orders.end(), [&](const Command& c) { return c.kind == kind; });
  };
  EXPECT_EQ(count(CommandKind::kSetBody), 1);
  EXPECT_EQ(count(CommandKind::kSetGravity), 1);
  ASSERT_TRUE(set("/objects/box/falls?value=false").ok());
  ASSERT_TRUE(set("/objects/box/mass?value=0").ok());
  group(20);
  const double still = z();
  group(20);
  EXPECT_EQ(z(), still);

  EXPECT_EQ(set("/objects/table/mass?value=1").error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(set("/objects/box/mass?value=1e9").error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(set("/objects/box/motion_damping?value=-1").error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(set("/world/gravity?value=0,0,-1e5").error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(set("/world/levity?value=1").error().code, ErrorCode::kNotFound);
}

TEST_F(ToolBench, NoMoreObjectsMoveThanAServoKeepsUpWith) {
  for (std::uint32_t i = 0; i <= kMaxBodies; ++i) {
    const std::string name = "b" + std::to_string(i);
    add(name.c_str(), ShapeKind::kSphere);
    const auto set = tree.set("/objects/" + name + "/mass?value=0.1", anybody);
    if (i < kMaxBodies) {
      ASSERT_TRUE(set.ok()) << toString(set.error());
    } else {
      EXPECT_EQ(set.error().code, ErrorCode::kQuotaExceeded);
    }
  }
}

TEST_F(ToolBench, AnothersLeaseBinds) {
  ASSERT_TRUE(bench.core.acquireLease(bench.live()->id).ok());
  EXPECT_EQ(tree.set(path() + "?value=box", Client{.uid = 1001}).error().code, ErrorCode::kLeaseHeld);
  EXPECT_TRUE(tree.set(path() + "?value=box", Client{.uid = 0, .administration = true}).ok());
}

}  // namespace
}  // namespace hapticd::test
