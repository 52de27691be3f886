/** @file
 * The queues between the threads of one process, under every reordering: SpscRing and Newest.
 *
 * Their values are copied as they are, not atomically, so that what is asked is whether a thread may count on it: the
 * reader knows that a value was written, the writer that the slot it takes was read.
 */
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>

#include "rt/ring/newest.h"
#include "rt/ring/spsc.h"
#include "tests/model/weak_memory.h"

namespace hapticd::model {
namespace {

TEST(WeakQueues, ARingHandsOverEachValueOnceWholeAndInOrder) {
  constexpr int kValues = 3;
  int most_got = 0;
  const Found found = exploreAll([&](Threads& threads) {
    SpscRing<int, 2> ring;
    std::array<Mark, kValues> written{}, read{};
    int pushed = 0, got = 0;
    threads.add([&] {
      for (int turn = 0; turn < kValues; ++turn) {
        written[static_cast<std::size_t>(pushed)] = threads.mark();
        if (!ring.push(pushed)) continue;
        if (pushed >= 2) {
          threads.expect(threads.knowsMoreThan(read[static_cast<std::size_t>(pushed - 2)]),
                         "written before it was read");
        }
        ++pushed;
      }
    });
    threads.add([&] {
      for (int turn = 0; turn < kValues; ++turn) {
        int value = -1;
        const Mark before = threads.mark();
        if (!ring.pop(value)) continue;
        threads.expect(value == got, "out of order");
        threads.expect(threads.knowsMoreThan(written[static_cast<std::size_t>(got)]), "read before it was written");
        read[static_cast<std::size_t>(got++)] = before;
      }
    });
    threads.go();
    threads.expect(ring.size() == static_cast<std::uint32_t>(pushed - got), "a value is lost or invented");
    most_got = std::max(most_got, got);
  });
  EXPECT_EQ(found.failure, "");
  EXPECT_TRUE(found.all) << found.runs;
  EXPECT_EQ(most_got, kValues) << "some run must use a slot again";
}

/** A value that asks at each copy whether its thread may touch what it reads and writes. */
struct Watched {
  Watched() = default;
  Watched(Threads& threads_of, int n_of) : threads(&threads_of), n(n_of) {}
  Watched(const Watched&) = default;
  Watched& operator=(const Watched& from) {
    if (from.threads == nullptr) return *this;
    threads = from.threads;
    n = from.n;
    // The thread's own marks are always known; of the other's, the next store must be: that by which it let go.
    threads->expect(from.written.thread == threads->mark().thread || threads->knowsMoreThan(from.written),
                    "read before it was written");
    threads->expect(!read_once || read.thread == threads->mark().thread || threads->knowsMoreThan(read),
                    "written before it was read");
    written = threads->mark();
    from.read = threads->mark();
    from.read_once = true;
    return *this;
  }

  Threads* threads = nullptr;
  int n = 0;
  Mark written;
  mutable Mark read;
  mutable bool read_once = false;
};

TEST(WeakQueues, TheNewestValueIsWholeAndNeverOlderThanTheLast) {
  constexpr int kValues = 4, kTakes = 3;
  int most_taken = 0;
  const Found found = exploreAll([&](Threads& threads) {
    Newest<Watched> newest;
    int last = 0, taken = 0;
    threads.add([&] {
      for (int n = 1; n <= kValues; ++n) {
        Watched value(threads, n);
        value.written = threads.mark();
        newest.put(value);
      }
    });
    threads.add([&] {
      for (int turn = 0; turn < kTakes; ++turn) {
        Watched value;
        if (!newest.take(value)) continue;
        threads.expect(value.n > last, "older than the last");
        last = value.n;
        ++taken;
      }
      most_taken = std::max(most_taken, taken);
      for (Watched value; last < kValues && newest.take(value);) last = value.n;
    });
    threads.go();
  });
  EXPECT_EQ(found.failure, "");
  EXPECT_TRUE(found.all) << found.runs;
  EXPECT_EQ(most_taken, kTakes);
}

}  // namespace
}  // namespace hapticd::model
