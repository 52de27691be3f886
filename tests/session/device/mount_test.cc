// Where a device stands: of the configuration, by name, and never while a force could jump with it.
#include "daemon/device/mount.h"

#include <nlohmann/json.hpp>

#include "daemon/resource/resource_tree.h"
#include "drivers/registry.h"
#include "tests/session/bench.h"
#include "tests/support/random.h"

namespace hapticd::test {
namespace {

const Client kAnybody{.uid = 1000};

Mount felt(OpenDevice& device) {
  Mount mount;
  const auto read = [&](Servo& servo) { mount = servo.cycle().mount(device.index); };
  EXPECT_TRUE(device.link->group().betweenCycles(read).ok());
  return mount;
}

AttachTool orderOf(OpenDevice& device) {
  AttachTool order{};
  const auto read = [&](Servo& servo) { order = servo.cycle().tool(device.index).order(); };
  EXPECT_TRUE(device.link->group().betweenCycles(read).ok());
  return order;
}

TEST(DeviceMount, IsWrittenReadAndReachesTheServo) {
  Bench bench;
  ResourceTree tree(bench.core);
  OpenDevice& device = bench.device();
  const std::string path = "/devices/" + device.name + "/mount";
  const auto at = [&](const char* value) {
    const auto set = tree.set(path + "?value=" + value, kAnybody);
    EXPECT_TRUE(set.ok()) << toString(set.error());
    bench.step(3);
    return nlohmann::json::parse(*tree.get(path, kAnybody));
  };
  EXPECT_EQ(*tree.get(path, kAnybody), R"({"deg":[0.0,0.0,0.0],"pos":[0.0,0.0,0.0],"rot":[1.0,0.0,0.0,0.0]})");
  EXPECT_EQ(at("0.3,0,-0.1")["pos"], (nlohmann::json{0.3, 0, -0.1}));
  EXPECT_EQ(felt(device).pose().p, Vec3(0.3, 0, -0.1));
  const auto turned = at("0,0.2,0,0,0,90");
  EXPECT_EQ(turned["deg"], (nlohmann::json{0.0, 0.0, 90.0})) << "as it was said";
  EXPECT_LT((felt(device).toWorld(Vec3(1, 0, 0)) - Vec3(0, 1, 0)).norm(), 1e-15) << "its x is the world's y";
  for (const char* const turns : {"0,0,15", "10,20,30", "-0.1,0,179.9", "33.3,-89,0"}) {
    const auto said = nlohmann::json::parse("[" + std::string(turns) + "]").get<std::vector<double>>();
    EXPECT_EQ(at(("0,0,0," + std::string(turns)).c_str())["deg"].dump(), nlohmann::json(said).dump());
  }
  const auto side = at("0,0,0,2,2,0,0");
  EXPECT_NEAR(side["deg"][0].get<double>(), 90, 1e-9) << "a quaternion of any length is a turn";
  EXPECT_NEAR(felt(device).pose().q.norm(), 1, 1e-15);
  at("");
  EXPECT_TRUE(felt(device).identity());
}

TEST(DeviceMount, TheHandIsToldInTheWorld) {
  Bench bench;
  ResourceTree tree(bench.core);
  const std::string path = "/devices/" + bench.device().name;
  bench.scripted[0]->sample.p = {0.01, 0.02, 0.03};
  ASSERT_TRUE(tree.set(path + "/mount?value=1,0,0,0,0,90", kAnybody).ok());
  bench.step(3);
  const auto pos = nlohmann::json::parse(*tree.get(path + "/pos", kAnybody));
  EXPECT_NEAR(pos[0].get<double>(), 0.98, 1e-12);
  EXPECT_NEAR(pos[1].get<double>(), 0.01, 1e-12);
  EXPECT_NEAR(pos[2].get<double>(), 0.03, 1e-12);
}

TEST(DeviceScale, IsWrittenReadAndReachesTheServo) {
  Bench bench;
  ResourceTree tree(bench.core);
  OpenDevice& device = bench.device();
  const std::string path = "/devices/" + device.name;
  const auto at = [&](const char* value) {
    const auto set = tree.set(path + "/scale?value=" + value, kAnybody);
    EXPECT_TRUE(set.ok()) << toString(set.error());
    bench.step(3);
    return nlohmann::json::parse(*tree.get(path + "/scale", kAnybody));
  };
  ASSERT_TRUE(tree.set(path + "/mount?value=1,0,0,0,0,90", kAnybody).ok());
  bench.scripted[0]->sample.p = {0.01, 0.02, 0.03};
  EXPECT_EQ(at("4")["scale"], 4);
  EXPECT_EQ(felt(device).scale(), 4);
  EXPECT_EQ(felt(device).pose().p, Vec3(1, 0, 0)) << "it stands where it stood";
  const auto pos = nlohmann::json::parse(*tree.get(path + "/pos", kAnybody));
  EXPECT_NEAR(pos[0].get<double>(), 0.92, 1e-12);
  EXPECT_NEAR(pos[2].get<double>(), 0.12, 1e-12);
  ASSERT_TRUE(tree.set(path + "/mount?value=0,0,0", kAnybody).ok());
  bench.step(3);
  EXPECT_EQ(felt(device).scale(), 4) << "and is as large elsewhere";
  const double radius = device.info().workspace_radius;
  if (radius > 0) {
    const auto fitted = at("0.5m");
    EXPECT_NEAR(fitted["workspace_radius"].get<double>(), 0.5, 1e-12);
    EXPECT_NEAR(felt(device).scale(), 0.5 / radius, 1e-12);
  } else {
    EXPECT_EQ(tree.set(path + "/scale?value=0.5m", kAnybody).error().code, ErrorCode::kUnsupported);
    const Error none = tree.set(path + "/scale?value=50mm", kAnybody).error();
    EXPECT_EQ(none.what, "'50mm' is no scale") << "named as it was written";
    EXPECT_NE(none.remedy.find("0.5m"), std::string::npos) << none.remedy;
    const Error typo = tree.set("/device/sim/scale?value=5", kAnybody).error();
    EXPECT_EQ(toString(typo).substr(0, 32), "/device: there is no 'device' in");
    EXPECT_NE(typo.remedy.find("devices"), std::string::npos) << typo.remedy;
  }
  at("");
  EXPECT_TRUE(felt(device).identity());
}

TEST(DeviceScale, WhatIsNoneOrAnArmedDeviceIsRefusedAndChangesNothing) {
  Bench bench;
  ResourceTree tree(bench.core);
  OpenDevice& device = bench.device();
  const std::string path = "/devices/" + device.name + "/scale";
  ASSERT_TRUE(tree.set(path + "?value=2", kAnybody).ok());
  for (const char* value : {"0", "-1", "0.009", "101", "nan", "1,1", "two", "m", "2mm", "m2"}) {
    const Error refused = tree.set(path + "?value=" + value, kAnybody).error();
    EXPECT_EQ(refused.code, ErrorCode::kInvalidArgument) << value;
    EXPECT_EQ(refused.where, path) << value;
    EXPECT_FALSE(refused.remedy.empty()) << value;
  }
  Session* session = bench.live();
  bench.core.arm(session->id, [](Result<void>) {});
  EXPECT_EQ(tree.set(path + "?value=3", kAnybody).error().code, ErrorCode::kWouldBlock);
  bench.step(3);
  EXPECT_EQ(device.mount.scale(), 2);
  EXPECT_EQ(felt(device).scale(), 2);
}

/** The device bears a coupling of so many newtons a metre of the hand, whatever that is in the world. */
TEST(DeviceScale, AToolIsHeldAnewAsStiffAsTheDeviceBears) {
  Bench bench;
  ResourceTree tree(bench.core);
  OpenDevice& device = bench.device();
  const std::string path = "/devices/" + device.name;
  ObjectSpec stick;
  stick.name = "stick";
  stick.shape.kind = ShapeKind::kSphere;
  stick.shape.size[0] = 0.01;
  ASSERT_TRUE(bench.core.scene().create(stick, bench.core.client(bench.connection)).ok());
  ASSERT_TRUE(tree.set(path + "/tool?value=stick,0.1", kAnybody).ok());
  bench.step(3);
  const AttachTool before = orderOf(device);
  ASSERT_TRUE(tree.set(path + "/scale?value=4", kAnybody).ok());
  bench.step(3);
  const AttachTool after = orderOf(device);
  EXPECT_NEAR(after.outer, before.outer / 4, 1e-9);
  EXPECT_NEAR(after.stiffness, before.stiffness / 4, 1e-9);
  EXPECT_NEAR(after.angular_outer, before.angular_outer * 4, 1e-9);
  EXPECT_EQ(after.mass, before.mass);
  EXPECT_NEAR(after.damping, before.damping / 2, 1e-9)
      << "a mass that is felt four times: sqrt(k m) is twice, then / 4";
}

TEST(DeviceMount, OfTheConfigurationIsThereFromTheFirstCycle) {
  Config config = Bench::relaxed();
  config.devices.emplace_back();
  config.devices.back().uri = "test://first";
  config.devices.back().mount_m = {0.1, 0.2, 0.3};
  config.devices.back().mount_deg = {0, 0, 180};
  config.devices.back().scale = 3;
  Bench bench(config, 2);
  EXPECT_EQ(felt(bench.device(0)).pose().p, Vec3(0.1, 0.2, 0.3));
  EXPECT_LT((felt(bench.device(0)).toWorld(Vec3(1, 0, 0)) + Vec3(1, 0, 0)).norm(), 1e-15);
  EXPECT_EQ(felt(bench.device(0)).scale(), 3);
  EXPECT_TRUE(felt(bench.device(1)).identity()) << "another device";
}

/** As a program that disarms, moves the device in the world, and arms again. */
TEST(DeviceScale, MayWaitForADeviceThatIsBeingDisarmed) {
  Bench bench;
  OpenDevice& device = bench.device();
  Session* session = bench.live();
  ASSERT_TRUE(bench.arm(session->id).ok());
  std::vector<ErrorCode> heard;
  const auto ask = [&] {
    bench.core.onceLowered(
        bench.connection,
        [&]() -> Result<void> {
          const auto set = ResourceTree(bench.core).set("/devices/" + device.name + "/scale?value=2", kAnybody);
          return set ? Result<void>() : set.error();
        },
        [&](const Result<void>& done) { heard.push_back(done ? ErrorCode::kOk : done.error().code); });
  };
  ask();
  EXPECT_EQ(heard, std::vector{ErrorCode::kWouldBlock}) << "nobody has disarmed it";
  ASSERT_TRUE(bench.core.disarm(session->id).ok());
  ask();
  EXPECT_EQ(heard.size(), 1u);
  bench.step(5);
  ASSERT_EQ(heard.size(), 2u);
  EXPECT_EQ(heard.back(), ErrorCode::kOk);
  EXPECT_EQ(felt(device).scale(), 2);
}

TEST(DeviceMount, IsRefusedFromTheArmOrderToTheLastForceOfADisarmedDevice) {
  Bench bench;
  ResourceTree tree(bench.core);
  OpenDevice& device = bench.device();
  const std::string set = "/devices/" + device.name + "/mount?value=0,0,0.1";
  Session* session = bench.live();
  bench.core.arm(session->id, [](Result<void>) {});
  const Error refused = tree.set(set, kAnybody).error();
  EXPECT_EQ(refused.code, ErrorCode::kWouldBlock) << "it is on its way to be armed";
  EXPECT_EQ(refused.where, "/devices/" + device.name + "/mount");
  EXPECT_NE(refused.remedy.find("disarm"), std::string::npos);
  GuardLimits slow = device.limits;
  slow.force_slew = 10;
  ASSERT_TRUE(bench.core.setLimits("", slow, bench.administration).ok());
  bench.step(40);
  ASSERT_EQ(bench.client->push({1, 0, 0}), ErrorCode::kOk);
  bench.step(400);
  ASSERT_GT(bench.sample().force[0], 0.9);
  ASSERT_TRUE(bench.core.disarm(session->id).ok());
  int refusals = 0;
  while (!tree.set(set, kAnybody).ok()) {
    ASSERT_TRUE(felt(device).identity());
    bench.step();
    ASSERT_LT(++refusals, 500);
  }
  EXPECT_GT(refusals, 50) << "a newton goes at 10 N/s";
  EXPECT_EQ(bench.sample().force[0], 0);
  bench.step(3);
  EXPECT_EQ(felt(device).pose().p, Vec3(0, 0, 0.1));
  EXPECT_TRUE(bench.arm(session->id).ok());
}

TEST(DeviceMount, WhatIsNoPlaceOrAnothersLeaseIsRefusedAndChangesNothing) {
  Bench bench;
  ResourceTree tree(bench.core);
  OpenDevice& device = bench.device();
  const std::string path = "/devices/" + device.name + "/mount";
  ASSERT_TRUE(tree.set(path + "?value=0.1,0,0", kAnybody).ok());
  for (const char* value : {"1", "1,2", "1,2,3,4", "1,2,3,4,5", "1,2,3,4,5,6,7,8", "a,b,c", "nan,0,0", "101,0,0",
                            "0,0,0,0,0,361", "0,0,0,0,0,0,0", "0,0,,0,0,0", ",,"}) {
    const Error refused = tree.set(path + "?value=" + value, kAnybody).error();
    EXPECT_EQ(refused.code, ErrorCode::kInvalidArgument) << value;
    EXPECT_EQ(refused.where, path) << value;
    EXPECT_FALSE(refused.remedy.empty()) << value;
  }
  ASSERT_TRUE(bench.core.acquireLease(bench.live()->id).ok());
  EXPECT_EQ(tree.set(path + "?value=0,0,0", Client{.uid = 1001}).error().code, ErrorCode::kLeaseHeld);
  EXPECT_EQ(device.mount.pose().p, Vec3(0.1, 0, 0));
  EXPECT_EQ(felt(device).pose().p, Vec3(0.1, 0, 0));
}

TEST(MountDegrees, SayTheTurnTheyWereMadeOf) {
  Random random(3);
  for (int i = 0; i < 5000; ++i) {
    const Vec3 given(random.in(-180, 180), random.once(20) ? (random.once(2) ? 90 : -90) : random.in(-90, 90),
                     random.in(-180, 180));
    const Quat q = fromDegrees(given), again = fromDegrees(toDegrees(q));
    ASSERT_LT(q.angularDistance(again), 1e-7) << given.transpose();
    if (std::abs(given.y()) < 89) {
      ASSERT_LT((toDegrees(q) - given).norm(), 1e-9);
    }
  }
  for (int said = -180; said <= 180; ++said) ASSERT_EQ(toDegrees(fromDegrees({0, 0, 1.0 * said})).z(), said);
  const Quat q = fromDegrees({90, 0, 90});  // First about the world's x, then about its z.
  EXPECT_LT((q * Vec3(0, 1, 0) - Vec3(0, 0, 1)).norm(), 1e-15);
  EXPECT_LT((q * Vec3(1, 0, 0) - Vec3(0, 1, 0)).norm(), 1e-15);
}

/** Two that are simulated, 40 cm apart and facing each other, and a ball between them. */
TEST(DeviceMount, TwoDevicesMeetOneBallEachFromItsSide) {
  constexpr std::uint32_t kBetween = makeObjectId(1, 1), kSlot = 2;
  ManualClock clock;
  MeshTable meshes;
  CycleConfig config;
  config.device_count = 2;
  for (GuardConfig& guard : config.guard) {
    guard.limits = {10, 1, 1e6, 1e3, 5, 10, 50, 50};
    guard.ramp_ns = 1'000'000;
  }
  const auto left = makeDevice("sim://default?seed=1"), right = makeDevice("sim://default?seed=2");
  ASSERT_TRUE(left.ok() && right.ok());
  ASSERT_TRUE((*left)->open().ok() && (*right)->open().ok());
  Servo servo(config, std::array<Device*, kMaxDevices>{left->get(), right->get()}, meshes, clock);
  const auto region = std::make_unique<hd_region_a>();
  servo.ports[kSlot].region.store(region.get());
  const auto send = [&](CommandKind kind, const auto& payload, std::uint32_t from = kControlSession) {
    ASSERT_TRUE(servo.from_control.push(makeCommand(kind, payload, from)));
  };
  const auto run = [&](int ticks) {
    for (int i = 0; i < ticks; ++i) servo.runOnce();
  };
  servo.begin();
  send(CommandKind::kAddSession, SessionRef{kSlot, 0, 9});
  AddObject ball{};
  ball.object = kBetween;
  ball.flags = HD_OBJECT_ENABLED;
  ball.shape.kind = static_cast<std::uint32_t>(ShapeKind::kSphere);
  ball.shape.size[0] = 0.18;
  ball.material = {300, 0, 0, 0};
  ball.q[0] = 1;
  send(CommandKind::kAddObject, ball);
  // Each operator sits at the outer end: the left one's x, toward whom it is, is the world's -y, the right one's +y.
  for (std::uint32_t d = 0; d < 2; ++d) {
    const double side = d == 0 ? -1 : 1;
    send(CommandKind::kSetMount, Mount(Pose{{0, side * 0.2, 0}, fromDegrees({0, 0, side * 90})}).order(d));
  }
  run(200);
  for (std::uint32_t d = 0; d < 2; ++d) send(CommandKind::kArm, DeviceRef{d});
  run(20);
  // Where the hands want to be is told in the world: 1 cm into the ball.
  for (std::uint32_t d = 0; d < 2; ++d) {
    hd_intent wish{};
    wish.device = d;
    wish.p[1] = d == 0 ? -0.17 : 0.17;
    wish.q[0] = 1;
    send(CommandKind::kIntent, wish, kSlot);
  }
  run(3000);
  for (std::uint32_t d = 0; d < 2; ++d) {
    const double side = d == 0 ? -1 : 1;
    hd_sample sample{};
    ASSERT_TRUE(StateReader(region.get()).latest(d, sample));
    EXPECT_EQ(sample.contact_object, kBetween) << d;
    EXPECT_LT(side * sample.p[1], 0.18) << "in the ball, where the ball is";
    EXPECT_GT(side * sample.p[1], 0.165);
    EXPECT_NEAR(side * sample.proxy[1], 0.18, 1e-5);
    EXPECT_GT(side * sample.force[1], 0.5) << "outwards, in the world";
    EXPECT_NEAR(sample.by_source[HD_SOURCE_SURFACE][1], sample.force[1], 1e-4);
    const DeviceOutput& out = servo.lastOutput().device[d];
    EXPECT_NEAR(out.command.force.x(), side * sample.force[1], 1e-12) << "toward its operator";
    EXPECT_LT(servo.lastInput().device[d].p.x(), -0.015) << "encoders are the device's";
  }
}

}  // namespace
}  // namespace hapticd::test
