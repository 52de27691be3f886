// Who may close a device without administration: who alone has asked for it, where nothing real moves.
#include <unistd.h>

#include "tests/session/bench.h"

namespace hapticd::test {
namespace {

struct Closing : testing::Test {
  void open(const char* uri, std::uint64_t connection) {
    const auto opened = bench.core.openDevice(uri, connection);
    ASSERT_TRUE(opened.ok()) << toString(opened.error());
  }
  ErrorCode close(const char* uri, std::uint64_t connection) {
    const auto closed = bench.core.closeDevice(uri, connection);
    return closed ? ErrorCode::kOk : closed.error().code;
  }
  Bench bench;
  const std::uint64_t mine = bench.connection;
  const std::uint64_t other = *bench.core.connect(102, 1001, false);
};

TEST_F(Closing, WhoeverAloneAskedForItMay) {
  open("sim://default?mass=0.3", mine);
  EXPECT_EQ(close("sim://default?mass=0.3", other), ErrorCode::kPermissionDenied);
  open("sim://default?mass=0.3", mine);  // Twice is once.
  EXPECT_EQ(close("sim://default?mass=0.3", mine), ErrorCode::kOk);
  EXPECT_EQ(bench.core.devices().devices().size(), 1u);
}

TEST_F(Closing, NotWhatOthersHaveAskedForUntilTheyLeave) {
  open("sim://default?mass=0.3", mine);
  open("sim://default?mass=0.3", other);
  EXPECT_EQ(close("sim://default?mass=0.3", mine), ErrorCode::kPermissionDenied);
  bench.core.disconnect(other);
  EXPECT_EQ(close("sim://default?mass=0.3", mine), ErrorCode::kOk);
}

/** That stays when he leaves; who comes later has not asked for it alone. */
TEST_F(Closing, NotWhatAnAdministratorHasAskedForWhoHasLeft) {
  const std::uint64_t administrator = *bench.core.connect(103, 0, true);
  open("sim://default?mass=0.3", administrator);
  bench.core.disconnect(administrator);
  open("sim://default?mass=0.3", mine);
  EXPECT_EQ(close("sim://default?mass=0.3", mine), ErrorCode::kPermissionDenied);
  EXPECT_EQ(close("sim://default?mass=0.3", bench.administration), ErrorCode::kOk);
}

TEST_F(Closing, NotWhatIsConfiguredOrReal) {
  open("test://first", mine);
  EXPECT_EQ(close("test://first", mine), ErrorCode::kPermissionDenied);
  open("falcon://default", mine);
  EXPECT_EQ(close("falcon://default", mine), ErrorCode::kPermissionDenied);
  EXPECT_EQ(close("sim://nowhere", mine), ErrorCode::kPermissionDenied);
  EXPECT_EQ(close("sim://nowhere", bench.administration), ErrorCode::kNotFound);
  EXPECT_EQ(close("falcon://default", bench.administration), ErrorCode::kOk);
}

TEST_F(Closing, NotWhileASessionHoldsIt) {
  const auto session = bench.core.openSession("sim://default?mass=0.3", mine, "t", HD_SHM_MAJOR, HD_SHM_MINOR);
  ASSERT_TRUE(session.ok()) << toString(session.error());
  EXPECT_EQ(close("sim://default?mass=0.3", mine), ErrorCode::kDeviceBusy);
  bench.core.sessions().end((*session)->id, "test");
  EXPECT_EQ(close("sim://default?mass=0.3", mine), ErrorCode::kOk);
}

TEST_F(Closing, EndsItsRecording) {
  open("sim://default?mass=0.3", mine);
  const auto recording = bench.core.record("sim://default?mass=0.3", mine);
  ASSERT_TRUE(recording.ok()) << toString(recording.error());
  ASSERT_EQ(close("sim://default?mass=0.3", mine), ErrorCode::kOk);
  std::string reason;
  bench.core.recordings().stop(recording->id, [&](const RecordingEnd& end) { reason = end.reason; });
  for (int i = 0; i < 5000 && reason.empty(); ++i) {
    bench.step();
    ::usleep(1000);
  }
  EXPECT_EQ(reason, "the device was closed");
}

TEST_F(Closing, ThoughAnotherServosDeviceIsInUse) {
  ASSERT_NE(bench.live(), nullptr);
  open("sim://default?mass=0.3", mine);
  EXPECT_EQ(close("sim://default?mass=0.3", mine), ErrorCode::kOk);
}

TEST_F(Closing, WhatWasOpenedWithoutWaitingToo) {
  int answers = 0;
  const auto counted = [&](const Result<OpenDevice*>& device) { answers += device.ok() ? 1 : 0; };
  bench.core.openDevice("sim://default?mass=0.3", mine, counted);
  bench.core.openDevice("sim://default?mass=0.4", mine, counted);
  bench.core.openDevice("sim://default?mass=0.4", other, counted);  // It waits for the same.
  for (int i = 0; i < 10'000 && answers < 3; ++i) {
    bench.step();
    ::usleep(1000);
  }
  ASSERT_EQ(answers, 3);
  EXPECT_EQ(close("sim://default?mass=0.3", mine), ErrorCode::kOk);
  EXPECT_EQ(close("sim://default?mass=0.4", mine), ErrorCode::kPermissionDenied);
}

}  // namespace
}  // namespace hapticd::test
