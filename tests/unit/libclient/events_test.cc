#include <poll.h>

#include <atomic>

#include "tests/unit/libclient/fixture.h"

namespace hapticd::test {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

class EventsTest : public WithClient {};

bool readable(int fd) {
  pollfd poll_fd{fd, POLLIN, 0};
  return poll(&poll_fd, 1, 0) == 1;
}

TEST_F(EventsTest, ComeInOrderAndTheDescriptorTells) {
  auto events = client_->subscribe(1u << HAPTIC_EVENT_BUTTON);
  ASSERT_TRUE(events);
  EXPECT_EQ(daemon_->seen().kinds, 1u << HAPTIC_EVENT_BUTTON);
  EXPECT_FALSE(readable(events->fd()));
  EXPECT_EQ(events->next(milliseconds(0)).code(), HAPTIC_TIMEOUT);
  daemon_->send({1, 2});
  for (const std::uint32_t want : {1u, 2u}) {
    EXPECT_TRUE(readable(events->fd()));
    auto event = events->next(seconds(10));
    ASSERT_TRUE(event);
    EXPECT_EQ(event->kind, unsigned{HAPTIC_EVENT_BUTTON});
    EXPECT_EQ(event->value, want);
    EXPECT_STREQ(event->device, "sim");
    EXPECT_EQ(event->lost, 0u);
  }
  EXPECT_FALSE(readable(events->fd()));
}

TEST_F(EventsTest, WaitingIsWoken) {
  auto events = client_->subscribe();
  ASSERT_TRUE(events);
  std::thread sender([&] { daemon_->send({5}); });
  const auto event = events->next(milliseconds(-1));
  sender.join();
  ASSERT_TRUE(event);
  EXPECT_EQ(event->value, 5u);
}

TEST_F(EventsTest, AFullQueueDropsTheOldestAndCounts) {
  auto events = client_->subscribe(0, 3);
  ASSERT_TRUE(events);
  daemon_->send({1, 2, 3, 4, 5}, 10);
  auto event = events->next(seconds(10));
  ASSERT_TRUE(event);
  EXPECT_EQ(event->value, 3u);
  EXPECT_EQ(event->lost, 12u) << "ten in the daemon, two here";
}

TEST_F(EventsTest, TheDaemonsEndIsHeard) {
  auto events = client_->subscribe();
  ASSERT_TRUE(events);
  daemon_->send({1});
  daemon_ = nullptr;
  ASSERT_TRUE(eventually([&] { return !client_->connected(); }));
  EXPECT_TRUE(events->next(seconds(10))) << "what came before is kept";
  EXPECT_EQ(events->next(milliseconds(-1)).code(), HAPTIC_DISCONNECTED);
}

TEST_F(EventsTest, SubscriptionsComeBackWithTheConnection) {
  auto events = client_->subscribe(6);
  ASSERT_TRUE(events);
  restart(2);
  ASSERT_TRUE(eventually([&] { return !client_->connected(); }));
  ASSERT_TRUE(client_->reconnect());
  EXPECT_EQ(daemon_->seen().kinds, 6u);
  daemon_->send({9});
  auto event = events->next(seconds(10));
  ASSERT_TRUE(event);
  EXPECT_EQ(event->value, 9u);
}

TEST_F(EventsTest, ASubscriptionThatIsRefusedAgainIsTold) {
  auto events = client_->subscribe(6);
  ASSERT_TRUE(events);
  restart(2);
  daemon_->script([](Script& script) { script.refuse_subscribe = HAPTIC_QUOTA_EXCEEDED; });
  ASSERT_TRUE(eventually([&] { return !client_->connected(); }));
  EXPECT_EQ(client_->reconnect().code(), HAPTIC_QUOTA_EXCEEDED) << "not a connection that nothing is heard on";
  EXPECT_FALSE(client_->connected());
  EXPECT_EQ(events->next(milliseconds(0)).code(), HAPTIC_DISCONNECTED);
  daemon_->script([](Script& script) { script.refuse_subscribe = 0; });
  ASSERT_TRUE(client_->reconnect());
  daemon_->send({9});
  auto event = events->next(seconds(10));
  ASSERT_TRUE(event);
  EXPECT_EQ(event->value, 9u);
}

TEST_F(EventsTest, ClosingUnsubscribes) {
  {
    auto events = client_->subscribe();
    ASSERT_TRUE(events);
    EXPECT_EQ(daemon_->seen().subscriptions, 1);
  }
  EXPECT_TRUE(eventually([&] { return daemon_->seen().subscriptions == 0; }));
}

struct Heard {
  haptic_client* client;
  std::atomic<std::uint32_t> sum{0};
  std::atomic<int> code{-1};
};

TEST_F(EventsTest, CallbacksRunOnTheLibrarysThreadAndMayNotWait) {
  Heard heard{client_->get()};
  haptic_events_options options = HAPTIC_EVENTS_OPTIONS_INIT;
  options.user = &heard;
  options.callback = [](const haptic_event* event, void* user) {
    auto& h = *static_cast<Heard*>(user);
    haptic_device_list* devices = nullptr;
    h.code = haptic_device_list_all(h.client, &devices, nullptr);
    h.sum += event->value;
  };
  haptic_events* events = nullptr;
  ASSERT_EQ(haptic_events_open(client_->get(), &options, &events, nullptr), HAPTIC_OK);
  daemon_->send({1, 2, 4});
  EXPECT_EQ(heard.sum, 7u);
  EXPECT_EQ(heard.code, HAPTIC_INVALID_ARGUMENT) << "instead of a deadlock";
  haptic_events_close(events);
  daemon_->send({8});
  EXPECT_EQ(heard.sum, 7u);
}

/** Which is filled by the thread that would wait for it. */
TEST_F(EventsTest, NorMayACallbackWaitForAQueue) {
  struct Asked {
    haptic_events* queue = nullptr;
    std::atomic<int> waiting{-1}, at_once{-1};
  } asked;
  ASSERT_EQ(haptic_events_open(client_->get(), nullptr, &asked.queue, nullptr), HAPTIC_OK);
  haptic_events_options options = HAPTIC_EVENTS_OPTIONS_INIT;
  options.kinds = 1u << HAPTIC_EVENT_BUTTON;
  options.user = &asked;
  options.callback = [](const haptic_event*, void* user) {
    auto& a = *static_cast<Asked*>(user);
    haptic_event event = HAPTIC_EVENT_INIT;
    while (haptic_events_next(a.queue, &event, 0) == HAPTIC_OK) {
    }
    a.at_once = haptic_events_next(a.queue, &event, 0);
    a.waiting = haptic_events_next(a.queue, &event, 100'000'000);
  };
  haptic_events* events = nullptr;
  ASSERT_EQ(haptic_events_open(client_->get(), &options, &events, nullptr), HAPTIC_OK);
  daemon_->send({1});
  EXPECT_EQ(asked.waiting, HAPTIC_INVALID_ARGUMENT) << "instead of a deadlock";
  EXPECT_EQ(asked.at_once, HAPTIC_TIMEOUT) << "what is there may be taken";
  haptic_events_close(events);
  haptic_events_close(asked.queue);
}

TEST_F(EventsTest, ACallbackThatThrowsHearsTheNextEventStill) {
  std::atomic<std::uint32_t> sum{0};
  haptic_events_options options = HAPTIC_EVENTS_OPTIONS_INIT;
  options.user = &sum;
  options.callback = [](const haptic_event* event, void* user) {
    *static_cast<std::atomic<std::uint32_t>*>(user) += event->value;
    throw std::runtime_error("the program's own");
  };
  haptic_events* events = nullptr;
  ASSERT_EQ(haptic_events_open(client_->get(), &options, &events, nullptr), HAPTIC_OK);
  daemon_->send({1, 2});
  daemon_->send({4});
  EXPECT_EQ(sum, 7u);
  haptic_events_close(events);
}

/** "Handles may be closed in any order", and neither is said to block. */
TEST_F(EventsTest, ACallbackMayEndItsConnectionAndItself) {
  struct Last {
    haptic_client* client = nullptr;
    haptic_events* events = nullptr;
    std::atomic<int> calls{0};
  } last;
  haptic_connect_options to = HAPTIC_CONNECT_OPTIONS_INIT;
  const std::string path = socket();
  to.socket = path.c_str();
  ASSERT_EQ(haptic_connect(&to, &last.client, nullptr), HAPTIC_OK);
  haptic_events_options options = HAPTIC_EVENTS_OPTIONS_INIT;
  options.user = &last;
  options.callback = [](const haptic_event*, void* user) {
    auto& l = *static_cast<Last*>(user);
    haptic_disconnect(l.client);
    haptic_events_close(l.events);
    ++l.calls;
  };
  ASSERT_EQ(haptic_events_open(last.client, &options, &last.events, nullptr), HAPTIC_OK);
  EXPECT_ANY_THROW(daemon_->send({1, 2})) << "whoever would have answered has gone";
  EXPECT_TRUE(eventually([&] { return last.calls == 1; }));
  EXPECT_TRUE(eventually([&] { return daemon_->seen().subscriptions == 0; }));
}

TEST(EventNames, EachKindHasOne) {
  EXPECT_STREQ(haptic_event_name(HAPTIC_EVENT_TOUCH), "touch");
  EXPECT_STREQ(haptic_event_name(HAPTIC_EVENT_OBJECT_CHANGED), "object-changed");
  EXPECT_STREQ(haptic_event_name(HAPTIC_EVENT_REFUSED), "refused");
  EXPECT_STREQ(haptic_event_name(HAPTIC_EVENT_KINDS), "unknown");
}

}  // namespace
}  // namespace hapticd::test
