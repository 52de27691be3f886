/** @file
 * haptic-bench ring: the command ring that trusts nobody against a plain ring between trusting threads, with the same
 * message, the same private copy and the same check; and the ticks from a push to the force it makes.
 */
#include <fmt/format.h>
#include <sched.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstring>
#include <memory>
#include <thread>

#include "rt/base/standard_streams.h"
#include "rt/ring/command_ring.h"
#include "rt/ring/spsc.h"
#include "rt/ring/state.h"
#include "tools/haptic-bench/bench.h"
#include "tools/haptic-bench/command/push_to_force.h"
#include "tools/haptic-bench/option.h"

namespace haptic_bench {
namespace {

using namespace hapticd;  // NOLINT(google-build-using-namespace)

constexpr double kMostTicks = 2;  ///< From a push to its force. The one goal that is a count, hence the exit code.

/** Fills a slot's payload: the message is 512 bytes with its head. */
using Message = std::array<double, sizeof(hd_slot::payload) / sizeof(double)>;

void fill(void* payload, std::uint64_t seq) {
  Message message;
  for (std::size_t i = 0; i < message.size(); ++i) message[i] = static_cast<double>(seq + i);
  std::memcpy(payload, &message, sizeof message);
}

/** What a reader checks of its copy: kind, length, order, and that every number is one. */
bool check(const hd_slot& copy, std::uint64_t expected) {
  if (copy.kind != HD_COMMAND_LOCAL_MODEL || copy.length != sizeof(Message) || copy.seq != expected) return false;
  Message message;
  std::memcpy(&message, copy.payload, sizeof message);
  bool finite = true;
  for (const double x : message) finite &= std::abs(x) <= 1e300;
  return finite;
}

/** Between threads of one process that trust each other. The message is made in place and copied in once, as below. */
class PlainRing {
 public:
  void make(std::uint64_t seq) {
    slot_.kind = HD_COMMAND_LOCAL_MODEL;
    slot_.length = sizeof(Message);
    slot_.seq = seq;
    fill(slot_.payload, seq);
  }
  bool push() { return ring_->push(slot_); }
  bool pop(hd_slot& copy) { return ring_->pop(copy); }

 private:
  std::unique_ptr<SpscRing<hd_slot, HD_RING_SLOTS>> ring_ = std::make_unique<SpscRing<hd_slot, HD_RING_SLOTS>>();
  hd_slot slot_{};
};

/** The rings of a session, both ends in this process. */
class SessionRing {
 public:
  void make(std::uint64_t seq) { fill(message_.data(), seq); }
  bool push() {
    std::uint64_t seq = 0;
    return producer_.push(HD_COMMAND_LOCAL_MODEL, message_, 0, seq) == ErrorCode::kOk;
  }
  bool pop(hd_slot& copy) { return consumer_.pop(copy) == CommandConsumer::Pop::kSlot; }

