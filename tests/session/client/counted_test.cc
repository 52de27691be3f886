// What is counted by number, per user and of all together: regions, subscriptions, connections.
#include "tests/session/bench.h"

namespace hapticd::test {
namespace {

constexpr std::uint32_t kMe = 1000, kAnother = 1001;

TEST(Counted, RegionsPerUserAndGivenBackOneByOne) {
  Bench bench;
  Core& core = bench.core;
  const auto most = [&] {
    std::uint32_t held = 0;
    while (held < 1000 && core.clients().regionHandedOut(kMe)) ++held;
    return held;
  };
  EXPECT_EQ(most(), Clients::kRegionsPerUser);
  EXPECT_EQ(core.clients().regionHandedOut(kMe).error().code, ErrorCode::kQuotaExceeded);
  EXPECT_TRUE(core.clients().regionHandedOut(kAnother).ok()) << "nobody else's";
  core.clients().regionDropped(kAnother);
  EXPECT_EQ(most(), 0u) << "nor is it mine that another gives back";
  for (int i = 0; i < 3; ++i) core.clients().regionDropped(kMe);
  EXPECT_EQ(most(), 3u);
  for (std::uint32_t i = 0; i < Clients::kRegionsPerUser; ++i) core.clients().regionDropped(kMe);
  EXPECT_EQ(most(), Clients::kRegionsPerUser);
}

TEST(Counted, SubscriptionsPerUserOfAllAndApartForAdministrators) {
  Bench bench;
  Core& core = bench.core;
  const auto most = [&](std::uint32_t uid, bool administration) {
    std::uint32_t held = 0;
    while (held < 1000 && core.clients().subscriptionOpened({uid, administration})) ++held;
    return held;
  };
  std::size_t all = 0;
  for (std::uint32_t uid = kMe; all < Clients::kConnections; ++uid) {
    const std::uint32_t held = most(uid, false);
    ASSERT_EQ(held, Clients::kSubscriptionsPerUser) << uid;
    all += held;
  }
  const std::uint32_t late = 5000;
  EXPECT_EQ(core.clients().subscriptionOpened({late, false}).error().code, ErrorCode::kQuotaExceeded)
      << "of all together";
  EXPECT_EQ(most(kMe, true), Clients::kSubscriptionsPerUser) << "the same user's, on the other socket";
  core.clients().subscriptionDropped({kMe, true});
  EXPECT_EQ(most(late, false), 0u);
  core.clients().subscriptionDropped({kMe, false});
  EXPECT_EQ(most(late, false), 1u) << "whoever comes first";
  EXPECT_EQ(most(kMe, false), 0u);
  core.clients().subscriptionDropped({late, false});
  EXPECT_EQ(most(kMe, false), 1u);
  EXPECT_EQ(most(kMe, true), 1u);
}

/** Who has left counts no more, and is not anybody's any more. */
TEST(Counted, ConnectionsUntilTheyAreGone) {
  Bench bench;
  std::vector<std::uint64_t> mine;
  for (auto made = bench.core.connect(7, kAnother, false); made; made = bench.core.connect(7, kAnother, false))
    mine.push_back(*made);
  ASSERT_EQ(mine.size(), Clients::kConnectionsPerUser + Clients::kStopOnlyPerUser);
  for (std::size_t i = 0; i < mine.size(); ++i)
    EXPECT_EQ(bench.core.client(mine[i]).stop_only, i >= Clients::kConnectionsPerUser);
  const Error refused = bench.core.connect(7, kAnother, false).error();
  EXPECT_EQ(refused.code, ErrorCode::kQuotaExceeded);
  EXPECT_NE(refused.what.find("user 1001 has 64"), std::string::npos) << refused.what;
  EXPECT_TRUE(bench.core.connect(7, kAnother, true).ok()) << "the other socket has numbers of its own";
  EXPECT_EQ(bench.core.client(mine.front()).uid, kAnother);
  bench.core.disconnect(mine.front());
  EXPECT_EQ(bench.core.client(mine.front()).connection, 0u);
  const auto again = bench.core.connect(8, kAnother, false);
  ASSERT_TRUE(again.ok());
  EXPECT_FALSE(bench.core.client(*again).stop_only);
  EXPECT_NE(*again, mine.front()) << "a number is never used again";
  EXPECT_EQ(bench.core.client(*again).pid, 8);
  EXPECT_FALSE(bench.core.connect(7, kAnother, false).ok());
}

}  // namespace
}  // namespace hapticd::test
