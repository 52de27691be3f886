// The ball about a device's point, set by name and felt by the servo.
#include "daemon/resource/resource_tree.h"
#include "tests/session/bench.h"

namespace hapticd::test {
namespace {

TEST(DeviceRadius, IsWrittenReadAndReachesTheServo) {
  Bench bench;
  ResourceTree tree(bench.core);
  OpenDevice& device = *bench.core.devices().devices().front();
  const std::string path = "/devices/" + device.name + "/radius";
  const Client anybody{.uid = 1000};
  EXPECT_EQ(*tree.get(path, anybody), "0.0");
  const auto set = tree.set(path + "?value=0.002", anybody);
  ASSERT_TRUE(set.ok()) << toString(set.error());
  EXPECT_EQ(*set, "0.002");
  bench.step(3);
  double radius = 0;
  ASSERT_TRUE(device.link->group().betweenCycles([&](Servo& servo) { radius = servo.cycle().deviceRadius(0); }).ok());
  EXPECT_EQ(radius, 0.002);
}

TEST(DeviceRadius, OfTheConfigurationIsThereFromTheFirstCycleAndCanBeSet) {
  Config config = Bench::relaxed();
  config.devices.emplace_back();
  config.devices.back().uri = "test://first";
  config.devices.back().radius_m = 0.003;
  Bench bench(config, 2);
  const auto felt = [&](std::uint32_t d) {
    double radius = -1;
    const auto read = [&](Servo& servo) { radius = servo.cycle().deviceRadius(d); };
    EXPECT_TRUE(bench.device(d).link->group().betweenCycles(read).ok());
    return radius;
  };
  EXPECT_EQ(felt(0), 0.003);
  EXPECT_EQ(felt(1), 0) << "another device";
  ResourceTree tree(bench.core);
  const std::string path = "/devices/" + bench.device().name + "/radius";
  EXPECT_EQ(*tree.get(path, Client{.uid = 1000}), "0.003");
  ASSERT_TRUE(tree.set(path + "?value=0", Client{.uid = 1000}).ok());
  bench.step(3);
  EXPECT_EQ(felt(0), 0);
}

TEST(DeviceRadius, OutOfRangeOrAnothersLeaseIsRefusedAndChangesNothing) {
  Bench bench;
  ResourceTree tree(bench.core);
  OpenDevice& device = *bench.core.devices().devices().front();
  const std::string path = "/devices/" + device.name + "/radius";
  for (const char* value : {"-0.001", "0.2", "nan", "wide", "0.001,0"}) {
    const Error refused = tree.set(path + "?value=" + value, Client{.uid = 1000}).error();
    EXPECT_EQ(refused.code, ErrorCode::kInvalidArgument) << value;
    EXPECT_EQ(refused.where, path) << value;
  }
  ASSERT_TRUE(bench.core.acquireLease(bench.live()->id).ok());
  EXPECT_EQ(tree.set(path + "?value=0.001", Client{.uid = 1001}).error().code, ErrorCode::kLeaseHeld);
  EXPECT_EQ(tree.set("/devices/" + device.name + "/force?value=1", Client{.uid = 1000}).error().code,
            ErrorCode::kPermissionDenied);
  const Error nobody = tree.set("/devices/nope/radius?value=0", Client{.uid = 1000}).error();
  EXPECT_EQ(nobody.where, "/devices/nope");
  EXPECT_NE(nobody.remedy.find(device.name), std::string::npos) << nobody.remedy;
  EXPECT_EQ(tree.set("/world/gravity?value=0,0,-1e9", Client{.uid = 1000}).error().where, "/world/gravity");
  EXPECT_EQ(tree.set("/devices/" + device.name + "/tool?value=nope", Client{.uid = 1000}).error().where,
            "/devices/" + device.name + "/tool (name)");
  EXPECT_EQ(device.radius, 0);
  EXPECT_TRUE(tree.set(path + "?value=0.001", Client{.uid = 1000}).ok());
  EXPECT_TRUE(tree.set(path + "?value=0.003", Client{.uid = 0, .administration = true}).ok());
  EXPECT_EQ(device.radius, 0.003);
}

}  // namespace
}  // namespace hapticd::test
