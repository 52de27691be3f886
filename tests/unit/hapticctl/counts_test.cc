// Counts from a moment on, as key c of top sets it.
#include "tools/hapticctl/output/counts.h"

#include <gtest/gtest.h>

namespace hapticctl {
namespace {

struct Counts : testing::Test {
  static haptic_device_status device(const char* uri, std::uint64_t missed, std::uint64_t stale) {
    haptic_device_status d{};
    d.uri = uri;
    d.missed = missed;
    d.stale = stale;
    return d;
  }
  static haptic_statistics statistics(std::uint64_t queries, std::uint64_t exhausted, std::uint64_t unsent) {
    haptic_statistics s{};
    s.collide_queries = queries;
    s.collide_exhausted = exhausted;
    s.collide_unsent = unsent;
    return s;
  }
  static void expect(const DeviceCounts& counts, const std::array<std::uint64_t, 5>& wanted) {
    const std::array<std::uint64_t, 5> got{counts.missed, counts.stale, counts.answers, counts.cut_short, counts.lost};
    EXPECT_EQ(got, wanted);
  }
  Baseline base;
};

TEST_F(Counts, BeginAtTheBaselineEachOfThem) {
  const auto before = device("sim://a", 10, 20);
  const auto collide_before = statistics(300, 40, 5);
  expect(base.since(before, &collide_before), {10, 20, 300, 40, 5});
  base.take(before, &collide_before);
  expect(base.since(before, &collide_before), {0, 0, 0, 0, 0});
  const auto now = device("sim://a", 11, 22);
  const auto collide_now = statistics(333, 44, 10);
  expect(base.since(now, &collide_now), {1, 2, 33, 4, 5});
}

TEST_F(Counts, OfWhomItDoesNotKnowOrWhoBeganAnewAreWhole) {
  const auto before = device("sim://a", 10, 20);
  const auto collide = statistics(300, 40, 5);
  base.take(before, &collide);
  expect(base.since(device("sim://b", 10, 20), &collide), {10, 20, 300, 40, 5});
  const auto anew = statistics(7, 0, 0);
  expect(base.since(device("sim://a", 3, 0), &anew), {3, 0, 7, 0, 0});
  expect(base.since(device("sim://a", 12, 20), nullptr), {2, 0, 0, 0, 0});
}

TEST_F(Counts, OfClientsGoBySession) {
  haptic_client_status client{};
  client.session = 3;
  client.received = 100, client.rejected = 10, client.stale = 1;
  base.take(client);
  client.received = 150, client.rejected = 11, client.stale = 1;
  EXPECT_EQ(base.since(client), (Baseline::ClientCounts{50, 1, 0}));
  client.session = 4;
  EXPECT_EQ(base.since(client), (Baseline::ClientCounts{150, 11, 1}));
}

TEST_F(Counts, OfCollisionsAreToldInALine) {
  EXPECT_EQ(collideLine("sim", {.answers = 1200, .cut_short = 3, .lost = 0}),
            "sim: collisions: 1 200 answers, 3 cut short, 0 lost (hapticctl doctor)\n");
  EXPECT_EQ(collideLine("sim", {.answers = 5}), "sim: collisions: 5 answers, 0 cut short, 0 lost\n");
}

}  // namespace
}  // namespace hapticctl
