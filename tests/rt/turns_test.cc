// A job goes back to where it came from although there is no memory.
#include "daemon/leash/turns.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/support/detectors.h"

namespace hapticd::test {
namespace {

TEST(Turns, AJobComesBackWithoutMemoryAndIsTheFirst) {
  Turns<std::string> turns;
  const std::string long_enough(100, 'x');
  turns.push(1, long_enough);
  turns.push(2, "other");
  turns.push(1, "next");
  Turns<std::string>::Place place;
  std::list<std::string> one;
  turns.next(one);
  std::string job = std::move(one.front());
  one.clear();
  RtScope scope;
  turns.pushFirst(1, std::move(job), std::move(place));
  EXPECT_EQ(scope.finish().allocations, 0u);
  std::list<std::string> order;
  while (!turns.empty()) turns.next(order);
  EXPECT_EQ(std::vector(order.begin(), order.end()), (std::vector<std::string>{long_enough, "other", "next"}));
}

}  // namespace
}  // namespace hapticd::test
