#include "rt/cycle/realtime.h"

#include <gtest/gtest.h>

#include <limits>

namespace hapticd {
namespace {

struct Denormals {
  bool from_results, from_operands;
  bool operator==(const Denormals&) const = default;
};

/** Whether this thread computes denormals, and with them. */
Denormals denormals() {
  volatile double smallest = std::numeric_limits<double>::min(), denormal = std::numeric_limits<double>::denorm_min();
  return {smallest / 2 != 0, denormal * 0x1p100 != 0};
}

TEST(DenormalsAsZero, AreNotThereWhileItLives) {
  constexpr Denormals kThere{true, true}, kGone{false, false};
  ASSERT_EQ(denormals(), kThere);
  {
    const DenormalsAsZero zero(true);
    EXPECT_EQ(denormals(), kGone);
    {
      const DenormalsAsZero kept(false);
      EXPECT_EQ(denormals(), kThere);
    }
    EXPECT_EQ(denormals(), kGone);
  }
  EXPECT_EQ(denormals(), kThere);
}

TEST(DenormalsAsZero, HoldOfOneThreadFromThenOn) {
  Denormals there{true, true};
  RtThread thread;
  ASSERT_TRUE(thread.start("denormals", 1, [&] {
    disableDenormals();
    there = denormals();
  }));
  thread.join();
  EXPECT_EQ(there, (Denormals{false, false}));
  EXPECT_EQ(denormals(), (Denormals{true, true}));
}

}  // namespace
}  // namespace hapticd
