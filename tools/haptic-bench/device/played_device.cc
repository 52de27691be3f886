#include "tools/haptic-bench/device/played_device.h"

#include <chrono>

#include "drivers/falcon/falcon_io.h"
#include "drivers/hidpid/hidpid_io.h"
#include "drivers/pantograph/pantograph_io.h"
#include "drivers/sample/sample_io.h"
#include "drivers/spacemouse/spacemouse_io.h"
#include "drivers/woodyhid/woodyhid_io.h"
#include "tools/haptic-emu/falcon/falcon_model.h"
#include "tools/haptic-emu/hidpid/pid_model.h"
#include "tools/haptic-emu/in_process_hid.h"
#include "tools/haptic-emu/in_process_usb.h"
#include "tools/haptic-emu/pantograph/pantograph_model.h"
#include "tools/haptic-emu/sample/sample_model.h"
#include "tools/haptic-emu/spacemouse/spacemouse_model.h"
#include "tools/haptic-emu/woodyhid/woody_hid_model.h"

namespace haptic_bench {
namespace {

using namespace hapticd;  // NOLINT(google-build-using-namespace)

std::int64_t ticks() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

/** While it stands, time is the played device's. */
struct TimedSpan {
  explicit TimedSpan(PlayedCost& of) : cost(of), from_ns(ticks()) {}
  ~TimedSpan() { cost.inside_ns += ticks() - from_ns; }
  PlayedCost& cost;
  std::int64_t from_ns;
};

/** A transport that counts what it takes, without what the driver does when it is told of a transfer. */
class TimedUsb final : public UsbTransport, private UsbListener {
 public:
  TimedUsb(std::unique_ptr<UsbTransport> usb, PlayedCost& cost) : usb_(std::move(usb)), cost_(cost) {}

  UsbStatus control(const UsbControl& request) noexcept override {
    const TimedSpan span(cost_);
    return usb_->control(request);
  }
  UsbStatus postIn() noexcept override {
    const TimedSpan span(cost_);
    return usb_->postIn();
  }
  UsbStatus postOut(std::span<const std::uint8_t> bytes) noexcept override {
    const TimedSpan span(cost_);
    return usb_->postOut(bytes);
  }
  void poll(std::int64_t until_ns, UsbListener& listener) noexcept override {
    const TimedSpan span(cost_);
    listener_ = &listener;
    usb_->poll(until_ns, *this);
  }
  void sendNow(std::span<const std::uint8_t> bytes) noexcept override { usb_->sendNow(bytes); }

 private:
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

class TimedHid final : public HidTransport {
 public:
  TimedHid(std::unique_ptr<HidTransport> hid, PlayedCost& cost) : hid_(std::move(hid)), cost_(cost) {}

  Result<void> open() override { return hid_->open(); }
  void close() noexcept override { hid_->close(); }
  const std::vector<std::uint8_t>& descriptor() const noexcept override { return hid_->descriptor(); }
  HidPlugged plugged() const override { return hid_->plugged(); }
  std::int64_t now() const noexcept override { return hid_->now(); }
  HidResult read(std::span<std::uint8_t> buffer, std::size_t& size, std::int64_t until_ns) noexcept override {
    const TimedSpan span(cost_);
    return hid_->read(buffer, size, until_ns);
  }
  HidResult write(std::span<const std::uint8_t> report) noexcept override {
    const TimedSpan span(cost_);
    return hid_->write(report);
  }
  HidResult setFeature(std::span<const std::uint8_t> report) noexcept override { return hid_->setFeature(report); }
  HidResult getFeature(std::span<std::uint8_t> buffer, std::size_t& size) noexcept override {
    return hid_->getFeature(buffer, size);
  }
  void lastWords(std::span<const std::uint8_t> report) noexcept override { hid_->lastWords(report); }

 private:
  std::unique_ptr<HidTransport> hid_;
  PlayedCost& cost_;
};

class TimedSerial final : public SerialTransport {
 public:
  TimedSerial(std::unique_ptr<SerialTransport> line, PlayedCost& cost) : line_(std::move(line)), cost_(cost) {}

  Result<void> open() override { return line_->open(); }
  void close() noexcept override { line_->close(); }
  std::int64_t now() const noexcept override { return line_->now(); }
  bool read(std::span<std::uint8_t> buffer, std::size_t& size, std::int64_t until_ns) noexcept override {
    const TimedSpan span(cost_);
    return line_->read(buffer, size, until_ns);
  }
  bool write(std::span<const std::uint8_t> bytes) noexcept override {
    const TimedSpan span(cost_);
    return line_->write(bytes);
  }
  void lastWords(std::span<const std::uint8_t> bytes) noexcept override { line_->lastWords(bytes); }

 private:
  std::unique_ptr<SerialTransport> line_;
  PlayedCost& cost_;
};

UsbOpener timed(UsbOpener open, PlayedCost& cost) {
  return [open = std::move(open), &cost]() -> Result<std::unique_ptr<UsbTransport>> {
    auto usb = open();
    if (!usb) return usb;
    return std::unique_ptr<UsbTransport>(std::make_unique<TimedUsb>(std::move(*usb), cost));
  };
}

/** A model and the driver on it. */
template <class Model>
class PlayedModel : public PlayedDevice {
 public:
  template <class... Of>
  explicit PlayedModel(Of... of) : model_(of...) {}
  IoDevice& device() final { return *device_; }
  Vec3 force() const final {
    if constexpr (requires { model_.force(); }) return model_.force();
    return Vec3::Zero();
  }

