// The real libusb over a kernel that is ours, with a played Falcon behind: what no test in virtual time can show.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/falcon/falcon_boot.h"
#include "drivers/falcon/falcon_io.h"
#include "drivers/link/io_device.h"
#include "drivers/usb/libusb_transport.h"
#include "drivers/usb/usbfs.h"
#include "tests/support/stepped/push.h"
#include "tests/support/time.h"
#include "tests/usbfs/fake_usbfs.h"
#include "tools/haptic-emu/falcon/falcon_model.h"

namespace hapticd::test {
namespace {

using ::testing::HasSubstr;

class Libusb : public ::testing::Test {
 protected:
  Libusb() { model_.warmUp(); }
  static UsbOpener opener() {
    return [] { return openLibusb(FakeUsbfs::device(), falcon::kInterface); };
  }
  /** A Falcon on its own thread, as in the daemon. */
  std::unique_ptr<IoDevice> falcon() {
    FalconSetup setup = *resolveFalcon({"falcon", "played", {}}, {});
    setup.open_usb = opener();
    setup.read_firmware = nullptr;
    IoOptions options;
    options.retry_ns = 20 * kMs;
    return std::make_unique<IoDevice>(std::make_unique<FalconIo>(setup, clock_), options);
  }
  /** A servo until `done`, for at most ten seconds. */
  template <class Done>
  bool servo(IoDevice& device, const DeviceCommand& command, Done done) {
    for (int i = 0; i < 10'000; ++i) {
      device.read(clock_.now(), sample_);
      device.write(clock_.now(), command);
      if (done()) return true;
      clock_.sleepUntil(clock_.now() + kMs);
    }
    return false;
  }
  bool pushes() {
    const auto held = usbfs_.hold();
    return model_.motors() != std::array<std::int16_t, 3>{};
  }
  bool runs() {
    const auto held = usbfs_.hold();
    return model_.running();
  }
  void fault(haptic_emu::FaultKind kind, bool on) {
    const auto held = usbfs_.hold();
    if (on) {
      model_.faults.add({kind, 0, INT64_MAX});
    } else {
      model_.faults.clear();
    }
  }

