// Contract 1 on the whole servo: ingest, cycle, devices and publication run under the detectors while the scene, the
// clients and the safety state change around them.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <thread>

#include "drivers/registry.h"
#include "rt/cycle/realtime.h"
#include "rt/cycle/servo.h"
#include "support/detectors.h"

namespace hapticd {
namespace {

constexpr std::int64_t kPeriodNs = 1'000'000;
constexpr int kCycles = 10'000;
constexpr int kWarmUp = 100;

/** Two zeroed regions whose pages are there. */
struct Regions {
  Regions() : a(std::make_unique<hd_region_a>()), b(std::make_unique<hd_region_b>()) {
    initialiseRegions(a.get(), b.get(), {.epoch = 1, .session = 1, .device_count = 1, .period_ns = kPeriodNs});
  }
  std::unique_ptr<hd_region_a> a;
  std::unique_ptr<hd_region_b> b;
};

/** A servo with a simulated device and one client, stepped by hand. */
class House {
 public:
  explicit House(const std::string& uri) {
    auto made = makeDevice(uri);
    EXPECT_TRUE(made.ok()) << toString(made.error());
    device_ = std::move(*made);
    EXPECT_TRUE(device_->open().ok());
    CycleConfig config;
    config.guard[0].limits = {.force = 8,
                              .torque = 1,
                              .force_slew = 1e4,
                              .torque_slew = 1e3,
                              .gripper_force = 1,
                              .velocity = 5,
                              .power = 50,
                              .active_power = 20};
    config.guard[0].ramp_ns = 10 * kPeriodNs;
    servo = std::make_unique<Servo>(config, std::array<Device*, kMaxDevices>{device_.get()}, meshes, clock);
    ingest = std::make_unique<Ingest>(IngestConfig{});
    servo->ingest = ingest.get();
    servo->begin();
    attach(0);
    client = std::make_unique<CommandProducer>(region[0].b.get(), region[0].a.get());
    addObjects();
    order(CommandKind::kArm, DeviceRef{0});
  }

  template <class T>
  void order(CommandKind kind, const T& payload) {
    Command command;
    command.kind = kind;
    command.as<T>() = payload;
    EXPECT_TRUE(servo->from_control.push(command));
  }

  /** What control does when a client connects. */
  void attach(std::uint32_t slot) {
    servo->ports[slot].region.store(region[slot].a.get(), std::memory_order_release);
    order(CommandKind::kAddSession, SessionRef{slot, 0, slot + 1});
    EXPECT_TRUE(ingest->orders.push(
        {IngestOrder::Kind::kAttach, slot, {slot + 1, region[slot].b.get(), region[slot].a.get(), 1}}));
  }
  void detach(std::uint32_t slot) {
    order(CommandKind::kLoseSession, SessionRef{slot, 0, slot + 1});
    EXPECT_TRUE(ingest->orders.push({IngestOrder::Kind::kDetach, slot, {}}));
  }

  template <class T>
  void push(std::uint32_t kind, const T& payload) {
    std::uint64_t seq = 0;
    client->push(kind, std::as_bytes(std::span(&payload, 1)), 0, seq);
  }

  void step() noexcept {
    client->heartbeat(clock.now());
    ingest->step(clock.now(), servo->counters.tick.load(std::memory_order_relaxed));
    servo->runOnce();
    ServoEvent event;
    while (servo->events.pop(event)) {
    }
    IngestReport report;
    while (ingest->reports.pop(report)) {
    }
  }

  ManualClock clock;
  MeshTable meshes;
  std::array<Regions, 2> region;
  std::unique_ptr<Servo> servo;
  std::unique_ptr<Ingest> ingest;
  std::unique_ptr<CommandProducer> client;

