#include "daemon/log/log.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

namespace hapticd::log {
namespace {

TEST(Log, LevelsHaveNames) {
  for (const Level level : {Level::kTrace, Level::kDebug, Level::kInfo, Level::kWarn, Level::kError, Level::kOff}) {
    const auto parsed = parseLevel(toString(level));
    ASSERT_TRUE(parsed.ok());
    EXPECT_EQ(*parsed, level);
  }
  const auto bad = parseLevel("loud");
  ASSERT_FALSE(bad.ok());
  EXPECT_EQ(bad.error().what, "\"loud\" is not a level");
}

TEST(Log, LevelDecidesWhatIsWritten) {
  setLevel(Level::kWarn);
  testing::internal::CaptureStderr();
  info("quiet {}", 1);
  warn("loud {}", 2);
  setLevel(Level::kOff);
  error("never");
  const std::string text = testing::internal::GetCapturedStderr();
  setLevel(Level::kInfo);
  EXPECT_EQ(text.find("quiet"), std::string::npos);
  EXPECT_NE(text.find("loud 2"), std::string::npos);
  EXPECT_EQ(text.find("never"), std::string::npos);
}

TEST(Log, ControlCharactersCannotForgeALine) {
  EXPECT_EQ(printable("a\nb\x1b[31m\tc\x7f"), "a\\x0ab\\x1b[31m\tc\\x7f");
  EXPECT_EQ(printable("Grüße"), "Grüße");
  EXPECT_EQ(printable("a\xc2\x9b"
                      "31m\xc2\x85\xc2\xa0\xc2"),
            "a\\x9b31m\\x85\xc2\xa0\xc2");
  EXPECT_EQ(printable("\xe2\x80\x82\xc3\x85"), "\xe2\x80\x82\xc3\x85") << "letters with such bytes in them";
  testing::internal::CaptureStderr();
  error("client {}", "x\n00:00:00 error all is lost");
  const std::string text = testing::internal::GetCapturedStderr();
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1) << text;
}

TEST(Log, JournalStreamNamesOurFile) {
  struct stat status {};
  ASSERT_EQ(::fstat(STDERR_FILENO, &status), 0);
  const std::string here = std::to_string(status.st_dev) + ":" + std::to_string(status.st_ino);
  EXPECT_TRUE(isJournalStream(here, STDERR_FILENO));
  EXPECT_FALSE(isJournalStream(here + "1", STDERR_FILENO));
  for (const char* bad : {"", ":", "12", "a:b", "1:2x", "1:", ":2"}) EXPECT_FALSE(isJournalStream(bad, STDERR_FILENO));
  EXPECT_FALSE(isJournalStream(here, -1));
}

TEST(RateLimit, PassesABurstThenCountsTheRest) {
  RateLimit limit(1000, 2);
  std::uint64_t suppressed = 99;
  EXPECT_TRUE(limit.allow(0, suppressed));
  EXPECT_EQ(suppressed, 0u);
  EXPECT_TRUE(limit.allow(10, suppressed));
  for (int i = 0; i < 5; ++i) EXPECT_FALSE(limit.allow(20 + i, suppressed));
  EXPECT_FALSE(limit.allow(999, suppressed));
  EXPECT_TRUE(limit.allow(1000, suppressed));
  EXPECT_EQ(suppressed, 6u);
  EXPECT_TRUE(limit.allow(1001, suppressed));
  EXPECT_EQ(suppressed, 0u);
  EXPECT_EQ(suppressedNote(0), "");
  EXPECT_EQ(suppressedNote(6), " (6 suppressed)");
}

}  // namespace
}  // namespace hapticd::log
