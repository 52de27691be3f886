// The library's threads against each other and against the daemon, for the thread sanitizer. It sees nothing across two
// mappings, so the daemon's side works here on the library's own, which is made writable for it. Witnesses as in
// unit/ring/threads_test.cc: plain memory that one side writes before it publishes and the other reads afterwards.
#include <sys/mman.h>

#include <atomic>
#include <thread>
#include <vector>

#include "libclient/src/session/session.h"
#include "rt/ring/command_ring.h"
#include "rt/ring/state.h"
#include "tests/unit/libclient/fixture.h"

namespace hapticd::test {
namespace {

constexpr std::uint64_t kMessages = 5'000;

class ThreadsTest : public WithSession {};

TEST_F(ThreadsTest, WhatIsPushedAndPublishedIsWholeWhenTaken) {
  client::Opened& opened = *session_->get()->opened;
  ASSERT_EQ(mprotect(opened.map_a.address(), opened.map_a.bytes(), PROT_READ | PROT_WRITE), 0) << strerror(errno);
  auto* const a = static_cast<hd_region_a*>(opened.map_a.address());
  std::vector<std::uint64_t> pushed(kMessages + 1), published(kMessages + 1), popped(kMessages + 1);
  std::atomic<bool> read_all{false};

  std::thread daemon([&] {
    CommandConsumer consumer(opened.b(), a);
    StateWriter writer(a);
    hd_slot slot;
    for (std::uint64_t tick = 1, taken = 0; tick <= kMessages || taken < kMessages;) {
      if (tick <= kMessages) {
        published[tick] = tick;
        hd_sample sample{};
        sample.tick = tick++;
        writer.publish(sample);
      }
      popped[std::min(taken + 1, kMessages)] = taken + 1;
      if (consumer.pop(slot) != CommandConsumer::Pop::kSlot) continue;
      EXPECT_EQ(slot.seq, ++taken);
      EXPECT_EQ(pushed[taken], taken);
      EXPECT_NE(consumer.heartbeat(), 0);
    }
    while (!read_all) {  // the servo goes on; its reader may have been lapped at the end
      hd_sample sample{};
      sample.tick = kMessages;
      writer.publish(sample);
      std::this_thread::yield();
    }
  });
  std::thread pushing([&] {
    for (std::uint64_t seq = 1; seq <= kMessages;) {
      pushed[seq] = seq;
      const auto sent = session_->push(force(1));
      if (!sent) {
        ASSERT_EQ(sent.code(), HAPTIC_WOULD_BLOCK);
        std::this_thread::yield();
        continue;
      }
      ASSERT_EQ(*sent, seq);
      if (seq > HD_RING_SLOTS) {
        EXPECT_EQ(popped[seq - HD_RING_SLOTS], seq - HD_RING_SLOTS);
      }
      ++seq;
    }
  });
  std::vector<haptic_sample> room(64);
  std::uint64_t lost = 0;
  for (std::uint64_t last = 0; last < kMessages;) {
    const auto samples = session_->drain(room, lost);
    EXPECT_TRUE(samples);
    if (!samples) break;
    for (const haptic_sample& sample : *samples) {
      EXPECT_GE(sample.tick, last);
      EXPECT_EQ(published[sample.tick], sample.tick);
      last = sample.tick;
    }
    if (const auto latest = session_->latest()) {
      EXPECT_EQ(published[latest->tick], latest->tick);
    }
  }
  read_all = true;
  pushing.join();
  daemon.join();
}

TEST_F(ThreadsTest, ReadingAndPushingGoOnWhileTheDaemonRestarts) {
  std::atomic<bool> done{false};
  std::atomic<int> cut{0};
  std::thread reading([&] {
    std::vector<haptic_sample> room(16);
    std::uint64_t lost = 0;
    while (!done) {
      static_cast<void>(session_->latest());
      static_cast<void>(client_->daemon());  // written anew by the reconnection
      if (session_->drain(room, lost).code() == HAPTIC_DISCONNECTED) cut |= 1;
      std::this_thread::yield();
    }
  });
  std::thread pushing([&] {
    while (!done) {
      if (session_->push(force(1), {.latest = true}).code() == HAPTIC_DISCONNECTED) cut |= 2;
      std::this_thread::yield();
    }
  });
  restart(2);
  EXPECT_TRUE(eventually([&] { return !client_->connected(); }));
  EXPECT_TRUE(client_->reconnect());
  EXPECT_TRUE(eventually([&] { return cut == 3; })) << "both were told that the session is dead";
  done = true;
  reading.join();
  pushing.join();
  ASSERT_TRUE(session_->reopen());
  EXPECT_TRUE(session_->push(force(1)));
}

TEST_F(ThreadsTest, OthersFindAWholeConnectionOrNone) {
  std::atomic<bool> done{false};
  std::atomic<int> half{0};
  const auto whole = [](int code) { return code == HAPTIC_OK || code == HAPTIC_DISCONNECTED; };
  std::vector<std::thread> asking;
  for (int i = 0; i < 4; ++i) {
    asking.emplace_back([&, i] {
      while (!done) {
        const int code = i == 0 ? client_->subscribe().code() : client_->scene().find("anything").code();
        half += whole(code) ? 0 : 1;
      }
    });
  }
  for (std::uint64_t epoch = 2; epoch < 52; ++epoch) {
    restart(epoch);
    EXPECT_TRUE(eventually([&] { return !client_->connected(); }));
    EXPECT_TRUE(client_->reconnect());
  }
  done = true;
  for (std::thread& thread : asking) thread.join();
  EXPECT_EQ(half, 0) << "asked between connection and handshake";
}

TEST_F(ThreadsTest, SessionsComeAndGoBesideAnotherInUse) {
  std::atomic<bool> done{false};
  std::thread pushing([&] {
    while (!done) {
      static_cast<void>(session_->push(force(1), {.latest = true}));
      static_cast<void>(session_->acks());
      std::this_thread::yield();
    }
  });
  for (int i = 0; i < 20; ++i) {
    auto other = client_->openSession();
    EXPECT_TRUE(other && other->push(force(2)) && other->reopen()) << other.code();
  }
  done = true;
  pushing.join();
  EXPECT_TRUE(session_->alive());
}

}  // namespace
}  // namespace hapticd::test
