/** @file
 * A machine on which lock-free code runs under every reordering that C++ allows it, not only those of this processor:
 * x86-64 shows stores in order, so that a missing release or acquire would fail nowhere but on other processors.
 *
 * Threads are fibres that take turns at their atomic operations. Each atomic location keeps all that was ever stored in
 * it; a load may take any of it that is not older than what its thread knows of. A thread comes to know of a store by
 * reading it, or by an acquire load of something that was released after it (C++20 [intro.races], [atomics.order]).
 * Which thread goes on and what a load takes are choices: all of them in turn, or drawn at random.
 *
 * Left out, and so never found: fences; stores that overtake earlier loads of their thread (a test asks instead, by
 * knows(), whether a thread may count on what another has done); and two unordered plain stores to one location (the
 * later in time is the later in modification order).
 */
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

namespace hapticd::model {

/** All that a thread had stored at some moment. */
struct Mark {
  int thread = 0;
  std::uint32_t event = 0;
};

/** One threads. */
class Threads {
 public:
  virtual ~Threads() = default;
  /** Adds a thread, at most four; before go(). */
  virtual void add(std::function<void()> body) = 0;
  /** Runs all threads to their end. */
  virtual void go() = 0;
  /** Of the calling thread. */
  [[nodiscard]] virtual Mark mark() = 0;
  /** Whether the calling thread knows of it: what was done before is done. */
  [[nodiscard]] virtual bool knows(Mark mark) = 0;
  /** Whether the calling thread knows of more than it: what was done before the thread's next store is done, too. */
  [[nodiscard]] virtual bool knowsMoreThan(Mark mark) = 0;
  /** Loads of these bytes take what stands there: one side's accesses to them are not atomic. */
  virtual void plain(const void* begin, std::size_t bytes) = 0;
  /** A run in which `ok` is false has failed, with `what`. It goes on to its end. */
  virtual void expect(bool ok, const char* what) = 0;
};

struct Found {
  std::uint64_t runs = 0;
  bool all = false;     ///< Every choice was made.
  std::string failure;  ///< Of the first run that failed; empty: none.
};

inline constexpr std::uint64_t kMostRuns = 3'000'000;

/** A run from its new objects: adds its threads, and goes. */
using Body = std::function<void(Threads&)>;
/** Makes every choice, a run each, until one fails or there were kMostRuns. */
[[nodiscard]] Found exploreAll(const Body& body);
/** Draws its choices, until a run fails or there were so many. */
[[nodiscard]] Found exploreSome(std::uint64_t runs, std::uint64_t seed, const Body& body);

}  // namespace hapticd::model
