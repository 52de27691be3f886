// USB devices whose transfers fail at once while they are still there, as with a cable that is half out: the I/O
// thread, which goes before every servo, must not fail with them as fast as it can.
#include <gtest/gtest.h>

#include "tests/conformance/falcon_rig.h"
#include "tests/conformance/sample_rig.h"
#include "tests/support/time.h"

namespace hapticd::test {
namespace {

struct Bus {
  bool failing = false;
  int asked = 0;  ///< While it failed.
};

/** Asks for readings fail in no time while the bus does; all else goes on. */
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
  UsbStatus postOut(std::span<const std::uint8_t> bytes) noexcept override { return usb_->postOut(bytes); }
  void poll(std::int64_t until_ns, UsbListener& listener) noexcept override {
    if (failed_ == 0) return usb_->poll(until_ns, listener);
    --failed_;
    listener.onIn(UsbStatus::kError, {});
  }
  void sendNow(std::span<const std::uint8_t> bytes) noexcept override { usb_->sendNow(bytes); }

 private:
  std::unique_ptr<UsbTransport> usb_;
  Bus& bus_;
  int failed_ = 0;
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

TEST(UsbErrors, DoNotKeepTheThreadOfAFalconFromResting) {
  FalconRig rig;
  rig.model.warmUp();
  Bus bus;
  FalconSetup setup = rig.setup;
  setup.open_usb = over(setup.open_usb, bus);
  IoDevice device(std::make_unique<FalconIo>(setup, rig.clock), {.thread = false}, rig.clock);
  ASSERT_TRUE(device.open().ok());
  expectPatience(device, bus, rig.clock);
}

TEST(UsbErrors, NorThatOfTheSample) {
  haptic_emu::SampleModel model;
  ManualClock clock;
  Bus bus;
  IoDevice device(std::make_unique<SampleIo>(over(haptic_emu::openInProcess(model, clock), bus), clock),
                  {.thread = false}, clock);
  ASSERT_TRUE(device.open().ok());
  expectPatience(device, bus, clock);
}

}  // namespace
}  // namespace hapticd::test
