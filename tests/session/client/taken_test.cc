// When a group goes, what has ended on it goes with its threads; what is in use, or another group's, stays.
#include <gmock/gmock.h>

#include "tests/session/bench.h"

namespace hapticd::test {
namespace {

TEST(EndedSessions, AreTakenOfTheirGroupAlone) {
  SessionManager::Ended taken;  // Whose memory the servo still writes: the last to go.
  Bench bench;
  ASSERT_TRUE(bench.core.openDevice("test://second", bench.administration).ok());
  bench.step(3);
  SessionManager& sessions = bench.core.sessions();
  const auto live = [&](std::size_t device) {
    auto session = sessions.open(bench.device(device), bench.core.client(bench.connection), bench.clock.now());
    EXPECT_TRUE(session.ok()) << toString(session.error());
    EXPECT_TRUE(sessions.mapped((*session)->id).ok());
    bench.step(4);
    EXPECT_EQ((*session)->state, Session::State::kLive);
    return (*session)->id;
  };
  const std::uint64_t stays = live(0), ends = live(0), others_stay = live(1), others_end = live(1);
  ASSERT_EQ(bench.device(0).sessions, 2u);
  sessions.end(ends, "test");
  sessions.end(others_end, "test");
  taken = sessions.takeEnded(*bench.device(0).link);
  ASSERT_EQ(taken.size(), 1u);
  EXPECT_EQ(taken.front()->id, ends);
  std::vector<std::uint64_t> left;
  for (const Session* session : sessions.all()) left.push_back(session->id);
  EXPECT_THAT(left, testing::ElementsAre(stays, others_stay, others_end));
  EXPECT_EQ(bench.device(0).sessions, 1u);
  EXPECT_EQ(bench.device(1).sessions, 2u);
  bench.step(150);
  EXPECT_EQ(bench.device(1).sessions, 1u);
}

}  // namespace
}  // namespace hapticd::test
