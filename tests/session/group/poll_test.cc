// Core::poll(): what fails in one part of it keeps nothing else from being done, and is told in the end.
#include <new>
#include <stdexcept>

#include "tests/session/bench.h"
#include "tests/support/eventually.h"

namespace hapticd::test {
namespace {

TEST(PollThatFails, DoesWhatComesAfterADefectAndTellsOfIt) {
  Bench bench;
  Session* const session = bench.live();
  const std::uint64_t guest = *bench.core.connect(102, 1001, false);
  ASSERT_TRUE(bench.core.openDevice("sim://default?mass=0.3", guest).ok());
  bench.step(3);
  bench.core.arm(session->id, [](const Result<void>&) { throw std::runtime_error("a defect"); });
  for (int i = 0; i < 5; ++i) {
    for (const auto& link : bench.core.devices().links()) link->group().step();
  }
  bench.core.disconnect(guest);
  ASSERT_EQ(bench.core.devices().devices().size(), 2u);
  EXPECT_THROW(bench.core.poll(), std::runtime_error);
  EXPECT_EQ(bench.core.devices().devices().size(), 1u) << "what nobody wants any more is closed in the same poll()";
  EXPECT_NE(bench.sample().flags & HD_SAMPLE_ARMED, 0u);
  EXPECT_NO_THROW(bench.core.poll());
}

TEST(PollThatFails, TellsThatItHadNoMemory) {
  Bench bench;
  bool tried = false;
  bench.core.recordings().copies().start([]() -> Result<int> { return 0; },
                                         [&](const Result<int>&) {
                                           tried = true;
                                           throw std::bad_alloc();
                                         });
  int thrown = 0;
  EXPECT_TRUE(eventually([&] {
    try {
      bench.core.poll();
    } catch (const std::bad_alloc&) {
      ++thrown;
    }
    return tried;
  }));
  EXPECT_EQ(thrown, 1);
  EXPECT_NO_THROW(bench.core.poll());
}

}  // namespace
}  // namespace hapticd::test
