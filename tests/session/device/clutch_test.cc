// A hand that is taken off its point in the world: by a word, by a button, and what becomes of it with who held it.
#include <nlohmann/json.hpp>

#include "daemon/resource/resource_tree.h"
#include "tests/session/bench.h"

namespace hapticd::test {
namespace {

const Client kSomebody{.uid = 1000};

/** The bench's device, through the names that a client reads and writes. */
struct ClutchBench : Bench {
  explicit ClutchBench(const Config& config = relaxed()) : Bench(config), tree(core) {
    path = "/devices/" + device().name;
  }
  void clutch(const std::string& value) {
    const auto set = tree.set(path + "/clutch?value=" + value, kSomebody);
    EXPECT_TRUE(set.ok()) << toString(set.error());
    step(3);
  }
  nlohmann::json get(const std::string& name) { return nlohmann::json::parse(*tree.get(path + "/" + name, kSomebody)); }
  void hand(const Vec3& p) {
    scripted[0]->sample.p = p;
    step(3);
  }
  ResourceTree tree;
  std::string path;
};

TEST(DeviceClutch, HeldByAWordThePointStandsStillAndTheMountIsToldAfterwards) {
  ClutchBench bench;
  bench.hand({0.01, 0, 0});
  bench.clutch("held");
  EXPECT_EQ(bench.get("clutch")["held"], true);
  EXPECT_EQ(bench.get("clutch")["off"], true);
  EXPECT_NE(bench.sample().flags & HD_SAMPLE_CLUTCHED, 0u);
  bench.hand({-0.04, 0, 0});
  EXPECT_EQ(bench.get("pos")[0], 0.01);
  bench.clutch("released");
  bench.core.poll();
  EXPECT_EQ(bench.get("clutch")["off"], false);
  EXPECT_NEAR(bench.get("mount")["pos"][0].get<double>(), 0.05, 1e-15);
  bench.hand({-0.05, 0, 0});
  EXPECT_NEAR(bench.get("pos")[0].get<double>(), 0, 1e-15);
  ASSERT_TRUE(bench.tree.set(bench.path + "/scale?value=2", kSomebody).ok());
  bench.step(3);
  EXPECT_NEAR(bench.get("pos")[0].get<double>(), -0.05, 1e-15) << "what is set next stands where the clutch has put it";
}

TEST(DeviceClutch, AButtonThatItDoesNotHaveIsRefused) {
  ClutchBench bench;
  const auto refused = bench.tree.set(bench.path + "/clutch?value=3", kSomebody);
  ASSERT_FALSE(refused.ok()) << "it would never be held, and nobody told";
  EXPECT_NE(refused.error().what.find("it has 0"), std::string::npos) << refused.error().what;
  EXPECT_TRUE(bench.get("clutch")["button"].is_null());
  bench.scripted[0]->setButtons(2);
  EXPECT_FALSE(bench.tree.set(bench.path + "/clutch?value=3", kSomebody).ok());
  bench.core.lines().button_count = 1;  // The panel's follow its own.
  bench.clutch("3");
  EXPECT_EQ(bench.get("clutch")["button"], 3);
  bench.core.lines().button_count = 31;  // Too many beside its own: the servo leaves them all out.
  EXPECT_FALSE(bench.tree.set(bench.path + "/clutch?value=4", kSomebody).ok());
}

TEST(DeviceClutch, AButtonOfTheConfigurationHoldsIt) {
  Config config = Bench::relaxed();
  config.devices.emplace_back();
  config.devices.back().uri = "test://first";
  config.devices.back().clutch_button = 2;
  ClutchBench bench(config);
  EXPECT_EQ(bench.get("clutch")["button"], 2);
  bench.scripted[0]->sample.buttons = 2;
  bench.step(3);
  EXPECT_EQ(bench.get("clutch")["off"], true);
  bench.clutch("0");
  EXPECT_EQ(bench.get("clutch")["button"], nullptr);
  EXPECT_EQ(bench.get("clutch")["off"], false);
}

TEST(DeviceClutch, WhatSaysNothingOrIsAnothersIsRefused) {
  ClutchBench bench;
  for (const char* value : {"", "hold", "33", "-1", "1.5", "nan", "1,2", "HELD"}) {
    const Error refused = bench.tree.set(bench.path + "/clutch?value=" + value, kSomebody).error();
    EXPECT_EQ(refused.code, ErrorCode::kInvalidArgument) << value;
    EXPECT_EQ(refused.where, bench.path + "/clutch") << value;
    EXPECT_FALSE(refused.remedy.empty()) << value;
  }
  ASSERT_TRUE(bench.core.acquireLease(bench.live()->id).ok());
  EXPECT_EQ(bench.tree.set(bench.path + "/clutch?value=held", Client{.uid = 1001}).error().code, ErrorCode::kLeaseHeld);
  EXPECT_EQ(bench.get("clutch")["held"], false);
}

/** Whoever arms next is not left to wonder; and no force comes back while the last one's is lowered. */
TEST(DeviceClutch, EndsWithTheLeaseAndNoForceWithIt) {
  ClutchBench bench;
  Session* session = bench.live();
  ASSERT_TRUE(bench.arm(session->id).ok());
  bench.step(40);
  ASSERT_EQ(bench.client->push({1, 0, 0}), ErrorCode::kOk);
  bench.step(100);
  ASSERT_GT(bench.sample().force[0], 0.9);
  bench.clutch("held");
  bench.step(60);
  ASSERT_EQ(bench.sample().force[0], 0);
  ASSERT_TRUE(bench.core.releaseLease(session->id).ok());
  for (int i = 0; i < 300; ++i) {
    bench.step();
    ASSERT_EQ(bench.sample().force[0], 0);
  }
  EXPECT_EQ(bench.get("clutch")["held"], false);
  EXPECT_EQ(bench.get("clutch")["off"], false);
}

}  // namespace
}  // namespace hapticd::test