 private:
  void addObjects() {
    AddObject object{};
    object.flags = HD_OBJECT_ENABLED;
    object.material = {800, 2, 0.6, 0.4};
    object.q[0] = 1;
    const ShapeKind kinds[] = {ShapeKind::kPlane, ShapeKind::kSphere, ShapeKind::kBox, ShapeKind::kCapsule,
                               ShapeKind::kCylinder};
    for (std::uint32_t i = 0; i < 5; ++i) {
      object.object = makeObjectId(i + 1, 1);
      object.shape.kind = static_cast<std::uint32_t>(kinds[i]);
      for (double& size : object.shape.size) size = 0.02;
      object.p[0] = i == 0 ? 0 : 0.03 * i - 0.08;
      order(CommandKind::kAddObject, object);
    }
  }
  std::unique_ptr<Device> device_;
};

/** Runs `change` every 100 cycles outside the scope, the cycles inside it. */
void expectClean(const std::function<void(House&, int)>& change,
                 const std::string& uri = "sim://default?motion=circle") {
  House house(uri);
  test::RtViolations seen;
  bool trapped = false;
  std::thread([&] {
    disableDenormals();
    prefaultStack(128 * 1024);
    // Both passes run the same code; the first brings in pages and lazily bound symbols.
    for (int i = 0; i < kWarmUp; ++i) {
      change(house, i);
      house.step();
    }
    trapped = test::trapSystemCalls();
    for (int i = 0; i < kCycles && seen == test::RtViolations{}; i += 100) {
      change(house, kWarmUp + i);
      test::RtScope scope;
      for (int k = 0; k < 100; ++k) house.step();
      seen = scope.finish();
    }
  }).join();
  EXPECT_TRUE(trapped);
  EXPECT_EQ(seen, test::RtViolations{});
  EXPECT_GE(house.servo->counters.cycles.load(), static_cast<std::uint64_t>(kCycles));
}

TEST(ServoCycle, IsCleanAtRest) {
  expectClean([](House&, int) {});
}

TEST(ServoCycle, IsCleanInContact) {
  double most = 0;
  expectClean(
      [&most](House& house, int) { most = std::max(most, house.servo->lastOutput().device[0].command.force.norm()); },
      "sim://default?motion=tap&centre=0,0,0.005&direction=0,0,-1&depth=0.015&period=0.5&hand_stiffness=400");
  EXPECT_GT(most, 0.5) << "the test must press on something";
}

TEST(ServoCycle, IsCleanWhileObjectsMove) {
  expectClean([](House& house, int i) {
    hd_object_pose pose{};
    pose.object = makeObjectId(2, 1);
    pose.p[2] = 0.001 * (i % 7);
    pose.q[0] = 1;
    pose.w[2] = 1;
    house.push(HD_COMMAND_OBJECT_POSE, pose);
  });
}

TEST(ServoCycle, IsCleanWhileObjectsComeAndGo) {
  expectClean([](House& house, int i) {
    AddObject object{};
    object.object = makeObjectId(9, static_cast<std::uint32_t>(i / 2) + 1);
    object.flags = HD_OBJECT_ENABLED;
    object.shape.kind = static_cast<std::uint32_t>(ShapeKind::kSphere);
    object.shape.size[0] = 0.03;
    object.material = {500, 0, 0, 0};
    object.q[0] = 1;
    house.order(CommandKind::kAddObject, object);
    house.order(CommandKind::kRemoveObject, ObjectRef{object.object});
  });
}

TEST(ServoCycle, IsCleanWithLocalModels) {
  expectClean([](House& house, int i) {
    hd_local_model model{};
    model.slot = static_cast<std::uint32_t>(i) % HD_MODEL_SLOTS;
    model.kind = 1 + static_cast<std::uint32_t>(i / 100) % 4;
    model.lease_ns = 50'000'000;
    model.blend_ns = 10'000'000;
    model.material = {500, 1, 0.5, 0.3};
    model.normal[2] = 1;
    model.radius = 0.02;
    model.count = 16;
    for (auto& halfspace : model.halfspace) halfspace[2] = 1;
    house.push(HD_COMMAND_LOCAL_MODEL, model);
    hd_client_force force{};
    force.lease_ns = 20'000'000;
    force.force[0] = 0.5;
    house.push(HD_COMMAND_CLIENT_FORCE, force);
  });
}

TEST(ServoCycle, IsCleanWhileClientsAreBornAndDie) {
  expectClean([](House& house, int i) {
    switch ((i / 100) % 3) {
      case 0:
        house.attach(1);
        break;
      case 1:
        house.detach(1);
        break;
      default:
        house.order(CommandKind::kFreeSession, SessionRef{1, 0, 2});
        break;
    }
  });
}

TEST(ServoCycle, IsCleanThroughFaultAndRearm) {
  expectClean([](House& house, int i) {
    const bool stop = (i / 100) % 2 == 0;
    house.servo->stop_line.store(stop);
    if (!stop) house.order(CommandKind::kArm, DeviceRef{0});
  });
}

TEST(ServoCycle, IsCleanUnderGarbage) {
  expectClean([](House& house, int i) {
    hd_local_model model{};
    model.slot = static_cast<std::uint32_t>(i) * 77u;
    model.material.stiffness = std::numeric_limits<double>::quiet_NaN();
    house.push(HD_COMMAND_LOCAL_MODEL, model);
    hd_object_pose pose{};
    pose.object = 0xffffffffu;
    house.push(HD_COMMAND_OBJECT_POSE, pose);
    house.push(static_cast<std::uint32_t>(i), pose);
  });
}

}  // namespace
}  // namespace hapticd
