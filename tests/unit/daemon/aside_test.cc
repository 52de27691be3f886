// Work that takes long, beside a control thread that must not wait for it.
#include "daemon/scene/upload/aside.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <future>
#include <new>
#include <stdexcept>
#include <vector>

namespace hapticd {
namespace {

template <class Done>
bool until(Aside& aside, Done&& done) {
  for (int i = 0; i < 5000 && !done(); ++i) {
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
