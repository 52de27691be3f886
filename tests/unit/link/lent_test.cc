// What a device is reached through when it must be safe, while its owner loses it: the sanitizers look on.
#include "drivers/link/lent.h"

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <span>
#include <thread>
#include <vector>

#include "drivers/sample/sample_io.h"

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
  for (int i = 0; i < 500 || uses == 0; ++i) {
    auto device = std::make_unique<int>(1);
    lent.lend(device.get());
    if (i % 2 == 0) std::this_thread::yield();
    EXPECT_EQ(lent.takeBack(), device.get());
    *device = 0;  // Its owner's alone.
  }
  over = true;
  user.join();
}

/** Where all that is posted is lost. What was sent at once lies on the heap, and goes with it. */
class Wire final : public UsbTransport {
 public:
  [[nodiscard]] UsbStatus control(const UsbControl&) noexcept override { return UsbStatus::kOk; }
  [[nodiscard]] UsbStatus postIn() noexcept override { return UsbStatus::kOk; }
  [[nodiscard]] UsbStatus postOut(std::span<const std::uint8_t>) noexcept override { return UsbStatus::kOk; }
  void poll(std::int64_t, UsbListener&) noexcept override {}
  void sendNow(std::span<const std::uint8_t> bytes) noexcept override { sent_.assign(bytes.begin(), bytes.end()); }

 private:
  std::vector<std::uint8_t> sent_;
};

TEST(Lent, ADriverIsMadeSafeWhileItLosesItsDevice) {
  ManualClock clock;
  SampleIo io([] { return Result<std::unique_ptr<UsbTransport>>(std::make_unique<Wire>()); }, clock);
  std::atomic<bool> over{false};
  std::atomic<int> calls{0};
  std::thread other([&] {
    for (; !over; ++calls) io.safe();
  });
  for (int i = 0; i < 300 || calls == 0; ++i) {
    EXPECT_TRUE(io.open(over).ok());
    std::this_thread::yield();
    io.close();
  }
  over = true;
  other.join();
}

}  // namespace
}  // namespace hapticd
