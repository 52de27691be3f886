// A contact that errs toward open, whatever its wire does.
#include "drivers/gpio/safety_contact.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/support/seeds.h"
#include "tests/support/time.h"

namespace hapticd::test {
namespace {

constexpr std::int64_t kQuiet = 1'000'000'000;  ///< When it has been closed for long.

/** Opens a closed contact at `opens`, closes it after `for_ns`; says for how long it was then seen open from its edge
 * on. */
std::int64_t tripsAfter(std::int64_t debounce_ns, std::int64_t for_ns) {
  SafetyContact contact(debounce_ns, true);
  contact.see(false, kQuiet);
  for (std::int64_t t = 0; t < 100 * kMs; t += 10'000) {
    if (t == for_ns) contact.see(true, kQuiet + t);
    contact.pass(kQuiet + t);
    if (contact.open()) return t;
  }
  return -1;
}

TEST(SafetyContact, OpenForTheDebounceTimeIsOpenAndAShorterGlitchIsNot) {
  EXPECT_EQ(tripsAfter(2 * kMs, 50 * kMs), 2 * kMs);
  EXPECT_EQ(tripsAfter(2 * kMs, 1 * kMs), -1);
  EXPECT_EQ(tripsAfter(0, 10'000), 0) << "without a debounce the first edge counts";
}

TEST(SafetyContact, ALooseWireIsOpen) {
  SafetyContact contact(5 * kMs, true);
  contact.see(false, kQuiet);
  contact.see(true, kQuiet + kMs);
  EXPECT_FALSE(contact.open());
  contact.see(false, kQuiet + 2 * kMs);
  EXPECT_TRUE(contact.open());
}

TEST(SafetyContact, ClosesWhenItHasBeenQuietForAWhile) {
  SafetyContact contact(kMs, false);
  EXPECT_TRUE(contact.open());
  std::int64_t t = kQuiet;
  for (int i = 0; i < 10; ++i) contact.see(i % 2 == 0, t += 5 * kMs);  // bounces
  contact.see(true, t += 5 * kMs);
  contact.pass(t + SafetyContact::kSettle_ns - 1);
  EXPECT_TRUE(contact.open());
  EXPECT_EQ(contact.due(), t + SafetyContact::kSettle_ns);
  contact.pass(t + SafetyContact::kSettle_ns);
  EXPECT_FALSE(contact.open());
  EXPECT_EQ(contact.due(), SafetyContact::kNever);
}

/** Whatever the wire does, a level that is open for the debounce time or longer is never taken for closed. */
TEST(SafetyContact, AnySequenceOfEdgesErrsTowardOpen) {
  std::mt19937 random(seedOf(11));
  for (int round = 0; round < 300; ++round) {
    const std::int64_t debounce = static_cast<std::int64_t>(random() % 6) * kMs;
    bool level = random() % 2 == 0;
    SafetyContact contact(debounce, level);
    std::int64_t t = kQuiet;
    std::int64_t since = level ? t : t - debounce;
    for (int step = 0; step < 200; ++step) {
      t += static_cast<std::int64_t>(random() % 4) * kMs / 2;
      if (random() % 5 == 0) {
        level = !level;
        since = t;
        contact.see(level, t);
      } else {
        contact.pass(t);
      }
      if (!level && t - since >= debounce) {
        ASSERT_TRUE(contact.open()) << "open since " << t - since << " ns of " << debounce;
      }
      if (level && t - since >= SafetyContact::kSettle_ns) {
        ASSERT_FALSE(contact.open());
      }
      ASSERT_GT(contact.due(), t) << "it is never due in the past";
    }
  }
}

}  // namespace
}  // namespace hapticd::test
