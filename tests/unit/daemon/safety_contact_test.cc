// A contact that errs toward open, whatever its wire does.
#include "drivers/gpio/safety_contact.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

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

/** Whoever feeds it comes late: the edge that closes it is told before anybody saw how long it had been open. */
TEST(SafetyContact, AnOpeningCountsAlsoWhenItsClosingIsToldFirst) {
  for (const bool long_enough : {false, true}) {
    SafetyContact contact(5 * kMs, true);
    contact.see(false, kQuiet);
    contact.see(true, kQuiet + (long_enough ? 5 : 4) * kMs);
    EXPECT_EQ(contact.open(), long_enough);
    EXPECT_EQ(contact.due(), kQuiet + (long_enough ? 5 * kMs + SafetyContact::kSettle_ns : 5 * kMs));
  }
}

/** Told by edges alone, without a look in between: from each edge on it is open as the whole way of its wire says. */
TEST(SafetyContact, EdgesAloneTellEveryOpeningThatIsLongEnough) {
  std::mt19937 random(seedOf(12));
  int trips = 0, passed_over = 0;
  for (int round = 0; round < 1000; ++round) {
    const std::int64_t debounce = static_cast<std::int64_t>(1 + random() % 5) * kMs;
    SafetyContact contact(debounce, true);
    std::vector<std::int64_t> edges;  // The first opens, the second closes, and so on.
    std::int64_t t = kQuiet;
    for (int edge = 0; edge < 20; ++edge) {
      t += static_cast<std::int64_t>(random() % 8 == 0 ? 40 : 1 + random() % 12) * kMs / 2;
      contact.see(edge % 2 != 0, t);
      edges.push_back(t);
      // Open by an opening as long as the debounce or by two that began within it, and closed for less than it settles.
      bool open = false;
      for (std::size_t i = 0; i < edges.size(); ++i) {
        if (i % 2 == 0) {
          const bool last = i + 1 == edges.size();
          const bool settled = !open || (i > 0 && edges[i] - edges[i - 1] >= SafetyContact::kSettle_ns);
          const bool loose = i > 1 && edges[i] - edges[i - 2] < debounce;
          open = !settled || loose || (!last && edges[i + 1] - edges[i] >= debounce);
        }
      }
      ASSERT_EQ(contact.open(), open) << "round " << round << ", edge " << edge;
      ++(open ? trips : passed_over);
    }
  }
  EXPECT_GT(trips, 1000);
  EXPECT_GT(passed_over, 1000);
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
