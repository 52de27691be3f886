// Work that takes long, beside a control thread that must not wait for it.
#include "daemon/scene/upload/aside.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <future>
#include <new>
#include <stdexcept>
#include <utility>
#include <vector>

namespace hapticd {
namespace {

template <class Done>
bool until(Aside& aside, Done&& done) {
  for (int i = 0; i < 60000 && !done(); ++i) {
    aside.poll();
    ::usleep(1000);
  }
  return done();
}

TEST(Aside, NobodyWaitsForWhatTakesLong) {
  std::promise<void> go;
  std::thread::id worked, told;
  int answer = 0;
  Aside aside;
  aside.start(
      [&]() -> Result<int> {
        go.get_future().wait();
        worked = std::this_thread::get_id();
        return 42;
      },
      [&](Result<int> result) {
        answer = *result;
        told = std::this_thread::get_id();
      });
  for (int i = 0; i < 20; ++i) aside.poll();
  EXPECT_EQ(answer, 0);
  EXPECT_EQ(aside.size(), 1u);
  go.set_value();
  ASSERT_TRUE(until(aside, [&] { return answer != 0; }));
  EXPECT_EQ(answer, 42);
  EXPECT_NE(worked, std::this_thread::get_id());
  EXPECT_EQ(told, std::this_thread::get_id());
  EXPECT_EQ(aside.size(), 0u);
}

TEST(Aside, JobsComeInTheirOrderAndMayBeginOthers) {
  std::vector<int> order;
  Aside aside;
  const auto job = [&](int number, auto then) {
    aside.start([number]() -> Result<int> { return number; },
                [&, then](Result<int> result) {
                  order.push_back(*result);
                  then();
                });
  };
  job(1, [&] { job(3, [] {}); });
  job(2, [] {});
  EXPECT_TRUE(until(aside, [&] { return order.size() == 3; }));
  EXPECT_EQ(order, (std::vector{1, 2, 3}));
}

/** Keeps the thread until it is let go. */
struct Gate {
  explicit Gate(Aside& aside) {
    aside.start(
        [go = go.get_future().share()]() -> Result<int> {
          go.wait();
          return 0;
        },
        [](const Result<int>&) {});
  }
  std::promise<void> go;
};

/** Four floods, and one who comes last with two jobs. */
TEST(Aside, EachClientHasItsTurn) {
  std::vector<std::pair<std::uint64_t, int>> order;
  Aside aside;
  Gate gate(aside);
  const auto job = [&](std::uint64_t client, int number) {
    aside.start([]() -> Result<int> { return 0; },
                [&order, client, number](const Result<int>&) { order.emplace_back(client, number); }, client);
  };
  for (std::uint64_t client = 1; client <= 4; ++client) {
    for (int i = 0; i < 10; ++i) job(client, i);
  }
  job(5, 0);
  job(5, 1);
  gate.go.set_value();
  ASSERT_TRUE(until(aside, [&] { return order.size() == 42; }));
  for (std::size_t i = 0; i < 10; ++i) {
    const auto client = 1 + i % 5;
    EXPECT_EQ(order[i], std::pair(client, static_cast<int>(i / 5))) << i;
  }
  for (std::size_t i = 10; i < 42; ++i) {
    const auto client = 1 + (i - 10) % 4;
    EXPECT_EQ(order[i], std::pair(client, 2 + static_cast<int>((i - 10) / 4))) << i;
  }
}

/** Says on which thread it went. */
struct Held {
  explicit Held(std::promise<std::thread::id>& to) : went(&to) {}
  Held(Held&& other) noexcept : went(std::exchange(other.went, nullptr)) {}
  Held& operator=(Held&&) = delete;
  ~Held() {
    if (went != nullptr) went->set_value(std::this_thread::get_id());
  }
  std::promise<std::thread::id>* went;
};

TEST(Aside, WhatNobodyWaitsForIsNotWorkedOn) {
  std::vector<int> worked, told;
  std::vector<ErrorCode> codes;
  std::promise<std::thread::id> went;
  std::thread::id thread;
  Aside aside;
  Gate gate(aside);
  const auto job = [&](int number, std::uint64_t client, auto held) {
    return aside.start(
        [&, number, held = std::move(held)]() -> Result<int> {
          worked.push_back(number);
          thread = std::this_thread::get_id();
          return number;
        },
        [&, number](const Result<int>& result) {
          told.push_back(number);
          codes.push_back(result ? ErrorCode::kOk : result.error().code);
        },
        client);
  };
  (void)job(1, 1, 0);
  const auto gone = job(2, 1, Held(went));
  const auto last = job(3, 1, 0);
  aside.cancel(gone);
  aside.cancel(gone);  // Once is enough.
  EXPECT_EQ(aside.size(), 4u) << "what it holds is there until the thread has let go of it";
  gate.go.set_value();
  ASSERT_TRUE(until(aside, [&] { return told.size() == 3; }));
  aside.cancel(last);  // Too late.
  EXPECT_EQ(worked, (std::vector{1, 3}));
  EXPECT_EQ(told, (std::vector{2, 1, 3}));
  EXPECT_EQ(codes, (std::vector{ErrorCode::kCancelled, ErrorCode::kOk, ErrorCode::kOk}));
  EXPECT_EQ(went.get_future().get(), thread) << "the control thread has no time for it";
  EXPECT_EQ(aside.size(), 0u);
}

TEST(Aside, WhatAJobHoldsGoesOnItsThread) {
  std::promise<std::thread::id> went;
  std::thread::id thread;
  bool told = false;
  Aside aside;
  aside.start(
      [&, held = Held(went)]() -> Result<int> {
        thread = std::this_thread::get_id();
        return 0;
      },
      [&](const Result<int>&) { told = true; });
  ASSERT_TRUE(until(aside, [&] { return told; }));
  EXPECT_EQ(went.get_future().get(), thread);
}

TEST(Aside, WhatIsThrownIsAnError) {
  std::vector<ErrorCode> codes;
  Aside aside;
  const auto note = [&](const Result<int>& result) { codes.push_back(result.error().code); };
  aside.start([]() -> Result<int> { throw std::bad_alloc(); }, note);
  aside.start([]() -> Result<int> { throw std::runtime_error("no"); }, note);
  EXPECT_TRUE(until(aside, [&] { return codes.size() == 2; }));
  EXPECT_EQ(codes, (std::vector{ErrorCode::kSystem, ErrorCode::kInternal}));
}

TEST(Aside, WhatIsNotDoneAtTheEndIsNotTold) {
  std::promise<void> go;
  bool told = false, begun = false;
  std::thread later;
  {
    Aside aside;
    aside.start(
        [&]() -> Result<int> {
          go.get_future().wait();
          return 1;
        },
        [&](const Result<int>&) { told = true; });
    aside.start(
        [&]() -> Result<int> {
          begun = true;
          return 2;
        },
        [&](const Result<int>&) { told = true; });
    later = std::thread([&] {
      ::usleep(20'000);
      go.set_value();
    });
  }
  later.join();
  EXPECT_FALSE(told);
  EXPECT_FALSE(begun) << "it only waited";
}

}  // namespace
}  // namespace hapticd
