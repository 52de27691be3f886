// Work of many clients for one who does it: who waits behind whom.
#include "daemon/leash/turns.h"

#include <gtest/gtest.h>

#include <array>
#include <deque>

#include "tests/support/random.h"

namespace hapticd {
namespace {

struct Numbered {
  std::uint64_t client;
  int number;
};

/** The job whose turn it is. */
Numbered nextOf(Turns<Numbered>& turns) {
  std::list<Numbered> out;
  turns.next(out);
  EXPECT_EQ(out.size(), 1u);
  return out.back();
}

/** Whatever comes and is taken back: a client's own jobs keep their order, and before its first one comes at most one
 * of every other client that waits. */
TEST(Turns, BeforeAClientsFirstJobComesOneOfEachOther) {
  constexpr std::uint64_t kClients = 4;
  Random random(seedOf(1));
  Turns<Numbered> turns;
  std::array<std::deque<int>, kClients> waiting;
  std::array<std::array<int, kClients>, kClients> passed{};  // [who waits][who came]: since its own last came or began.
  std::size_t count = 0;
  const auto gone = [&](std::uint64_t client) { passed[client].fill(0); };
  for (int i = 0; i < 20000; ++i) {
    if (const std::uint64_t client = random.below(kClients); random.once(2) && count < 30) {
      if (waiting[client].empty()) gone(client);
      waiting[client].push_back(i);
      turns.push(client, {client, i});
      ++count;
    } else if (random.once(5) && !waiting[client].empty()) {
      const auto at = static_cast<std::size_t>(random.below(static_cast<unsigned>(waiting[client].size())));
      const int number = waiting[client][at];
      std::list<Numbered> out;
      ASSERT_TRUE(turns.take([&](const Numbered& job) { return job.number == number; }, out));
      ASSERT_EQ(out.size(), 1u);
      ASSERT_EQ(out.back().number, number);
      ASSERT_FALSE(turns.take([&](const Numbered& job) { return job.number == number; }, out));
      waiting[client].erase(waiting[client].begin() + static_cast<std::ptrdiff_t>(at));
      --count;
    } else if (count > 0) {
      const Numbered job = nextOf(turns);
      ASSERT_EQ(job.number, waiting[job.client].front());
      waiting[job.client].pop_front();
      gone(job.client);
      for (std::uint64_t other = 0; other < kClients; ++other) {
        if (other == job.client || waiting[other].empty()) continue;
        ASSERT_LE(++passed[other][job.client], 1) << other << " waits for " << job.client;
      }
      --count;
    }
    ASSERT_EQ(turns.size(), count);
    ASSERT_EQ(turns.empty(), count == 0);
  }
}

/** What goes before all has had its turn: its client's others keep theirs, and what comes later goes behind these. */
TEST(Turns, WhatIsPutFirstComesNextAndTakesNobodysTurn) {
  Turns<Numbered> turns;
  for (const std::uint64_t client : {1, 2}) {
    for (const int number : {1, 2}) turns.push(client, {client, number});
  }
  turns.pushFirst(2, {2, 0}, {});
  turns.push(2, {2, 3});
  const Numbered order[] = {{2, 0}, {1, 1}, {2, 1}, {1, 2}, {2, 2}, {2, 3}};
  for (const Numbered& job : order) {
    const Numbered next = nextOf(turns);
    EXPECT_EQ(next.client, job.client);
    EXPECT_EQ(next.number, job.number);
  }
  EXPECT_TRUE(turns.empty());
}

/** The first that fits, in the order in which they would come of each client. */
TEST(Turns, OfSeveralThatFitTheFirstIsTaken) {
  Turns<Numbered> turns;
  for (const int number : {1, 2, 3}) turns.push(1, {1, number});
  turns.push(2, {2, 2});
  std::list<Numbered> out{{0, 0}};
  EXPECT_TRUE(turns.take([](const Numbered& job) { return job.number >= 2; }, out));
  ASSERT_EQ(out.size(), 2u) << "at the end";
  EXPECT_EQ(out.back().client, 1u);
  EXPECT_EQ(out.back().number, 2);
  EXPECT_FALSE(turns.take([](const Numbered& job) { return job.number == 4; }, out));
  EXPECT_EQ(out.size(), 2u);
  EXPECT_EQ(turns.size(), 3u);
}

}  // namespace
}  // namespace hapticd
