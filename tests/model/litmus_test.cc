/** @file
 * The machine of weak_memory.h allows what C++ allows, and nothing else: the classic small programs, and wrong code
 * that it must find.
 */
#include <gtest/gtest.h>

#include <array>
#include <atomic>

#include "tests/model/weak_memory.h"

namespace hapticd::model {
namespace {

using Order = std::memory_order;

/** A word, and a flag that tells that it stands: whether a reader of the flag ever misses the word. */
Found messagePassing(Order store, Order load) {
  return exploreAll([=](Threads& threads) {
    std::atomic<int> word{0}, flag{0};
    threads.add([&] {
      word.store(1, Order::relaxed);
      flag.store(1, store);
    });
    threads.add([&] {
      if (flag.load(load) == 1) threads.expect(word.load(Order::relaxed) == 1, "the word is missed");
    });
    threads.go();
  });
}

TEST(WeakMemory, PassesAMessageByReleaseAndAcquireAlone) {
  const Found sound = messagePassing(Order::release, Order::acquire);
  EXPECT_TRUE(sound.failure.empty());
  EXPECT_TRUE(sound.all);
  EXPECT_FALSE(messagePassing(Order::relaxed, Order::acquire).failure.empty());
  EXPECT_FALSE(messagePassing(Order::release, Order::relaxed).failure.empty());
}

/** Each of two tells that it comes, and looks whether the other does: whether both miss each other. */
Found storeBuffering(Order store, Order load) {
  return exploreAll([=](Threads& threads) {
    std::atomic<int> x{0}, y{0};
    int saw_y = -1, saw_x = -1;
    threads.add([&] {
      x.store(1, store);
      saw_y = y.load(load);
    });
    threads.add([&] {
      y.store(1, store);
      saw_x = x.load(load);
    });
    threads.go();
    threads.expect(saw_x == 1 || saw_y == 1, "both missed each other");
  });
}

TEST(WeakMemory, OnlySequentialConsistencyLetsOneOfTwoSeeTheOther) {
  const Found sound = storeBuffering(Order::seq_cst, Order::seq_cst);
  EXPECT_TRUE(sound.failure.empty());
  EXPECT_TRUE(sound.all);
  EXPECT_FALSE(storeBuffering(Order::release, Order::acquire).failure.empty());
  EXPECT_FALSE(storeBuffering(Order::seq_cst, Order::acquire).failure.empty());
}

TEST(WeakMemory, OneLocationNeverGoesBack) {
  const Found found = exploreAll([](Threads& threads) {
    std::atomic<int> x{0};
    threads.add([&] {
      for (int i = 1; i <= 3; ++i) x.store(i, Order::relaxed);
    });
    threads.add([&] {
      int last = 0;
      for (int i = 0; i < 3; ++i) {
        const int now = x.load(Order::relaxed);
        threads.expect(now >= last, "an older value after a newer one");
        last = now;
      }
    });
    threads.go();
    threads.expect(x.load() == 3, "the last value stands when all is over");
  });
  EXPECT_TRUE(found.failure.empty()) << found.failure;
  EXPECT_TRUE(found.all);
}

TEST(WeakMemory, OldValuesAreSeen) {
  std::array<bool, 4> seen{};
  const Found found = exploreAll([&](Threads& threads) {
    std::atomic<int> x{0};
    threads.add([&] {
      for (int i = 1; i <= 3; ++i) x.store(i, Order::relaxed);
    });
    threads.add([&] { seen[static_cast<std::size_t>(x.load(Order::relaxed))] = true; });
    threads.go();
  });
  EXPECT_TRUE(found.all);
  EXPECT_EQ(seen, (std::array<bool, 4>{true, true, true, true}));
}

TEST(WeakMemory, AChangeIsOfTheLastValueAndHandsOnWhatWasReleased) {
  const auto found = [](Order between) {
    return exploreAll([=](Threads& threads) {
      std::atomic<int> word{0}, count{0};
      threads.add([&] {
        word.store(1, Order::relaxed);
        count.fetch_add(1, between);
      });
      threads.add([&] { count.fetch_add(1, Order::relaxed); });
      threads.add([&] {
        if (count.load(Order::acquire) == 2) threads.expect(word.load(Order::relaxed) == 1, "the word is missed");
      });
      threads.go();
      threads.expect(count.load() == 2, "a change was lost");
    });
  };
  const Found sound = found(Order::release);
  EXPECT_TRUE(sound.failure.empty()) << sound.failure;
  EXPECT_TRUE(sound.all);
  EXPECT_EQ(found(Order::relaxed).failure, "the word is missed");
}

TEST(WeakMemory, AThreadKnowsWhatItAcquired) {
  for (const Order order : {Order::acquire, Order::relaxed}) {
    bool knew = false, missed = false;
    const Found found = exploreAll([&](Threads& threads) {
      std::atomic<int> flag{0};
      Mark before;
      threads.add([&] {
        before = threads.mark();
        flag.store(1, Order::release);
      });
      threads.add([&] {
        if (flag.load(order) == 0) return;
        (threads.knowsMoreThan(before) ? knew : missed) = true;
      });
      threads.go();
    });
    EXPECT_TRUE(found.all);
    EXPECT_EQ(knew, order == Order::acquire);
    EXPECT_EQ(missed, order == Order::relaxed);
  }
}

/** A lock by versions, read by two words: whether a copy is ever torn. */
Found seqlock(Order store, Order load) {
  return exploreSome(20'000, 1, [=](Threads& threads) {
    std::atomic<int> version{0};
    std::array<std::atomic<int>, 2> word{};
    threads.add([&] {
      for (int i = 1; i <= 3; ++i) {
        version.store(2 * i - 1, Order::relaxed);
        for (auto& w : word) w.store(i, store);
        version.store(2 * i, Order::release);
      }
    });
    threads.add([&] {
      for (int i = 0; i < 3; ++i) {
        const int before = version.load(Order::acquire);
        const int first = word[0].load(load), second = word[1].load(load);
        if (before % 2 != 0 || version.load(Order::relaxed) != before) continue;
        threads.expect(first == second, "a torn copy");
      }
    });
    threads.go();
  });
}

TEST(WeakMemory, FindsATornCopyWhereAWordIsOnlyRelaxed) {
  EXPECT_TRUE(seqlock(Order::release, Order::acquire).failure.empty());
  EXPECT_EQ(seqlock(Order::relaxed, Order::acquire).failure, "a torn copy");
  EXPECT_EQ(seqlock(Order::release, Order::relaxed).failure, "a torn copy");
}

}  // namespace
}  // namespace hapticd::model
