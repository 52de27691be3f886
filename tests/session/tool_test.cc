// An object put into a device's hand by name.
#include <nlohmann/json.hpp>

#include "daemon/resource/resource_tree.h"
#include "tests/session/bench.h"

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

TEST_F(ToolBench, AnothersLeaseBinds) {
  ASSERT_TRUE(bench.core.acquireLease(bench.live()->id).ok());
  EXPECT_EQ(tree.set(path() + "?value=box", Client{.uid = 1001}).error().code, ErrorCode::kLeaseHeld);
  EXPECT_TRUE(tree.set(path() + "?value=box", Client{.uid = 0, .administration = true}).ok());
}

}  // namespace
}  // namespace hapticd::test
