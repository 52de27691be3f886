// A device is on the list of armed ones before it is energised, and leaves it after it has been off for a while.
#include <algorithm>
#include <fstream>
#include <sstream>

#include "daemon/device/device_status.h"
#include "tests/session/bench.h"
#include "tests/support/process/temporary_directory.h"

namespace hapticd::test {
namespace {

std::vector<std::string> onDisk(const std::string& path) {
  std::stringstream out;
  out << std::ifstream(path).rdbuf();
  return armedIn(out.str());
}

const std::vector<std::string> kFirst = {"test://first"};
const std::vector<std::string> kNone;

class Listed : public testing::Test {
 protected:
  Listed() {
    auto list = ArmedList::open(path);
    EXPECT_TRUE(list.ok());
    bench->core.keepArmed(std::move(*list));
  }
  TemporaryDirectory folder;
  std::string path = folder.path() + "/armed";
  std::unique_ptr<Bench> bench = std::make_unique<Bench>();
};

TEST_F(Listed, BeforeTheOrderAndUntilAfterItIsOff) {
  Session* session = bench->live();
  EXPECT_EQ(onDisk(path), kNone);
  bench->core.arm(session->id, [](const Result<void>&) {});
  EXPECT_EQ(onDisk(path), kFirst) << "no cycle has run since the order";
  bench->step(200);
  EXPECT_EQ(onDisk(path), kFirst);
  ASSERT_TRUE(bench->core.disarm(session->id).ok());
  bench->step(20);
  ASSERT_EQ(bench->sample().flags & HD_SAMPLE_ARMED, 0u);
  EXPECT_EQ(onDisk(path), kFirst) << "its driver may be a bit behind";
  bench->step(120);
  EXPECT_EQ(onDisk(path), kNone);
}

TEST_F(Listed, WhileTheOrderWaitsBehindEdits) {
  Session* session = bench->live();
  for (int i = 0; i < 3000; ++i) bench->device().applyRadius();
  bench->core.arm(session->id, [](const Result<void>&) {});
  bench->step(150);
  ASSERT_EQ(bench->sample().flags & HD_SAMPLE_ARMED, 0u);
  EXPECT_EQ(onDisk(path), kFirst) << "off for long, but about to be armed";
  bench->step(100);
  ASSERT_NE(bench->sample().flags & HD_SAMPLE_ARMED, 0u);
  EXPECT_EQ(onDisk(path), kFirst);
}

TEST_F(Listed, AStopTakesItOffToo) {
  Session* session = bench->live();
  ASSERT_TRUE(bench->arm(session->id).ok());
  ASSERT_TRUE(bench->core.stop("", bench->connection).ok());
  bench->step(120);
  EXPECT_EQ(onDisk(path), kNone);
}

TEST_F(Listed, ArmedAgainInBetweenItStays) {
  Session* session = bench->live();
  ASSERT_TRUE(bench->arm(session->id).ok());
  ASSERT_TRUE(bench->core.disarm(session->id).ok());
  bench->step(60);
  ASSERT_TRUE(bench->arm(session->id).ok());
  bench->step(300);
  EXPECT_EQ(onDisk(path), kFirst);
}

/** A thread of its driver's hangs in a transfer: nobody hears that it is off before it is. */
TEST_F(Listed, WhileItsDriverHasNotSentTheZerosItStaysArmed) {
  Core& core = bench->core;
  const std::uint64_t listener = core.events().subscribe(0, [] {});
  Session* session = bench->live();
  ASSERT_TRUE(bench->arm(session->id).ok());
  const auto tellsDisarmed = [&] {
    const std::vector<Event> heard = core.events().take(listener).events;
    return std::any_of(heard.begin(), heard.end(), [](const Event& e) { return e.kind == EventKind::kDisarmed; });
  };
  bench->scripted[0]->hung = true;
  ASSERT_TRUE(core.disarm(session->id).ok());
  bench->step(500);
  ASSERT_EQ(bench->sample().flags & HD_SAMPLE_ARMED, 0u) << "the servo has done its part";
  EXPECT_TRUE(statusOf(*core.devices().devices().front()).armed);
  EXPECT_FALSE(tellsDisarmed());
  EXPECT_EQ(onDisk(path), kFirst);
  bench->scripted[0]->hung = false;
  bench->step(2);
  EXPECT_FALSE(statusOf(*core.devices().devices().front()).armed);
  EXPECT_TRUE(tellsDisarmed());
  bench->step(120);
  EXPECT_EQ(onDisk(path), kNone);
}

TEST_F(Listed, ItIsOffAtAStretchBeforeItLeaves) {
  Session* session = bench->live();
  ASSERT_TRUE(bench->arm(session->id).ok());
  ASSERT_TRUE(bench->core.disarm(session->id).ok());
  for (const bool hung : {false, true, false}) {
    bench->scripted[0]->hung = hung;
    bench->step(70);
    EXPECT_EQ(onDisk(path), kFirst) << "140 ms in all, but not at once";
  }
  bench->step(60);
  EXPECT_EQ(onDisk(path), kNone);
}

TEST_F(Listed, AnEndOfTheDaemonEmptiesItAfterTheDevicesAreSafe) {
  Session* session = bench->live();
  ASSERT_TRUE(bench->arm(session->id).ok());
  bench.reset();
  EXPECT_EQ(onDisk(path), kNone);
}

/** What cannot be listed is not energised. */
TEST(ListedNowhere, IsNotArmed) {
  Bench bench;
  auto full = ArmedList::open("/dev/full");
  ASSERT_TRUE(full.ok()) << toString(full.error());
  bench.core.keepArmed(std::move(*full));
  Session* session = bench.live();
  EXPECT_EQ(bench.arm(session->id).error().code, ErrorCode::kSystem);
  bench.step(20);
  EXPECT_EQ(bench.sample().flags & HD_SAMPLE_ARMED, 0u);
}

}  // namespace
}  // namespace hapticd::test
