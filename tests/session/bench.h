/** @file
 * The control thread's Core over hand-stepped device groups: no thread, no socket, no waiting.
 */
#pragma once

#include <gtest/gtest.h>
#include <sys/mman.h>

#include <memory>
#include <vector>

#include "daemon/control/core.h"
#include "rt/ring/command_ring.h"
#include "rt/ring/state.h"
#include "tests/support/stepped/scripted_device.h"
#include "tests/support/time.h"

namespace hapticd::test {

/** A client's own mappings of a session, as libhapticclient makes them. */
class ClientSide {
 public:
  explicit ClientSide(const Session& session) {
    a_ = static_cast<hd_region_a*>(
        mmap(nullptr, sizeof(hd_region_a), PROT_READ, MAP_SHARED, session.regions.fileA().fd(), 0));
    b_ = static_cast<hd_region_b*>(
        mmap(nullptr, sizeof(hd_region_b), PROT_READ | PROT_WRITE, MAP_SHARED, session.regions.fileB().fd(), 0));
    producer = std::make_unique<CommandProducer>(b_, a_);
  }
  ~ClientSide() {
    munmap(a_, sizeof(hd_region_a));
    munmap(b_, sizeof(hd_region_b));
  }
  ClientSide(const ClientSide&) = delete;
  ClientSide& operator=(const ClientSide&) = delete;

  /** A client's force [N] for ten seconds. */
  [[nodiscard]] ErrorCode push(const Vec3& force_W) const {
    hd_client_force order{};
    order.lease_ns = 10'000 * kMs;
    store(force_W, order.force);
    std::uint64_t seq = 0;
    return producer->push(HD_COMMAND_CLIENT_FORCE, std::as_bytes(std::span(&order, 1)), 0, seq);
  }
  [[nodiscard]] const hd_region_a* a() const { return a_; }
  [[nodiscard]] hd_region_b* b() const { return b_; }
  std::unique_ptr<CommandProducer> producer;

 private:
  hd_region_a* a_;
  hd_region_b* b_;
};

class Bench {
 public:
  explicit Bench(Config config = relaxed(), std::uint32_t devices = 1) : core(options(config), clock) {
    core.devices().setFactory([this](std::string_view uri) -> Result<std::unique_ptr<Device>> {
      auto device = std::make_unique<ScriptedDevice>();
      device->setUri(uri.empty() ? "test://first" : std::string(uri));
      scripted.push_back(device.get());
      return std::unique_ptr<Device>(std::move(device));
    });
    GroupConfig group;
    group.name = "default";
    for (std::uint32_t i = 0; i < devices; ++i) group.devices.push_back(i == 0 ? "test://first" : "test://second");
    group.rate_hz = 1000;
    const auto opened = core.devices().openGroup(group);
    EXPECT_TRUE(opened.ok()) << toString(opened.error());
    connection = *core.connect(100, 1000, false);
    administration = *core.connect(101, 0, true);
    step(3);
  }

  static Config relaxed() {
    Config config;
    config.servo.allow_no_rt = true;
    config.guard.arm_ramp_ms = 10;
    return config;
  }

  /** Periods of 1 ms; the client's heartbeat goes on if it has one. */
  void step(int periods = 1) {
    for (int i = 0; i < periods; ++i) {
      for (const auto& link : core.devices().links()) link->group().step();
      if (client) client->producer->heartbeat(clock.now());
      core.poll();
    }
  }

  /** A session that is live. */
  Session* live(std::uint64_t of = 0) {
    auto session = core.openSession("", of == 0 ? connection : of, "tester", HD_SHM_MAJOR, HD_SHM_MINOR);
    if (!session) {
      ADD_FAILURE() << toString(session.error());
      return nullptr;
    }
    if (!client) client = std::make_unique<ClientSide>(**session);
    const auto mapped = core.sessions().mapped((*session)->id);
    EXPECT_TRUE(mapped.ok()) << toString(mapped.error());
    step(4);
    EXPECT_EQ((*session)->state, Session::State::kLive);
    return *session;
  }

  Result<void> arm(std::uint64_t session) {
    Result<void> outcome = Error{ErrorCode::kTimeout, "the test", "no answer", {}};
    core.arm(session, [&](Result<void> r) { outcome = std::move(r); });
    step(5);
    return outcome;
  }

  hd_sample sample() {
    hd_sample s{};
    EXPECT_TRUE(core.devices().links().front()->latest(0, s));
    return s;
  }

  OpenDevice& device(std::size_t i = 0) { return *core.devices().devices()[i]; }

  ManualClock clock{1'000'000'000};
  std::vector<ScriptedDevice*> scripted;
  Core core;
  std::unique_ptr<ClientSide> client;
  std::uint64_t connection = 0;
  std::uint64_t administration = 0;

 private:
  static CoreOptions options(const Config& config) {
    CoreOptions o;
    o.config = config;
    o.threads = false;
    o.epoch = 42;
    return o;
  }
};

}  // namespace hapticd::test
