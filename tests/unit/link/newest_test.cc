#include "rt/ring/newest.h"

#include <gtest/gtest.h>

#include <thread>

namespace hapticd {
namespace {

TEST(Newest, GivesTheLastValueOnceAndNothingBeforeTheFirst) {
  Newest<int> newest;
  int value = -1;
  EXPECT_FALSE(newest.take(value));
  EXPECT_EQ(value, -1);
  for (int i = 0; i < 5; ++i) newest.put(i);
  EXPECT_TRUE(newest.take(value));
  EXPECT_EQ(value, 4);
  EXPECT_FALSE(newest.take(value));
  newest.put(5);
  EXPECT_TRUE(newest.take(value));
  EXPECT_EQ(value, 5);
}

// Every order of puts and takes of a given length, against the model "last value, taken or not".
TEST(Newest, AnyOrderOfPutsAndTakes) {
  constexpr int kSteps = 12;
  for (unsigned order = 0; order < (1u << kSteps); ++order) {
    Newest<int> newest;
    int last = -1;
    bool fresh = false;
    for (int i = 0; i < kSteps; ++i) {
      if ((order >> i & 1u) != 0) {
        newest.put(last = i);
        fresh = true;
      } else {
        int value = -1;
        ASSERT_EQ(newest.take(value), fresh) << order;
        ASSERT_EQ(value, fresh ? last : -1) << order;
        fresh = false;
      }
    }
  }
}

/** Large enough that a copy is not atomic; plain members, so that the thread sanitizer sees a missing order. */
struct Wide {
  std::uint64_t n[32] = {};
};

TEST(Newest, TwoThreadsNeverSeeATornOrAnOlderValue) {
  constexpr std::uint64_t kPuts = 200'000;
  Newest<Wide> newest;
  std::thread writer([&] {
    Wide wide;
    for (std::uint64_t i = 1; i <= kPuts; ++i) {
      for (std::uint64_t& n : wide.n) n = i;
      newest.put(wide);
    }
  });
  std::uint64_t last = 0;
  while (last < kPuts) {
    Wide wide;
    if (!newest.take(wide)) {
      std::this_thread::yield();
      continue;
    }
    for (const std::uint64_t n : wide.n) ASSERT_EQ(n, wide.n[0]);
    ASSERT_GT(wide.n[0], last);
    last = wide.n[0];
  }
  writer.join();
}

}  // namespace
}  // namespace hapticd
