// Which readings are believed.
#include "drivers/link/reading_check.h"

#include <gtest/gtest.h>

#include "tests/support/time.h"

namespace hapticd::test {
namespace {

using Verdict = ReadingCheck::Verdict;
constexpr std::int64_t kBegin = 5'000 * kMs;

TEST(ReadingCheck, TheFirstMayBeAnywhereThatIsPossible) {
  ReadingCheck check(1, 3);
  EXPECT_EQ(check.judge(false, 0, kBegin), Verdict::kDropped);
  EXPECT_EQ(check.judge(true, 1e6, kBegin), Verdict::kBelieved);
  check.forget();
  EXPECT_EQ(check.judge(true, 1e6, kBegin + kMs), Verdict::kBelieved);
}

TEST(ReadingCheck, AHandGoesOnWhileNothingIsHeard) {
  ReadingCheck check(2, 3);
  ASSERT_EQ(check.judge(true, 0, kBegin), Verdict::kBelieved);
  EXPECT_EQ(check.judge(true, 200, kBegin + 100 * kMs), Verdict::kBelieved);
  EXPECT_EQ(check.judge(true, 200.1, kBegin + 200 * kMs), Verdict::kDropped);
  ASSERT_EQ(check.judge(true, 200, kBegin + 200 * kMs), Verdict::kBelieved) << "what was silence stays that";
  EXPECT_EQ(check.judge(true, 2, kBegin + 200 * kMs), Verdict::kBelieved) << "two at once are a millisecond apart";
}

TEST(ReadingCheck, DisbeliefGivesNoMoreTimeForAJump) {
  ReadingCheck check(1, 100);
  ASSERT_EQ(check.judge(true, 0, kBegin), Verdict::kBelieved);
  for (int ms = 1; ms < 100; ++ms)
    ASSERT_EQ(check.judge(true, 6, kBegin + ms * kMs), Verdict::kDropped) << ms << ": five milliseconds are the most";
  EXPECT_EQ(check.judge(true, 6, kBegin + 100 * kMs), Verdict::kBroken);
}

TEST(ReadingCheck, SoManyInARowAreAnErrorAndThenTheNextIsTheTruth) {
  ReadingCheck check(1, 3);
  ASSERT_EQ(check.judge(true, 0, kBegin), Verdict::kBelieved);
  EXPECT_EQ(check.judge(true, 50, kBegin + kMs), Verdict::kDropped);
  EXPECT_EQ(check.judge(false, 0, kBegin + 2 * kMs), Verdict::kDropped);
  EXPECT_EQ(check.bad(), 2);
  EXPECT_EQ(check.judge(true, 0, kBegin + 3 * kMs), Verdict::kBelieved);
  EXPECT_EQ(check.bad(), 0) << "not in a row";
  for (const Verdict verdict : {Verdict::kDropped, Verdict::kDropped, Verdict::kBroken})
    EXPECT_EQ(check.judge(true, 50, kBegin + 4 * kMs), verdict);
  EXPECT_FALSE(check.trusted(kBegin + 4 * kMs, 10 * kMs));
  EXPECT_EQ(check.judge(true, 50, kBegin + 5 * kMs), Verdict::kBelieved);
  ASSERT_EQ(check.judge(false, 0, kBegin + 6 * kMs), Verdict::kDropped);
  check.forget();
  EXPECT_EQ(check.bad(), 0) << "they were of another row";
}

TEST(ReadingCheck, OnlyAYoungReadingIsTrusted) {
  ReadingCheck check(1, 3);
  EXPECT_FALSE(check.trusted(0, 10 * kMs)) << "there is none";
  ASSERT_EQ(check.judge(true, 0, kBegin), Verdict::kBelieved);
  EXPECT_TRUE(check.trusted(kBegin + 10 * kMs, 10 * kMs));
  EXPECT_FALSE(check.trusted(kBegin + 10 * kMs + 1, 10 * kMs));
  ASSERT_EQ(check.judge(true, 99, kBegin + 11 * kMs), Verdict::kDropped);
  EXPECT_FALSE(check.trusted(kBegin + 11 * kMs, 10 * kMs)) << "what is dropped makes it no younger";
  check.forget();
  EXPECT_FALSE(check.trusted(kBegin, 10 * kMs));
}

}  // namespace
}  // namespace hapticd::test
