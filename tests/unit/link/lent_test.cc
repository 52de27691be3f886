// What a device is reached through when it must be safe, while its owner loses it: the sanitizers look on.
#include "drivers/link/lent.h"

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <thread>

namespace hapticd {
namespace {

TEST(Lent, IsUsedOnlyWhileItIsLent) {
  Lent<int, -1> lent;
  int uses = 0;
  lent.use([&](int) { ++uses; });
  EXPECT_EQ(uses, 0);
  lent.lend(7);
  EXPECT_EQ(lent.get(), 7);
  lent.use([&](int handle) { uses += handle; });
  EXPECT_EQ(uses, 7);
  EXPECT_EQ(lent.takeBack(), 7);
  EXPECT_EQ(lent.get(), -1);
  EXPECT_EQ(lent.takeBack(), -1);
  lent.use([&](int) { ++uses; });
  EXPECT_EQ(uses, 7);
}

TEST(Lent, IsFreedOnlyWhenNobodyUsesIt) {
  Lent<int*, nullptr> lent;
  std::atomic<bool> over{false};
  std::atomic<int> uses{0};
  std::thread user([&] {
    while (!over) lent.use([&](const int* device) { uses += *device; });
  });
  for (int i = 0; i < 2000 || uses == 0; ++i) {
    auto device = std::make_unique<int>(1);
    lent.lend(device.get());
    if (i % 2 == 0) std::this_thread::yield();
    EXPECT_EQ(lent.takeBack(), device.get());
    *device = 0;  // Its owner's alone.
  }
  over = true;
  user.join();
}

}  // namespace
}  // namespace hapticd
