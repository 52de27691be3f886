// What must stay true of lists and of what is told, whichever allocation fails on the way.
#include <fstream>
#include <new>
#include <sstream>

#include "daemon/armed/armed_list.h"
#include "tests/session/bench.h"
#include "tests/support/process/temporary_directory.h"
#include "tests/support/shortage.h"

namespace hapticd::test {
namespace {

/** `with(shortage)` for the first allocation that fails, the second, ... until there are no more. */
template <class With>
void withoutEach(With&& with) {
  bool struck = true;
  for (std::uint64_t n = 0; struck && n < 1000; ++n) {
    SCOPED_TRACE(n);
    Shortage shortage(n);
    with(shortage);
    struck = shortage.struck();
    if (testing::Test::HasFailure()) return;
  }
  EXPECT_FALSE(struck);
}

/** What is in the file and what the daemon knows to be there are the same, or it would never be taken out. */
TEST(ArmedListWithoutMemory, KnowsWhatItHasWritten) {
  const TemporaryDirectory folder;
  const std::string path = folder.path() + "/armed", uri = "test://a-device-with-a-long-name?serial=1";
  withoutEach([&](Shortage& shortage) {
    auto list = ArmedList::open(path);
    ASSERT_TRUE(list.ok());
    ASSERT_TRUE(list->add("test://other").ok());
    bool refused = false;
    try {
      const Shortage::Scope scope(shortage);
      refused = !list->add(uri);
    } catch (const std::bad_alloc&) {
      refused = true;
    }
    std::stringstream text;
    text << std::ifstream(path).rdbuf();
    const auto there = armedIn(text.str());
    EXPECT_EQ(list->has(uri), !refused);
    EXPECT_EQ(std::ranges::count(there, uri), refused ? 0 : 1);
    EXPECT_EQ(std::ranges::count(there, "test://other"), 1);
  });
}

/** Of two that are disarmed one is closed before its driver has sent the zeros: to find it no more takes memory. */
TEST(DisarmingWithoutMemory, IsToldOnceOfEach) {
  withoutEach([](Shortage& shortage) {
    Bench bench;
    Core& core = bench.core;
    const auto other = core.openDevice("test://another-device-with-a-long-name", bench.administration);
    ASSERT_TRUE(other.ok());
    const std::string names[] = {bench.device(0).name, bench.device(1).name};
    const std::uint64_t listener = core.events().subscribe(0, [] {});
    Session* const first = bench.live();
    const auto second = core.openSession("test://another-device-with-a-long-name", bench.administration, "t",
                                         HD_SHM_MAJOR, HD_SHM_MINOR);
    ASSERT_TRUE(second.ok());
    ASSERT_TRUE(core.sessions().mapped((*second)->id).ok());
    bench.step(4);
    for (const std::uint64_t id : {first->id, (*second)->id}) ASSERT_TRUE(bench.arm(id).ok());
    for (ScriptedDevice* device : bench.scripted) device->hung = true;
    for (const std::uint64_t id : {first->id, (*second)->id}) ASSERT_TRUE(core.disarm(id).ok());
    bench.step(100);
    core.sessions().end((*second)->id, "the test");
    bench.step(100);
    ASSERT_TRUE(core.closeDevice("test://another-device-with-a-long-name", bench.administration).ok());
    bench.scripted[0]->hung = false;
    try {
      const Shortage::Scope scope(shortage);
      core.poll();
    } catch (const std::bad_alloc&) {
    }
    bench.step(3);
    std::uint64_t told[] = {0, 0}, lost = 0;
    for (EventHub::Batch batch = core.events().take(listener); !batch.events.empty();
         batch = core.events().take(listener)) {
      lost += batch.lost;
      for (const Event& event : batch.events) {
        for (int i = 0; i < 2; ++i) told[i] += event.kind == EventKind::kDisarmed && event.device == names[i] ? 1 : 0;
      }
    }
    EXPECT_LE(told[0], 1u);
    EXPECT_LE(told[1], 1u);
    EXPECT_GE(told[0] + told[1] + lost, 2u);
  });
}

/** Whichever part of it fails: all are told in the end, or that something is lost. */
TEST(MissedPeriodsWithoutMemory, AreToldInTheEnd) {
  withoutEach([](Shortage& shortage) {
    Bench bench;
    Core& core = bench.core;
    bench.step(3);
    const std::uint64_t listener = core.events().subscribe(0, [] {});
    const auto& link = core.devices().links().front();
    bench.device().name = "a device with a name that no string holds inline";
    bench.clock.advance(7 * kMs);
    link->group().step();
    try {
      const Shortage::Scope scope(shortage);
      core.poll();
    } catch (const std::bad_alloc&) {
    }
    bench.step(1100);
    bench.clock.advance(3 * kMs);  // What is lost is told with the next.
    bench.step(2);
    std::uint64_t told = 0, lost = 0;
    for (EventHub::Batch batch = core.events().take(listener); !batch.events.empty();
         batch = core.events().take(listener)) {
      lost += batch.lost;
      for (const Event& event : batch.events) told += event.kind == EventKind::kOverrun ? event.value : 0;
    }
    if (lost == 0) {
      EXPECT_EQ(told, link->group().servo().counters.missed.load());
    }
  });
}

}  // namespace
}  // namespace hapticd::test
