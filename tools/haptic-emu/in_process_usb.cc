#include "tools/haptic-emu/in_process_usb.h"

#include <algorithm>
#include <deque>
#include <memory>
#include <utility>
#include <vector>

namespace haptic_emu {
namespace {

using hapticd::UsbControl;
using hapticd::UsbListener;
using hapticd::UsbStatus;

constexpr std::int64_t kTick_ns = 62'500;  ///< Half a microframe: the grain of the bus.
constexpr std::size_t kPacket = 64;

class InProcessUsb final : public hapticd::UsbTransport {
 public:
  InProcessUsb(UsbModel& model, hapticd::Clock& clock, std::shared_ptr<bool> taken)
      : model_(model), clock_(clock), taken_(std::move(taken)) {
    *taken_ = true;
  }
  ~InProcessUsb() override { *taken_ = false; }

  UsbStatus control(const UsbControl& request) noexcept override {
    clock_.sleepUntil(clock_.now() + 2 * kTick_ns);
    model_.advance(clock_.now());
    if (!model_.plugged()) return UsbStatus::kGone;
    return model_.control(request) ? UsbStatus::kOk : UsbStatus::kStall;
  }
  UsbStatus postIn() noexcept override {
    if (!model_.plugged()) return UsbStatus::kGone;
    if (in_ == kMostPending) return UsbStatus::kError;
    ++in_;
    return UsbStatus::kOk;
  }
  UsbStatus postOut(std::span<const std::uint8_t> bytes) noexcept override {
    if (!model_.plugged()) return UsbStatus::kGone;
    if (out_.size() == kMostPending || bytes.size() > kPacket) return UsbStatus::kError;
    out_.push_back({clock_.now() + kTick_ns, {bytes.begin(), bytes.end()}});
    return UsbStatus::kOk;
  }

  void poll(std::int64_t until_ns, UsbListener& listener) noexcept override {
    bool ended = false;
    for (;;) {
      model_.advance(clock_.now());
      ended = deliver(listener);
      if (ended || clock_.now() >= until_ns) return;
      clock_.sleepUntil(std::min(until_ns, (clock_.now() / kTick_ns + 1) * kTick_ns));
    }
  }

  void sendNow(std::span<const std::uint8_t> bytes) noexcept override {
    if (!model_.plugged()) return;
    // What is under way on the endpoint goes first, as on the bus; its end is told in its time.
    for (Out& out : out_) hand(out);
    model_.out(bytes);
  }

 private:
  struct Out {
    std::int64_t at_ns;
    std::vector<std::uint8_t> bytes;
    bool handed = false;  ///< To the model.
  };

  void hand(Out& out) {
    if (!std::exchange(out.handed, true)) model_.out(out.bytes);
  }

  /** Told at least one end. */
  bool deliver(UsbListener& listener) {
    bool ended = false;
    if (!model_.plugged()) {
      for (; in_ > 0; --in_, ended = true) listener.onIn(UsbStatus::kGone, {});
      for (; !out_.empty(); out_.pop_front(), ended = true) listener.onOut(UsbStatus::kGone);
      return ended;
    }
    while (!out_.empty() && out_.front().at_ns <= clock_.now()) {
      hand(out_.front());
      out_.pop_front();
      listener.onOut(UsbStatus::kOk);
      ended = true;
    }
    // One packet a tick: more does not fit on a full-speed bus beside the rest.
    if (in_ == 0) return ended;
    const auto bytes = model_.in(kPacket);
    if (!bytes) return ended;
    --in_;
    listener.onIn(UsbStatus::kOk, *bytes);
    return true;
  }

  UsbModel& model_;
  hapticd::Clock& clock_;
  std::shared_ptr<bool> taken_;
  std::size_t in_ = 0;
  std::deque<Out> out_;
};

}  // namespace

hapticd::UsbOpener openInProcess(UsbModel& model, hapticd::Clock& clock) {
  auto taken = std::make_shared<bool>(false);
  return [&model, &clock, taken]() -> hapticd::Result<std::unique_ptr<hapticd::UsbTransport>> {
    model.advance(clock.now());
    if (!model.plugged()) {
      return hapticd::Error{hapticd::ErrorCode::kDeviceGone, "played device", "it is unplugged", "plug it in"};
    }
    if (*taken) {
      return hapticd::Error{hapticd::ErrorCode::kDeviceBusy, "played device", "another program owns it", "end that"};
    }
    return std::unique_ptr<hapticd::UsbTransport>(std::make_unique<InProcessUsb>(model, clock, taken));
  };
}

}  // namespace haptic_emu
