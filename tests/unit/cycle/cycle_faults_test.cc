// Whatever may latch a fault reaches the guard in its tick: of one device that device's, of the machine all of them.
#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <string>

#include "tests/support/stepped/stepped_cycle.h"
#include "tests/support/time.h"

namespace hapticd {
namespace {

constexpr std::uint32_t kHands = 2;
constexpr double kFastest = 2;  ///< [m/s]

/** Two armed hands at rest, which feel a force of their client's. */
class CycleFaults : public testing::Test, protected test::SteppedCycle {
 protected:
  CycleFaults() : SteppedCycle(config()) {
    put(CommandKind::kAddSession, SessionRef{0, 0, 1});
    for (std::uint32_t d = 0; d < kHands; ++d) {
      input->device[d].fresh = true;
      hd_client_force push{};
      push.device = d;
      push.lease_ns = 10'000 * kMs;
      push.force[0] = 1;
      put(CommandKind::kClientForce, push, 0);
      put(CommandKind::kArm, DeviceRef{d});
    }
    for (int i = 0; i < 30; ++i) step();
    for (const DeviceOutput& out : {output->device[0], output->device[1]}) EXPECT_NEAR(out.command.force.x(), 1, 1e-9);
  }
  /** Faults of the two, and what is sent then. */
  void expectFaults(std::uint32_t first, std::uint32_t second, const std::string& what) {
    const std::array<std::uint32_t, kHands> expected{first, second};
    for (std::uint32_t d = 0; d < kHands; ++d) {
      const DeviceOutput& out = output->device[d];
      EXPECT_EQ(out.guard.fault, expected[d]) << what << ", device " << d;
      EXPECT_EQ(out.command.enabled, expected[d] == HD_FAULT_NONE) << what;
      EXPECT_NEAR(out.command.force.x(), expected[d] == HD_FAULT_NONE ? 1 : 0, 1e-9) << what;
    }
  }

  static CycleConfig config() {
    CycleConfig config;
    config.device_count = kHands;
    for (GuardConfig& guard : config.guard) {
      guard.limits = {10, 1, 1e6, 1e3, 5, kFastest, 50, 50};
      guard.ramp_ns = kMs;
      guard.small_force = 100;
    }
    return config;
  }

  const std::int64_t stale_ns = config().guard[0].stale_ns;
  const std::uint32_t most_missed = config().guard[0].missed_limit;
};

TEST_F(CycleFaults, OfTheMachineStopAll) {
  input->stop_line = true;
  step();
  expectFaults(HD_FAULT_STOP_LINE, HD_FAULT_STOP_LINE, "the stop line");
}

TEST_F(CycleFaults, ADeadmanLetGoStopsAll) {
  input->deadman_open = true;
  step();
  expectFaults(HD_FAULT_DEADMAN, HD_FAULT_DEADMAN, "the dead-man switch");
}

TEST_F(CycleFaults, MissedPeriodsStopAllOnceTheyAreTooMany) {
  input->missed = most_missed - 1;
  step();
  expectFaults(HD_FAULT_NONE, HD_FAULT_NONE, "one less");
  input->missed = most_missed;
  step();
  expectFaults(HD_FAULT_OVERRUN, HD_FAULT_OVERRUN, "too many");
}

TEST_F(CycleFaults, ASilentDeviceIsGivenUpAfterItsTime) {
  input->device[1].fresh = false;
  for (std::int64_t silent_ns = kMs; silent_ns <= stale_ns; silent_ns += kMs) {
    step();
    expectFaults(HD_FAULT_NONE, HD_FAULT_NONE, std::to_string(silent_ns));
  }
  step();
  expectFaults(HD_FAULT_NONE, HD_FAULT_DEVICE_LOST, "longer");
}

TEST_F(CycleFaults, AHandThatIsTooFastIsNotPushed) {
  for (const double speed : {0.95 * kFastest, 1.05 * kFastest}) {
    for (int i = 0; i < 20; ++i) {
      input->device[0].p.y() += 1e-3 * speed;
      step();
    }
    expectFaults(speed > kFastest ? HD_FAULT_VELOCITY : HD_FAULT_NONE, HD_FAULT_NONE, std::to_string(speed));
  }
}

TEST_F(CycleFaults, OfOneDeviceStopThatOne) {
  input->device[1].status = kDeviceError;
  step();
  expectFaults(HD_FAULT_NONE, HD_FAULT_DEVICE_ERROR, "an error");
  input->device[0].gravity.z() = std::numeric_limits<double>::quiet_NaN();
  step();
  expectFaults(HD_FAULT_NOT_FINITE, HD_FAULT_DEVICE_ERROR, "a source that is not finite");
}

TEST_F(CycleFaults, PeriodsThatWereMissedAreToldOnceHoweverManyHandsThereAre) {
  for (const std::uint32_t missed : {0u, 1u, 7u, 0u}) {
    input->missed = missed;
    step();
    std::uint32_t events = 0, told = 0;
    for (std::uint32_t i = 0; i < output->events.count; ++i) {
      if (output->events.event[i].kind != ServoEventKind::kOverrun) continue;
      ++events;
      told = output->events.event[i].value;
    }
    EXPECT_EQ(events, missed != 0 ? 1u : 0u);
    EXPECT_EQ(told, missed);
  }
}

}  // namespace
}  // namespace hapticd
