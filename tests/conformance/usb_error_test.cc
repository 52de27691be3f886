// USB devices whose transfers fail while they are still there, as with a cable that is half out: the I/O thread, which
// goes before every servo, must not fail with them as fast as it can, and what the device did not get is not off.
#include <gtest/gtest.h>

#include "tests/conformance/falcon_rig.h"
#include "tests/conformance/sample_rig.h"
#include "tests/support/time.h"

namespace hapticd::test {
namespace {

enum class Orders : std::uint8_t { kArrive, kAreStalled, kNeverEnd };

struct Bus {
  bool failing = false;
  int asked = 0;  ///< While it failed.
  Orders orders = Orders::kArrive;
};

/** Asks for readings fail in no time while the bus does; of orders becomes what it says; all else goes on. */
class FailingUsb final : public UsbTransport {
 public:
  FailingUsb(std::unique_ptr<UsbTransport> usb, Bus& bus) : usb_(std::move(usb)), bus_(bus) {}

  UsbStatus control(const UsbControl& request) noexcept override { return usb_->control(request); }
  UsbStatus postIn() noexcept override {
    if (!bus_.failing) return usb_->postIn();
    constexpr int kEndless = 10'000;
    if (++bus_.asked == kEndless) return UsbStatus::kGone;
    ++failed_;
    return UsbStatus::kOk;
  }
  UsbStatus postOut(std::span<const std::uint8_t> bytes) noexcept override {
    if (bus_.orders == Orders::kArrive) return usb_->postOut(bytes);
    if (bus_.orders == Orders::kNeverEnd && lost_ == kMostPending) return UsbStatus::kError;
    ++lost_;
    return UsbStatus::kOk;
  }
  void poll(std::int64_t until_ns, UsbListener& listener) noexcept override {
    for (; bus_.orders != Orders::kNeverEnd && lost_ > 0; --lost_) listener.onOut(UsbStatus::kStall);
    if (failed_ == 0) return usb_->poll(until_ns, listener);
    --failed_;
    listener.onIn(UsbStatus::kError, {});
  }
  void sendNow(std::span<const std::uint8_t> bytes) noexcept override { usb_->sendNow(bytes); }

 private:
  std::unique_ptr<UsbTransport> usb_;
  Bus& bus_;
  int failed_ = 0;
  std::size_t lost_ = 0;
};

UsbOpener over(UsbOpener open, Bus& bus) {
  return [open = std::move(open), &bus]() -> Result<std::unique_ptr<UsbTransport>> {
    auto usb = open();
    if (!usb) return usb.error();
    return std::unique_ptr<UsbTransport>(std::make_unique<FailingUsb>(std::move(*usb), bus));
  };
}

/** Its readings fail for 0.2 s, then come again. */
void expectPatience(IoDevice& device, Bus& bus, Clock& clock) {
  const auto run = [&](int cycles) {
    int fresh = 0;
    DeviceSample sample;
    for (int i = 0; i < cycles; ++i) {
      device.read(clock.now(), sample);
      fresh += sample.fresh ? 1 : 0;
      device.write(clock.now(), {});
      device.pump(clock.now() + kMs);
    }
    return fresh;
  };
  ASSERT_GT(run(100), 50);
  bus.failing = true;
  (void)run(200);
  EXPECT_GT(bus.asked, 10);
  EXPECT_LT(bus.asked, 200) << "it asks with each order, of which there is one in ten milliseconds without readings";
  bus.failing = false;
  EXPECT_GT(run(200), 100) << "and goes on when the cable is in again";
}

/** A Falcon that is homed, or the sample, behind that bus. */
struct FalconBehind {
  FalconBehind() {
    rig.model.warmUp();
    FalconSetup setup = rig.setup;
    setup.open_usb = over(setup.open_usb, bus);
    device =
        std::make_unique<IoDevice>(std::make_unique<FalconIo>(setup, rig.clock), IoOptions{.thread = false}, rig.clock);
    EXPECT_TRUE(device->open().ok());
  }
  [[nodiscard]] Clock& clock() { return rig.clock; }
  [[nodiscard]] bool pushes() const { return !rig.trueForce().isZero(0); }

  FalconRig rig;
  Bus bus;
  std::unique_ptr<IoDevice> device;
};

struct SampleBehind {
  SampleBehind()
      : device(std::make_unique<IoDevice>(
            std::make_unique<SampleIo>(over(haptic_emu::openInProcess(model, manual), bus), manual),
            IoOptions{.thread = false}, manual)) {
    EXPECT_TRUE(device->open().ok());
  }
  [[nodiscard]] Clock& clock() { return manual; }
  [[nodiscard]] bool pushes() const { return !model.force().isZero(0); }

  haptic_emu::SampleModel model;
  ManualClock manual;
  Bus bus;
  std::unique_ptr<IoDevice> device;
};

template <class Behind>
class UsbErrors : public testing::Test {
 protected:
  Behind behind_;
};
using Behinds = testing::Types<FalconBehind, SampleBehind>;
TYPED_TEST_SUITE(UsbErrors, Behinds, );

TYPED_TEST(UsbErrors, DoNotKeepTheThreadFromResting) {
  expectPatience(*this->behind_.device, this->behind_.bus, this->behind_.clock());
}

TYPED_TEST(UsbErrors, ZerosThatDoNotArriveAreNotOff) {
  TypeParam& behind = this->behind_;
  IoDevice& device = *behind.device;
  const auto cycle = [&](const DeviceCommand& command) {
    DeviceSample sample;
    device.read(behind.clock().now(), sample);
    device.write(behind.clock().now(), command);
    device.pump(behind.clock().now() + kMs);
  };
  for (const Orders orders : {Orders::kAreStalled, Orders::kNeverEnd}) {
    for (int i = 0; i < 50; ++i) cycle(push(Vec3(0, 1, 0)));
    ASSERT_TRUE(behind.pushes());
    behind.bus.orders = orders;
    for (int i = 0; i < 90; ++i) {
      cycle({});
      ASSERT_TRUE(!device.isOff() || !behind.pushes()) << i;
    }
    behind.bus.orders = Orders::kArrive;
    for (int i = 0; i < 50; ++i) cycle({});
    EXPECT_TRUE(device.isOff());
    EXPECT_FALSE(behind.pushes());
  }
  behind.bus.orders = Orders::kNeverEnd;
  for (int i = 0; i < 50; ++i) cycle(push(Vec3(0, 1, 0)));
  device.close();
  behind.bus.orders = Orders::kArrive;
  ASSERT_TRUE(device.open().ok());
  for (int i = 0; i < 50; ++i) cycle({});
  EXPECT_TRUE(device.isOff()) << "what was under way went with the last transport";
}

}  // namespace
}  // namespace hapticd::test
