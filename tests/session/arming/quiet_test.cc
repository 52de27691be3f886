// When a daemon that stops may go, and a device be closed: no force or torque is on its way any more.
#include "tests/session/bench.h"

namespace hapticd::test {
namespace {

constexpr double kSlew = 5;          ///< [N/s], so that what is pushed with takes a while to go.
constexpr double kTorqueSlew = 0.5;  ///< [N m/s]

constexpr const char* kTurned = "sim://default?mass=0.3";

struct Quiet : testing::Test {
  /** A client that pushes and turns the second device, which it has asked for. */
  void push(const Vec3& force, const Vec3& torque) {
    bench.core.devices().setFactory([this](std::string_view uri) -> Result<std::unique_ptr<Device>> {
      auto device = std::make_unique<ScriptedDevice>();
      device->setUri(std::string(uri));
      device->actuateRotation();
      bench.scripted.push_back(device.get());
      return std::unique_ptr<Device>(std::move(device));
    });
    const auto session = bench.core.openSession(kTurned, bench.connection, "t", HD_SHM_MAJOR, HD_SHM_MINOR);
    ASSERT_TRUE(session.ok()) << toString(session.error());
    id = (*session)->id;
    bench.client = std::make_unique<ClientSide>(**session);
    ASSERT_TRUE(bench.core.sessions().mapped(id).ok());
    bench.step(4);
    ASSERT_TRUE(bench.arm(id).ok());
    bench.step(50);
    hd_client_force order{};
    order.lease_ns = 10'000 * kMs;
    store(force, order.force);
    store(torque, order.torque);
    std::uint64_t seq = 0;
    ASSERT_EQ(bench.client->producer->push(HD_COMMAND_CLIENT_FORCE, std::as_bytes(std::span(&order, 1)), 0, seq),
              ErrorCode::kOk);
    bench.step(500);
    EXPECT_NEAR(sent().force.x(), force.x(), 1e-3);
    EXPECT_NEAR(sent().torque.x(), torque.x(), 1e-3);
  }
  static Config slow() {
    Config config = Bench::relaxed();
    config.limits.force_slew_n_per_s = kSlew;
    config.limits.torque_slew_nm_per_s = kTorqueSlew;
    return config;
  }
  [[nodiscard]] const DeviceCommand& sent() const { return bench.scripted.back()->sent.back(); }
  [[nodiscard]] bool nothingSent() const { return sent().force.isZero(0) && sent().torque.isZero(0); }

  Bench bench{slow()};
  std::uint64_t id = 0;
};

TEST_F(Quiet, ADaemonWithoutForceNeedNotWait) {
  EXPECT_TRUE(bench.core.quiet(bench.core.now()));
  bench.core.beginShutdown();
  EXPECT_TRUE(bench.core.quiet(bench.core.now()));
}

TEST_F(Quiet, ForceIsAwaitedToItsEnd) {
  push(Vec3(1, 0, 0), Vec3::Zero());
  const std::int64_t since = bench.core.now();
  EXPECT_FALSE(bench.core.quiet(since)) << "armed";
  bench.core.beginShutdown();
  int ticks = 0;
  for (; ticks < 400 && !bench.core.quiet(since); ++ticks) bench.step();
  EXPECT_TRUE(nothingSent());
  EXPECT_NEAR(ticks, 200, 10) << "1 N at 5 N/s";
}

TEST_F(Quiet, TorqueIsAwaitedToItsEnd) {
  push(Vec3::Zero(), Vec3(0.1, 0, 0));
  const std::int64_t since = bench.core.now();
  bench.core.beginShutdown();
  int ticks = 0;
  for (; ticks < 400 && !bench.core.quiet(since); ++ticks) bench.step();
  EXPECT_TRUE(nothingSent());
  EXPECT_NEAR(ticks, 200, 10) << "0.1 N m at 0.5 N m/s";
}

TEST_F(Quiet, NoDeviceClosesOnATurnedHand) {
  push(Vec3::Zero(), Vec3(0.1, 0, 0));
  bench.core.sessions().end(id, "test");
  bench.step(70);  // Its share has faded, and the torque falls.
  ASSERT_FALSE(nothingSent());
  EXPECT_EQ(bench.core.closeDevice(kTurned, bench.connection).error().code, ErrorCode::kWouldBlock);
  bench.core.disconnect(bench.connection);
  for (int tick = 0; tick < 400 && bench.core.devices().devices().size() == 2; ++tick) {
    for (const auto& link : bench.core.devices().links()) link->group().step();
    const bool nothing = nothingSent();
    bench.core.poll();
    EXPECT_TRUE(nothing || bench.core.devices().devices().size() == 2) << "tick " << tick;
  }
  EXPECT_EQ(bench.core.devices().devices().size(), 1u);
}

TEST_F(Quiet, ArmedIsNotQuietEvenWithoutForce) {
  push(Vec3::Zero(), Vec3::Zero());
  EXPECT_FALSE(bench.core.quiet(bench.core.now()));
  bench.core.beginShutdown();
  bench.step(5);
  EXPECT_TRUE(bench.core.quiet(bench.core.now()));
}

/** A client that reconnects while the daemon stops would have it end on a force that rises again. */
TEST_F(Quiet, NothingIsArmedAnyMore) {
  push(Vec3(1, 0, 0), Vec3::Zero());
  const std::int64_t since = bench.core.now();
  bench.core.beginShutdown();
  bench.step(100);
  EXPECT_FALSE(nothingSent()) << "it falls";
  const auto again = bench.arm(id);
  ASSERT_FALSE(again.ok());
  EXPECT_EQ(again.error().code, ErrorCode::kWouldBlock);
  bench.step(150);
  EXPECT_TRUE(nothingSent());
  EXPECT_TRUE(bench.core.quiet(since));
}

/** A servo that lowers nothing holds the end up for half a second. */
TEST_F(Quiet, PatienceEnds) {
  push(Vec3(1, 0, 0), Vec3::Zero());
  const std::int64_t since = bench.core.now();
  bench.core.beginShutdown();
  bench.clock.advance(500 * kMs);
  EXPECT_FALSE(bench.core.quiet(since));
  bench.clock.advance(1);
  EXPECT_TRUE(bench.core.quiet(since));
}

}  // namespace
}  // namespace hapticd::test
