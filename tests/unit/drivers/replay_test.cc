#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "drivers/replay/replay_device.h"
#include "drivers/sim/sim_device.h"
#include "tests/support/process/temporary_directory.h"
#include "tests/support/stepped/stepped_device.h"

namespace hapticd {
namespace {

using test::SteppedDevice;
using ::testing::HasSubstr;

class Replay : public ::testing::Test {
 protected:
  std::string write(std::string_view text) {
    const std::string path = directory_.path() + "/motion one.csv";
    std::ofstream(path) << text;
    return path;
  }
  test::TemporaryDirectory directory_;
};

TEST_F(Replay, PlaysWhatASimulatorRecorded) {
  std::string text = "tick,t_ns,device,px,py,pz,fx,fy,fz\n";
  SteppedDevice simulated("sim://default?motion=lissajous");
  std::vector<Vec3> positions;
  for (int i = 0; i < 500; ++i) {
    const DeviceSample& sample = simulated.run(1);
    positions.push_back(sample.p);
    text += fmt::format("{},{},0,{},{},{},0,0,0\n", i, sample.t_ns, sample.p.x(), sample.p.y(), sample.p.z());
  }
  SteppedDevice replayed("replay://" + write(text));
  const auto push = [](const DeviceSample&) { return Vec3(5, 5, 5); };
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const DeviceSample& sample = replayed.step(push);
    EXPECT_TRUE(sample.fresh);
    EXPECT_LT((sample.p - positions[i]).norm(), 1e-12) << i;
  }
  replayed.run(100, push);
  EXPECT_LT((replayed.sample().p - positions.back()).norm(), 1e-12) << "the end is held";
  const DeviceInfo& info = replayed.device().info();
  EXPECT_EQ(info.model, "replay");
  EXPECT_NEAR(info.native_rate_hz, 1000, 1e-6);
  EXPECT_FALSE(info.sensed_rotation);
  EXPECT_GT(info.max_force, 0) << "so that contact and guard have a limit to work with";
  EXPECT_NEAR(info.workspace_upper.x(), 0.02, 3e-3);
}

TEST_F(Replay, SpeedLoopAndWait) {
  const std::string path = write("0,0,0,0\n1,0.1,0,0\n");
  SteppedDevice twice("replay://" + path + "?speed=2&loop=1");
  twice.run(251);
  EXPECT_NEAR(twice.sample().p.x(), 0.05, 1e-9);
  twice.run(500);
  EXPECT_NEAR(twice.sample().p.x(), 0.05, 1e-9);
  SteppedDevice waiting("replay://" + path + "?wait=0.5");
  waiting.run(501);
  EXPECT_EQ(waiting.sample().p.x(), 0);
  waiting.run(100);
  EXPECT_NEAR(waiting.sample().p.x(), 0.01, 1e-9);
}

TEST_F(Replay, CanonicalUriOpensItAgain) {
  const std::string path = write("0,0,0,0\n1,0.1,0,0\n");
  SteppedDevice a("replay://" + path + "?loop=yes&speed=1.0");
  EXPECT_THAT(a.device().info().uri, HasSubstr("motion%20one.csv?loop=1"));
  SteppedDevice b(a.device().info().uri);
  EXPECT_EQ(a.device().info().serial, b.device().info().serial);
}

TEST_F(Replay, FaultsSayWhatAndWhere) {
  const std::string path = write("0,0,0,0\n1,0.1,x,0\n");
  for (const std::string& uri : {"replay://" + path, fmt::format("sim://touch?motion=csv&file={}", path)}) {
    const auto device = makeDevice(uri);
    ASSERT_TRUE(device.ok()) << "whoever makes it has no time to read: " << toString(device.error());
    EXPECT_THAT(toString((*device)->open().error()), HasSubstr("line 2, column 3"));
  }
  EXPECT_THAT(toString(makeDevice("replay://").error()), HasSubstr("names no file"));
  EXPECT_EQ(makeDevice("replay:///no/such/file.csv").error().code, ErrorCode::kNotFound);
  EXPECT_THAT(toString(makeDevice("replay://" + path + "?sped=2").error()), HasSubstr("did you mean \"speed\"?"));
}

TEST_F(Replay, WhatNobodyWaitsForIsReadNoFurther) {
  const std::string path = write("0,0,0,0\n1,0.1,x,0\n");
  for (const std::string& uri : {"replay://" + path, fmt::format("sim://touch?motion=csv&file={}", path)}) {
    const auto device = std::move(*makeDevice(uri));
    dynamic_cast<SlowToOpen&>(*device).giveUp();
    EXPECT_EQ(device->open().error().code, ErrorCode::kCancelled) << "not its second line's fault";
  }
}

/** The rows are large: they go with close(), where there is time for it, and come again. */
TEST_F(Replay, RowsAreThereWhileItIsOpen) {
  const std::string path = write("0,0.01,0,0\n1,0.02,0,0\n");
  for (const std::string& uri : {"replay://" + path, fmt::format("sim://touch?motion=csv&file={}", path)}) {
    auto device = std::move(*makeDevice(uri));
    std::int64_t now_ns = 1'000'000'000;
    DeviceSample sample;
    for (int i = 0; i < 2; ++i) {
      ASSERT_TRUE(device->open().ok());
      device->read(now_ns += 1'000'000, sample);
      EXPECT_NEAR(sample.p.x(), 0.01, 1e-4) << uri;
      device->close();
    }
  }
  for (const std::string& uri : {"replay://" + path, fmt::format("sim://touch?motion=csv&file={}", path)}) {
    auto device = std::move(*makeDevice(uri));
    const auto& holds = dynamic_cast<const HoldsMemory&>(*device);
    EXPECT_EQ(holds.heldBytes(), 0u);
    ASSERT_TRUE(device->open().ok());
    EXPECT_EQ(holds.heldBytes(), 2 * sizeof(PoseRow)) << uri;
    device->close();
    EXPECT_EQ(holds.heldBytes(), 0u) << uri;
  }
  ReplayDevice played(*resolveReplay(*parseDeviceUri("replay://" + path)));
  DeviceSample sample;
  played.read(1, sample);
  EXPECT_FALSE(sample.fresh);
  ASSERT_TRUE(played.open().ok());
  played.read(2, sample);
  EXPECT_TRUE(sample.fresh);
  played.close();
  played.read(3, sample);
  EXPECT_FALSE(sample.fresh) << "they have gone";
}

TEST_F(Replay, TheHandOfASimulatorFollowsAFileAndPressesItsButtons) {
  const std::string path = write("t,x,y,z,buttons\n0,0,0,0,0\n0.5,0,0.02,0,3\n1,0,0.02,0,0\n");
  SteppedDevice s(fmt::format("sim://touch?motion=csv&file={}&coulomb=0", path));
  EXPECT_EQ(s.run(100).buttons, 0u);
  EXPECT_EQ(s.run(500).buttons, 3u);
  EXPECT_EQ(s.run(600).buttons, 0u);
  s.run(1000);
  EXPECT_LT((s.sample().p - Vec3(0, 0.02, 0)).norm(), 1e-4);
}

}  // namespace
}  // namespace hapticd