 protected:
  void serve(std::unique_ptr<DeviceIo> io, bool thread, Clock& clock) {
    device_ = std::make_unique<IoDevice>(std::move(io), IoOptions{.thread = thread}, clock);
  }
  auto timedHid(Clock& clock) {
    return [this, &clock] {
      return std::make_unique<TimedHid>(std::make_unique<haptic_emu::InProcessHid>(model_, clock), cost);
    };
  }

  Model model_;

 private:
  std::unique_ptr<IoDevice> device_;
};

class PlayedFalcon final : public PlayedModel<haptic_emu::FalconModel> {
 public:
  PlayedFalcon(Clock& clock, bool thread) {
    model_.startAt(clock.now());
    model_.warmUp();
    FalconSetup setup = *resolveFalcon({"falcon", "played", {}}, {});
    setup.open_usb = timed(haptic_emu::openInProcess(model_, clock), cost);
    setup.read_firmware = nullptr;
    serve(std::make_unique<FalconIo>(setup, clock), thread, clock);
  }
};

class PlayedSample final : public PlayedModel<haptic_emu::SampleModel> {
 public:
  PlayedSample(Clock& clock, bool thread) {
    model_.startAt(clock.now());
    serve(std::make_unique<SampleIo>(timed(haptic_emu::openInProcess(model_, clock), cost), clock), thread, clock);
  }
};

/** Calibrated before it is opened: in its pose of calibration, its counters set as the firmware is told to. */
class PlayedWoody final : public PlayedModel<haptic_emu::WoodyHidModel> {
 public:
  PlayedWoody(Clock& clock, bool thread) : PlayedModel(haptic_emu::WoodyKind::kWooden2015) {
    WoodySetup setup = *resolveWoody({"woodyhid", "woodenhaptics_v2015", {{"calibrated", "1"}}});
    setup.hid = timedHid(clock);
    std::array<std::int32_t, 6> counts{};
    std::copy(setup.model->calibration.begin(), setup.model->calibration.end(), counts.begin());
    model_.hand.place(solveWoodyArm(*setup.model, woodyAngles(*setup.model, counts)).p);
    model_.advance(clock.now());
    constexpr int kSetCounters = 1;
    std::array<std::int16_t, 7> told{};  // d, e, f; the command; a, b, c.
    for (std::size_t i = 0; i < 3; ++i) {
      told[i] = setup.model->calibration[3 + i];
      told[4 + i] = setup.model->calibration[i];
    }
    told[3] = kSetCounters;
    std::array<std::uint8_t, 64> report{};
    for (std::size_t i = 0; i < told.size(); ++i) {
      report[2 * i] = static_cast<std::uint8_t>(told[i] & 0xFF);
      report[2 * i + 1] = static_cast<std::uint8_t>(static_cast<std::uint16_t>(told[i]) >> 8);
    }
    (void)model_.out(report);
    model_.hand.want({0, 0, 0});
    serve(std::make_unique<WoodyIo>(setup), thread, clock);
  }
};

class PlayedPid final : public PlayedModel<haptic_emu::PidModel> {
 public:
  PlayedPid(Clock& clock, bool thread) {
    HidPidSetup setup = *resolveHidPid({"hidpid", "default", {{"max_force", "4"}}}, {});
    setup.hid = timedHid(clock);
    model_.hand.want({0.01, 0.01, 0});  // It is read when it has moved.
    serve(std::make_unique<HidPidIo>(std::move(setup)), thread, clock);
  }
};

/** Its cap is held aside; it has no motors. */
class PlayedSpaceMouse final : public PlayedModel<haptic_emu::SpaceMouseModel> {
 public:
  PlayedSpaceMouse(Clock& clock, bool thread) : PlayedModel(true) {
    SpaceMouseSetup setup = *resolveSpaceMouse({"spacemouse", "default", {}}, {});
    setup.hid = timedHid(clock);
    model_.push({200, 0, 0, 0, 0, 0});
    serve(std::make_unique<SpaceMouseIo>(std::move(setup)), thread, clock);
  }
};

class PlayedPantograph final : public PlayedModel<haptic_emu::PantographModel> {
 public:
  PlayedPantograph(Clock& clock, bool thread) {
    PantographSetup setup = *resolvePantograph({"pantograph", "/dev/played", {}});
    setup.line = [this, &clock] {
      return std::make_unique<TimedSerial>(std::make_unique<haptic_emu::InProcessSerial>(model_, clock), cost);
    };
    model_.armsOut();
    model_.hand.want({0, 0, 0});  // From there it goes to the middle: straight out the arms lie in a line.
    serve(std::make_unique<PantographIo>(std::move(setup)), thread, clock);
  }
};

}  // namespace

const std::vector<PlayedCase>& playedCases() {
  static const std::vector<PlayedCase> kCases = {
      {"falcon", [](Clock& clock, bool thread) { return std::make_unique<PlayedFalcon>(clock, thread); }},
      {"woodyhid", [](Clock& clock, bool thread) { return std::make_unique<PlayedWoody>(clock, thread); }},
      {"hidpid", [](Clock& clock, bool thread) { return std::make_unique<PlayedPid>(clock, thread); }},
      {"pantograph", [](Clock& clock, bool thread) { return std::make_unique<PlayedPantograph>(clock, thread); }},
      {"spacemouse", [](Clock& clock, bool thread) { return std::make_unique<PlayedSpaceMouse>(clock, thread); }, 120,
       false},
      {"sample", [](Clock& clock, bool thread) { return std::make_unique<PlayedSample>(clock, thread); }},
  };
  return kCases;
}

}  // namespace haptic_bench
