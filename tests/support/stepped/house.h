/** @file
 * The real-time side with a simulated device, a small scene and clients, stepped by hand.
 */
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <span>
#include <string>

#include "drivers/registry.h"
#include "rt/cycle/servo.h"
#include "tests/support/stepped/regions.h"
#include "tests/support/stepped/solid.h"

namespace hapticd::test {

inline constexpr std::int64_t kHousePeriodNs = 1'000'000;

/** A servo with one simulated device, five primitives and a client in slot 0; room for another in slot 1. */
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
    config.guard[0].ramp_ns = 10 * kHousePeriodNs;
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
    EXPECT_TRUE(servo->from_control.push(makeCommand(kind, payload)));
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
    const ShapeKind kinds[] = {ShapeKind::kPlane, ShapeKind::kSphere, ShapeKind::kBox, ShapeKind::kCapsule,
                               ShapeKind::kCylinder};
    for (std::uint32_t i = 0; i < 5; ++i) {
      const Pose X{{i == 0 ? 0 : 0.03 * i - 0.08, 0, 0}, Quat::Identity()};
      order(CommandKind::kAddObject,
            solid(makeObjectId(i + 1, 1), kinds[i], {800, 2, 0.6, 0.4}, X, Vec3::Constant(0.02)));
    }
  }
  std::unique_ptr<Device> device_;
};

}  // namespace hapticd::test
