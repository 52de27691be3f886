#include <gtest/gtest.h>
#include <hapticclient/hapticclient.h>

#include <set>
#include <string>

extern "C" int hapticHeaderInC(void);

namespace {

TEST(Base, HeadersWorkInC) { EXPECT_EQ(hapticHeaderInC(), 1); }

TEST(Base, EveryCodeHasANameAndASentenceOfItsOwn) {
  std::set<std::string> names, texts;
  for (int code = HAPTIC_OK; code <= HAPTIC_INTERNAL; ++code) {
    EXPECT_TRUE(names.insert(haptic_error_name(code)).second) << code;
    EXPECT_TRUE(texts.insert(haptic_error_text(code)).second) << code;
  }
  EXPECT_STREQ(haptic_error_name(HAPTIC_STILL_MAPPED), "HAPTIC_STILL_MAPPED");
  EXPECT_STREQ(haptic_error_name(HAPTIC_INTERNAL + 1), "HAPTIC_UNKNOWN");
  EXPECT_STREQ(haptic_error_name(-1), "HAPTIC_UNKNOWN");
  EXPECT_NE(std::string(haptic_error_text(999)), "");
}

TEST(Base, TheClockRuns) {
  const int64_t before = haptic_now_ns();
  EXPECT_GT(before, 0);
  EXPECT_GE(haptic_now_ns(), before);
}

TEST(Base, FreeTakesNull) { haptic_free(nullptr); }

}  // namespace