  MonotonicClock clock_;
  haptic_emu::FalconModel model_;
  FakeUsbfs usbfs_{model_};
  DeviceSample sample_;
};

TEST_F(Libusb, AWholeSessionWithRequestsPostedAhead) {
  auto device = falcon();
  const auto opened = device->open();
  ASSERT_TRUE(opened.ok()) << toString(opened.error());
  int fresh = 0;
  ASSERT_TRUE(servo(*device, push(Vec3::UnitX()), [&] { return (fresh += sample_.fresh ? 1 : 0) > 300; }));
  EXPECT_TRUE(pushes());
  EXPECT_LT(sample_.p.norm(), 0.05);
  // But for a thread that was kept from its turn until all that waited had been answered.
  EXPECT_LT(20 * usbfs_.unawaited, usbfs_.outs) << "an answer must find a request waiting";
  EXPECT_GE(usbfs_.most_waiting, 2u);
  device->close();
  EXPECT_FALSE(pushes());
  EXPECT_EQ(usbfs_.claims, 1);
  EXPECT_EQ(usbfs_.releases, 1);
  EXPECT_EQ(usbfs_.left, 0u) << "what waited was taken back";
}

struct Counts final : UsbListener {
  void onIn(UsbStatus status, std::span<const std::uint8_t>) noexcept override { in += status == UsbStatus::kOk; }
  void onOut(UsbStatus status) noexcept override { out += status == UsbStatus::kOk; }
  int in = 0, out = 0;
};

/** libusb waits for a control transfer with the loop that ends others too: none of these may be forgotten. */
TEST_F(Libusb, WhatEndsDuringAControlTransferIsToldByTheNextPoll) {
  auto usb = opener()();
  ASSERT_TRUE(usb.ok());
  for (int round = 0; round < 20; ++round) {
    Counts counts;
    for (std::size_t i = 0; i < UsbTransport::kMostPending; ++i) ASSERT_EQ((*usb)->postIn(), UsbStatus::kOk);
    EXPECT_EQ((*usb)->postIn(), UsbStatus::kError) << "no more than that";
    clock_.sleepUntil(clock_.now() + 20 * kMs);
    ASSERT_EQ((*usb)->control({0x40, 2, 0, 0}), UsbStatus::kOk);
    for (int i = 0; i < 1000 && counts.in < static_cast<int>(UsbTransport::kMostPending); ++i)
      (*usb)->poll(clock_.now() + 10 * kMs, counts);
    ASSERT_EQ(counts.in, static_cast<int>(UsbTransport::kMostPending)) << round;
  }
}

TEST_F(Libusb, FirmwareIsLoadedBesideWhatWasAskedBefore) {
  std::vector<std::uint8_t> firmware(4096);
  for (std::size_t i = 0; i < firmware.size(); ++i) firmware[i] = static_cast<std::uint8_t>(i * 7);
  for (int i = 0; i < 3; ++i) {
    fault(haptic_emu::FaultKind::kUnplug, true);
    for (int k = 0; k < 5000 && runs(); ++k) clock_.sleepUntil(clock_.now() + 2 * kMs);
    fault(haptic_emu::FaultKind::kUnplug, false);
    ASSERT_FALSE(runs()) << "it has lost its firmware";
    auto usb = opener()();
    ASSERT_TRUE(usb.ok());
    std::atomic<bool> stop{false};
    const auto booted = falcon::boot(**usb, clock_, firmware, stop);
    ASSERT_TRUE(booted.ok()) << toString(booted.error());
    const auto held = usbfs_.hold();
    EXPECT_EQ(model_.firmware(), firmware);
  }
}

TEST_F(Libusb, AKernelDriverIsTakenOffAndGivenBack) {
  usbfs_.kernel_driver = "ftdi_sio";
  {
    const auto usb = opener()();
    ASSERT_TRUE(usb.ok()) << toString(usb.error());
    EXPECT_EQ(usbfs_.detached, 1);
    EXPECT_EQ(usbfs_.given_back, 0);
  }
  EXPECT_EQ(usbfs_.given_back, 1);
}

TEST_F(Libusb, AnotherOwnerIsNamed) {
  usbfs_.busy = true;
  const auto usb = opener()();
  ASSERT_FALSE(usb.ok());
  EXPECT_EQ(usb.error().code, ErrorCode::kDeviceBusy);
  EXPECT_THAT(toString(usb.error()), HasSubstr("another program owns it"));
  usbfs_.busy = false;
  const auto first = opener()();
  ASSERT_TRUE(first.ok());
  EXPECT_EQ(opener()().error().code, ErrorCode::kDeviceBusy) << "two of us";
}

TEST_F(Libusb, NoRightIsNamed) {
  usbfs_.forbidden = true;
  const auto usb = opener()();
  ASSERT_FALSE(usb.ok());
  EXPECT_EQ(usb.error().code, ErrorCode::kPermissionDenied);
  EXPECT_THAT(toString(usb.error()), HasSubstr("group haptic"));
}

TEST_F(Libusb, UnplugInContactIsToldAndReplugFound) {
  auto device = falcon();
  ASSERT_TRUE(device->open().ok());
  ASSERT_TRUE(servo(*device, push(Vec3::UnitX()), [&] { return pushes(); }));
  fault(haptic_emu::FaultKind::kUnplug, true);
  ASSERT_TRUE(servo(*device, push(Vec3::UnitX()), [&] { return (sample_.status & kDeviceGone) != 0; }));
  EXPECT_EQ(device->calibration(), Calibration::kNeeded);
  fault(haptic_emu::FaultKind::kUnplug, false);
  {
    const auto held = usbfs_.hold();
    model_.warmUp();
  }
  EXPECT_TRUE(servo(*device, {}, [&] { return sample_.fresh && sample_.status == kDeviceOk; }));
  EXPECT_EQ(device->link().counters.replugs, 1u);
}

TEST_F(Libusb, SafeSendsZerosPastTheThread) {
  auto device = falcon();
  ASSERT_TRUE(device->open().ok());
  ASSERT_TRUE(servo(*device, push(Vec3::UnitX()), [&] { return pushes(); }));
  device->safe();
  EXPECT_EQ(usbfs_.sent_at_once, FalconIo::kZeros);
  // An order that the thread had in its hands may still go out; the next one is zero.
  int tick = 0, pushed = 0;
  ASSERT_TRUE(
      servo(*device, push(Vec3::UnitX()), [&] { return (pushed += ++tick > 10 && pushes() ? 1 : 0), tick == 60; }));
  EXPECT_EQ(pushed, 0);
}

// After SIGKILL the kernel has closed all of the daemon's; the motors still hold what they were last told.
TEST_F(Libusb, AFreshProcessBringsAnOrphanToZero) {
  const auto zeros = falcon::encode({});
  falcon::Order order;
  order.motor = {1000, 1000, 1000};
  {
    const auto usb = opener()();
    ASSERT_TRUE(usb.ok());
    (*usb)->sendNow(falcon::encode(order));
  }
  {
    const auto held = usbfs_.hold();
    (void)model_.control({0x40, 3, 2, 0});
    model_.out(falcon::encode(order));
  }
  ASSERT_TRUE(pushes());
  const auto sent = usbfsSendOnce(FakeUsbfs::device(), falcon::kInterface, zeros, 3, 100);
  ASSERT_TRUE(sent.ok()) << toString(sent.error());
  EXPECT_FALSE(pushes());
  const auto owner = opener()();
  ASSERT_TRUE(owner.ok());
  EXPECT_EQ(usbfsSendOnce(FakeUsbfs::device(), falcon::kInterface, zeros, 3, 100).error().code, ErrorCode::kDeviceBusy)
      << "never under the hands of one who lives";
}

}  // namespace
}  // namespace hapticd::test
