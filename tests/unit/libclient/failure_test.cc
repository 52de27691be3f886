#include "libclient/src/reply/failure.h"

#include <gtest/gtest.h>
#include <hapticclient/client.h>

#include <stdexcept>
#include <string>

namespace hapticd::client {
namespace {

TEST(Failure, FillsTheCallersStructure) {
  haptic_error error = HAPTIC_ERROR_INIT;
  EXPECT_EQ(report({HAPTIC_NOT_FOUND, "here", "gone", "look elsewhere"}, &error), HAPTIC_NOT_FOUND);
  EXPECT_EQ(error.code, HAPTIC_NOT_FOUND);
  EXPECT_STREQ(error.where, "here");
  EXPECT_STREQ(error.what, "gone");
  EXPECT_STREQ(error.remedy, "look elsewhere");
}

TEST(Failure, SuccessLeavesItAlone) {
  haptic_error error = HAPTIC_ERROR_INIT;
  error.code = 77;
  EXPECT_EQ(report({}, &error), HAPTIC_OK);
  EXPECT_EQ(error.code, 77);
}

TEST(Failure, WithoutWordsItSaysTheCodesSentence) {
  haptic_error error = HAPTIC_ERROR_INIT;
  report({HAPTIC_TIMEOUT, {}, {}, {}}, &error);
  EXPECT_STREQ(error.what, haptic_error_text(HAPTIC_TIMEOUT));
}

TEST(Failure, LongTextsAreCutBetweenCharacters) {
  haptic_error error = HAPTIC_ERROR_INIT;
  std::string umlauts;
  for (int i = 0; i < 400; ++i) umlauts += "\xc3\xa4";
  report({HAPTIC_SYSTEM, umlauts, umlauts, {}}, &error);
  EXPECT_EQ(std::string(error.where), umlauts.substr(0, 254));  // 255 would split the last one
  EXPECT_EQ(std::string(error.what), umlauts.substr(0, 510));
}

TEST(Failure, AnOlderShorterStructureIsNotOverrun) {
  struct {
    haptic_error error;
  } old{};
  std::memset(&old, 0x55, sizeof old);
  const std::uint32_t size = offsetof(haptic_error, where) + 16;
  old.error.size = size;
  report({HAPTIC_SYSTEM, "a place with a long name", "what", "remedy"}, &old.error);
  EXPECT_EQ(old.error.size, size);
  EXPECT_EQ(std::string(old.error.where), "a place with a ");
  EXPECT_EQ(reinterpret_cast<unsigned char*>(&old)[size], 0x55);
}

TEST(Failure, NoExceptionLeaves) {
  haptic_error error = HAPTIC_ERROR_INIT;
  EXPECT_EQ(edge(&error, []() -> Failure { throw std::runtime_error("boom"); }), HAPTIC_INTERNAL);
  EXPECT_STREQ(error.what, "boom");
  EXPECT_EQ(edge(&error, []() -> Failure { throw std::bad_alloc(); }), HAPTIC_SYSTEM);
  EXPECT_EQ(edge(nullptr, []() -> Failure { throw 7; }), HAPTIC_INTERNAL);
}

TEST(SizedStructures, OlderAndNewerOnesAreRead) {
  struct Newer {
    haptic_connect_options known = HAPTIC_CONNECT_OPTIONS_INIT;
    std::uint64_t unknown = 0;
  } newer;
  haptic_connect_options out = HAPTIC_CONNECT_OPTIONS_INIT;
  newer.known.socket = "/s";
  newer.known.timeout_ns = 5;
  newer.known.size = offsetof(haptic_connect_options, name);
  out.timeout_ns = 9;
  EXPECT_FALSE(readSized(&newer.known, out, 8, "options"));
  EXPECT_STREQ(out.socket, "/s");
  EXPECT_EQ(out.timeout_ns, 9) << "a field that the older structure lacks";

  newer.known.size = sizeof newer;
  EXPECT_FALSE(readSized(&newer.known, out, 8, "options"));
  EXPECT_EQ(out.timeout_ns, 5);
  newer.unknown = 1;
  EXPECT_EQ(readSized(&newer.known, out, 8, "options").code, HAPTIC_UNSUPPORTED);

  for (const std::uint32_t bad : {0u, 4u, 12u, 4104u, 0xfffffff8u}) {
    newer.known.size = bad;
    const Failure failure = readSized(&newer.known, out, 8, "options");
    EXPECT_EQ(failure.code, HAPTIC_INVALID_ARGUMENT) << bad;
    EXPECT_EQ(failure.where, "options.size");
  }
  EXPECT_EQ(readSized<haptic_connect_options>(nullptr, out, 8, "options").code, HAPTIC_INVALID_ARGUMENT);
}

TEST(SizedStructures, OnlyWhatTheCallerHasIsWritten) {
  haptic_connect_options value = HAPTIC_CONNECT_OPTIONS_INIT;
  value.flags = 3;
  value.timeout_ns = 11;
  haptic_connect_options out{};
  out.size = 8;
  EXPECT_FALSE(writeSized(value, &out, "options"));
  EXPECT_EQ(out.flags, 3u);
  EXPECT_EQ(out.timeout_ns, 0);
  EXPECT_EQ(out.size, 8u);
  out.size = 0;
  EXPECT_EQ(writeSized(value, &out, "options").code, HAPTIC_INVALID_ARGUMENT);
}

TEST(Failure, NumbersAreToldAsTheyAre) {
  EXPECT_EQ(textOf(1e-9), "1e-09");
  EXPECT_EQ(textOf(0.25), "0.25");
  EXPECT_EQ(textOf(-1.7976931348623157e308), "-1.7976931348623157e+308");
}

}  // namespace
}  // namespace hapticd::client
