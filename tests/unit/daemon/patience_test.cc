// How long the control thread waits for a driver that may never come back.
#include "daemon/device/patience.h"

#include <gtest/gtest.h>

namespace hapticd {
namespace {

constexpr std::int64_t kMost_ns = 300'000'000;

TEST(Patience, OfWhatNeverComesEndsInTime) {
  ManualClock clock(5'000);
  Patience patience(clock, kMost_ns);
  EXPECT_FALSE(patience.until([] { return false; }));
  EXPECT_GE(clock.now(), 5'000 + kMost_ns);
  EXPECT_LE(clock.now(), 5'000 + kMost_ns + Patience::kLook_ns);
  int looks = 0;
  EXPECT_FALSE(patience.until([&] { return ++looks > 1; })) << "the next has no more of it";
  EXPECT_EQ(looks, 1);
  EXPECT_TRUE(patience.until([] { return true; })) << "but is seen where it has come";
}

TEST(Patience, IsNotLostByAMachineThatStoodStill) {
  ManualClock clock;
  Patience patience(clock, kMost_ns);
  clock.advance(10 * kMost_ns);  // As a virtual machine that its host had taken off the processor.
  int looks = 0;
  EXPECT_TRUE(patience.until([&] { return ++looks == Patience::kLooks; })) << "who came as soon as it went on";
  EXPECT_EQ(clock.now(), 10 * kMost_ns + (Patience::kLooks - 1) * Patience::kLook_ns);
}

}  // namespace
}  // namespace hapticd
