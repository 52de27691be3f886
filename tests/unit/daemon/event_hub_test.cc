#include "daemon/event/event_hub.h"

#include <gmock/gmock.h>

namespace hapticd {
namespace {

Event event(EventKind kind, std::uint32_t value = 0) {
  Event e;
  e.kind = kind;
  e.value = value;
  return e;
}

TEST(EventHub, EachSubscriberGetsTheKindsItAskedForInOrder) {
  EventHub hub;
  int wakes = 0;
  const auto all = hub.subscribe(0, [&] { ++wakes; });
  const auto faults = hub.subscribe(1u << static_cast<unsigned>(EventKind::kFault), [] {});
  hub.publish(event(EventKind::kTouch, 1));
  hub.publish(event(EventKind::kFault, 2));
  hub.publish(event(EventKind::kUntouch, 3));
  EXPECT_EQ(wakes, 1) << "once until it has taken";
  const auto batch = hub.take(all);
  ASSERT_EQ(batch.events.size(), 3u);
  EXPECT_EQ(batch.events[1].value, 2u);
  EXPECT_EQ(batch.lost, 0u);
  ASSERT_EQ(hub.take(faults).events.size(), 1u);
  EXPECT_TRUE(hub.take(all).events.empty());
  hub.publish(event(EventKind::kTouch));
  EXPECT_EQ(wakes, 2);
}

TEST(EventHub, ASlowSubscriberLosesCountedEventsAndNobodyElseDoes) {
  constexpr std::size_t kQueue = 600;
  EventHub hub(kQueue);
  const auto slow = hub.subscribe(0, [] {});
  const auto quick = hub.subscribe(0, [] {});
  std::size_t got = 0;
  for (std::uint32_t i = 0; i < kQueue + 100; ++i) {
    hub.publish(event(EventKind::kTouch, i));
    got += hub.take(quick).events.size();
  }
  EXPECT_EQ(got, kQueue + 100);
  EventHub::Batch batch = hub.take(slow);
  EXPECT_EQ(batch.lost, 100u);
  std::size_t kept = batch.events.size();
  EXPECT_LE(kept, EventHub::kMostPerCall);
  EXPECT_EQ(batch.events.front().value, 0u) << "the oldest are kept";
  while (!(batch = hub.take(slow)).events.empty()) kept += batch.events.size();
  EXPECT_EQ(kept, kQueue);
}

TEST(EventHub, WhoCouldNotBeToldIsWokenThoughNothingMoreFits) {
  EventHub hub(2);
  int woken = 0;
  const auto id = hub.subscribe(0, [&] { ++woken; });
  for (int i = 0; i < 3; ++i) hub.publish(event(EventKind::kTouch));
  EXPECT_EQ(woken, 1);
  hub.notTold(id, 1);
  hub.publish(event(EventKind::kTouch));
  EXPECT_EQ(woken, 2);
  const auto batch = hub.take(id);
  EXPECT_EQ(batch.events.size(), 2u);
  EXPECT_EQ(batch.lost, 3u);
}

TEST(EventHub, WhatTheServoDroppedIsToldToAll) {
  EventHub hub;
  const auto id = hub.subscribe(0, [] {});
  hub.lost(7);
  EXPECT_TRUE(hub.take(id).events.empty()) << "nothing that it could be told with";
  hub.publish(event(EventKind::kTouch));
  EXPECT_EQ(hub.take(id).lost, 7u);
  EXPECT_EQ(hub.take(id).lost, 0u) << "once";
  hub.unsubscribe(id);
  hub.publish(event(EventKind::kTouch));
  EXPECT_TRUE(hub.take(id).events.empty());
}

}  // namespace
}  // namespace hapticd
