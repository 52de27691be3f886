#include "rt/base/error.h"

#include <gtest/gtest.h>

namespace hapticd {
namespace {

TEST(Error, SaysWhereWhatAndRemedy) {
  const Error error{ErrorCode::kBadMesh, "triangle 7", "index 99 is past the last vertex", "export the mesh again"};
  EXPECT_EQ(toString(error), "triangle 7: index 99 is past the last vertex (export the mesh again)");
}

TEST(Error, FallsBackToTheListsSentence) {
  EXPECT_EQ(toString(Error{ErrorCode::kLeaseHeld, {}, {}, {}}), "another client holds the device lease");
  EXPECT_EQ(describe(static_cast<ErrorCode>(9999)), "unknown error");
}

TEST(Result, HoldsAValueOrAnError) {
  const Result<int> good(7);
  ASSERT_TRUE(good.ok());
  EXPECT_EQ(*good, 7);
  const Result<int> bad(Error{ErrorCode::kNotFound, "x", {}, {}});
  ASSERT_FALSE(bad.ok());
  EXPECT_EQ(bad.error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace hapticd
