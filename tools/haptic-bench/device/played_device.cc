#include "tools/haptic-bench/device/played_device.h"

#include <chrono>

#include "drivers/falcon/falcon_io.h"
#include "drivers/sample/sample_io.h"
#include "tools/haptic-emu/falcon/falcon_model.h"
#include "tools/haptic-emu/in_process_usb.h"
#include "tools/haptic-emu/sample/sample_model.h"

namespace haptic_bench {
namespace {

using namespace hapticd;

std::int64_t ticks() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

/** A transport that counts what it takes, without what the driver does when it is told of a transfer. */
class TimedUsb final : public UsbTransport, private UsbListener {
 public:
  TimedUsb(std::unique_ptr<UsbTransport> usb, PlayedCost& cost) : usb_(std::move(usb)), cost_(cost) {}

  UsbStatus control(const UsbControl& request) noexcept override {
    const Span span(cost_);
    return usb_->control(request);
  }
  UsbStatus postIn() noexcept override {
    const Span span(cost_);
    return usb_->postIn();
  }
  UsbStatus postOut(std::span<const std::uint8_t> bytes) noexcept override {
    const Span span(cost_);
    return usb_->postOut(bytes);
  }
  void poll(std::int64_t until_ns, UsbListener& listener) noexcept override {
    const Span span(cost_);
    listener_ = &listener;
    usb_->poll(until_ns, *this);
  }
  void sendNow(std::span<const std::uint8_t> bytes) noexcept override { usb_->sendNow(bytes); }

 private:
  struct Span {
    explicit Span(PlayedCost& of) : cost(of), from_ns(ticks()) {}
    ~Span() { cost.inside_ns += ticks() - from_ns; }
    PlayedCost& cost;
    std::int64_t from_ns;
  };
  void onIn(UsbStatus status, std::span<const std::uint8_t> bytes) noexcept override {
    const std::int64_t from_ns = ticks();
    listener_->onIn(status, bytes);
    cost_.inside_ns -= ticks() - from_ns;
  }
  void onOut(UsbStatus status) noexcept override {
    const std::int64_t from_ns = ticks();
    listener_->onOut(status);
    cost_.inside_ns -= ticks() - from_ns;
  }

  std::unique_ptr<UsbTransport> usb_;
  PlayedCost& cost_;
  UsbListener* listener_ = nullptr;
};

UsbOpener timed(UsbOpener open, PlayedCost& cost) {
  return [open = std::move(open), &cost]() -> Result<std::unique_ptr<UsbTransport>> {
    auto usb = open();
    if (!usb) return usb;
    return std::unique_ptr<UsbTransport>(std::make_unique<TimedUsb>(std::move(*usb), cost));
  };
}

class PlayedFalcon final : public PlayedDevice {
 public:
  PlayedFalcon(Clock& clock, bool thread) {
    model_.startAt(clock.now());
    model_.warmUp();
    FalconSetup setup = *resolveFalcon({"falcon", "played", {}}, {});
    setup.open_usb = timed(haptic_emu::openInProcess(model_, clock), cost);
    setup.read_firmware = nullptr;
    device_ = std::make_unique<IoDevice>(std::make_unique<FalconIo>(setup, clock), IoOptions{.thread = thread}, clock);
  }
  IoDevice& device() override { return *device_; }
  Vec3 force() const override { return model_.force(); }

 private:
  haptic_emu::FalconModel model_;
  std::unique_ptr<IoDevice> device_;
};

class PlayedSample final : public PlayedDevice {
 public:
  PlayedSample(Clock& clock, bool thread) {
    model_.startAt(clock.now());
    device_ = std::make_unique<IoDevice>(
        std::make_unique<SampleIo>(timed(haptic_emu::openInProcess(model_, clock), cost), clock),
        IoOptions{.thread = thread}, clock);
  }
  IoDevice& device() override { return *device_; }
  Vec3 force() const override { return model_.force(); }

 private:
  haptic_emu::SampleModel model_;
  std::unique_ptr<IoDevice> device_;
};

}  // namespace

const std::vector<PlayedCase>& playedCases() {
  static const std::vector<PlayedCase> kCases = {
      {"falcon", [](Clock& clock, bool thread) { return std::make_unique<PlayedFalcon>(clock, thread); }},
      {"sample", [](Clock& clock, bool thread) { return std::make_unique<PlayedSample>(clock, thread); }},
  };
  return kCases;
}

}  // namespace haptic_bench