 private:
  std::unique_ptr<hd_region_a> a_ = std::make_unique<hd_region_a>();
  std::unique_ptr<hd_region_b> b_ = std::make_unique<hd_region_b>();
  CommandProducer producer_{b_.get(), a_.get()};
  CommandConsumer consumer_{b_.get(), a_.get()};
  alignas(8) std::array<std::byte, sizeof(hd_slot::payload)> message_{};
};

[[noreturn]] void fail() {
  hapticd::tellError("haptic-bench ring: a message failed its check; the numbers would be worth nothing\n");
  std::exit(1);
}

double nanoseconds(std::chrono::steady_clock::duration d, std::uint64_t messages) {
  return std::chrono::duration<double, std::nano>(d).count() / static_cast<double>(messages);
}

/** Push, pop, check in turn. */
template <class Ring>
double oneThread(std::uint64_t messages) {
  Ring ring;
  hd_slot copy{};
  const auto start = std::chrono::steady_clock::now();
  for (std::uint64_t n = 1; n <= messages; ++n) {
    ring.make(n);
    if (!ring.push() || !ring.pop(copy) || !check(copy, n)) fail();
  }
  return nanoseconds(std::chrono::steady_clock::now() - start, messages);
}

void pinTo(int nth) {
  cpu_set_t allowed;
  if (sched_getaffinity(0, sizeof allowed, &allowed) != 0 || CPU_COUNT(&allowed) < 2) return;
  for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
    if (!CPU_ISSET(cpu, &allowed) || nth-- > 0) continue;
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(cpu, &one);
    sched_setaffinity(0, sizeof one, &one);
    return;
  }
}

/** Tries until it succeeds; gives the CPU away when the other side seems not to have one. */
template <class Try>
void insist(Try attempt) {
  for (int spins = 0; !attempt(); ++spins) {
    if (spins >= 1000) {
      std::this_thread::yield();
      spins = 0;
    }
  }
}

/** One thread pushes, the other pops and checks, each on a CPU of its own if there are two. */
template <class Ring>
double twoThreads(std::uint64_t messages) {
  Ring ring;
  std::atomic<int> ready{0};
  std::thread producer([&] {
    pinTo(0);
    ++ready;
    insist([&] { return ready == 2; });
    for (std::uint64_t n = 1; n <= messages; ++n) {
      ring.make(n);
      insist([&] { return ring.push(); });
    }
  });
  double result = 0;
  std::thread consumer([&] {
    pinTo(1);
    ++ready;
    insist([&] { return ready == 2; });
    hd_slot copy{};
    const auto start = std::chrono::steady_clock::now();
    for (std::uint64_t n = 1; n <= messages; ++n) {
      insist([&] { return ring.pop(copy); });
      if (!check(copy, n)) fail();
    }
    result = nanoseconds(std::chrono::steady_clock::now() - start, messages);
  });
  producer.join();
  consumer.join();
  return result;
}

int runRing(const Common& common, std::uint64_t messages) {
  Series plain_one{"one thread: plain ring", "ns per message", {}};
  Series ours_one{"one thread: command ring", plain_one.unit, {}};
  Series plain_two{"two threads: plain ring", plain_one.unit, {}};
  Series ours_two{"two threads: command ring", plain_one.unit, {}};
  Series ticks{"push to force: worst (goal 2)", "ticks", {}};
  oneThread<PlainRing>(messages);  // warms up
  for (int round = 0; round < common.rounds; ++round) {
    // Alternating which goes first, so that neither always inherits the other's caches and clock.
    for (const bool plain : {round % 2 == 0, round % 2 != 0}) {
      (plain ? plain_one : ours_one)
          .rounds.push_back(plain ? oneThread<PlainRing>(messages) : oneThread<SessionRing>(messages));
      (plain ? plain_two : ours_two)
          .rounds.push_back(plain ? twoThreads<PlainRing>(messages) : twoThreads<SessionRing>(messages));
    }
    ticks.rounds.push_back(worstPushToForce(static_cast<std::uint32_t>(round)));
  }
  print(common, "ring",
        {plain_one, ours_one, ratio("one thread: ratio (goal 1.5)", ours_one, plain_one), plain_two, ours_two,
         ratio("two threads: ratio (goal 1.5)", ours_two, plain_two), ticks},
        fmt::format("{} messages", messages));
  return *std::max_element(ticks.rounds.begin(), ticks.rounds.end()) <= kMostTicks ? 0 : 1;
}

}  // namespace

void addRing(CLI::App& app, Run& chosen) {
  auto* command =
      app.add_subcommand("ring",
                         "Push, pop and check of the command ring against a plain ring; ticks from push to force\n"
                         "(exit 1 if more than two)");
  auto messages = std::make_shared<std::uint64_t>(100'000);
  bounded(command, "--messages", *messages, "Messages a round and side", 1u, 100'000'000u);
  whenNamed(command, chosen, [messages](const Common& common) { return runRing(common, *messages); });
}

}  // namespace haptic_bench
