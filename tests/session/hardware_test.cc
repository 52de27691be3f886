// Who may say how a real device is driven.
#include "tests/session/bench.h"

namespace hapticd::test {
namespace {

TEST(Hardware, ItsParametersAreTheAdministrators) {
  Bench bench;
  const auto codeOf = [&](const char* uri, std::uint64_t connection) {
    const auto opened = bench.core.openDevice(uri, connection);
    return opened ? ErrorCode::kOk : opened.error().code;
  };
  const char* tuned = "falcon://default?counts_per_nm=40000";
  EXPECT_EQ(codeOf(tuned, bench.connection), ErrorCode::kPermissionDenied);
  EXPECT_EQ(bench.core.openSession(tuned, bench.connection, "tester", HD_SHM_MAJOR, HD_SHM_MINOR).error().code,
            ErrorCode::kPermissionDenied);
  EXPECT_EQ(bench.core.devices().devices().size(), 1u);

  EXPECT_EQ(codeOf("falcon://default", bench.connection), ErrorCode::kOk);
  EXPECT_EQ(codeOf("sim://default?mass=0.3", bench.connection), ErrorCode::kOk) << "a simulator cannot hurt";
  EXPECT_EQ(codeOf(tuned, bench.administration), ErrorCode::kOk);
  EXPECT_EQ(codeOf(tuned, bench.connection), ErrorCode::kOk) << "it is open already, as the administrator wants it";
}

}  // namespace
}  // namespace hapticd::test
