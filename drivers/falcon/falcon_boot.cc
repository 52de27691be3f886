#include "drivers/falcon/falcon_boot.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "drivers/falcon/falcon_protocol.h"

namespace hapticd::falcon {
namespace {

constexpr std::int64_t kMs = 1'000'000;
constexpr int kMostLoads = 10;
constexpr std::int64_t kMostTime_ns = 10'000 * kMs;

Error failed(UsbStatus status, std::string during) {
  const bool gone = status == UsbStatus::kGone;
  return {gone ? ErrorCode::kDeviceGone : ErrorCode::kSystem, "Falcon, " + std::move(during),
          std::string(describe(status)), gone ? "plug it in again" : "plug it out and in again"};
}

/** Bytes to and from the device, one after the other. */
class Talk final : public UsbListener {
 public:
  Talk(UsbTransport& usb, Clock& clock, const std::atomic<bool>& stop)
      : usb_(usb), clock_(clock), stop_(stop), end_ns_(clock.now() + kMostTime_ns) {}

  /** Lets what it asked for end, so that nobody else gets its answers. */
  [[nodiscard]] bool over() const { return stop_.load(std::memory_order_relaxed) || clock_.now() >= end_ns_; }
  [[nodiscard]] Error why(std::string during) const {
    if (broken_ != UsbStatus::kOk) return failed(broken_, std::move(during));
    if (stop_.load(std::memory_order_relaxed)) return {ErrorCode::kCancelled, "Falcon", "it was closed meanwhile", ""};
    return {ErrorCode::kTimeout, "Falcon, " + std::move(during), "it does not answer as it should",
            "check its power supply, then plug it out and in again"};
  }
  [[nodiscard]] bool broken() const { return broken_ != UsbStatus::kOk; }

  template <std::size_t N>
  bool set(const std::array<UsbControl, N>& requests) {
    for (const UsbControl& request : requests) {
      if (broken()) return false;
      const UsbStatus status = usb_.control(request);
      if (status != UsbStatus::kOk) broken_ = status;
    }
    came_.clear();
    return !broken();
  }

  /** Sends, then waits until `done(what came since)` or `wait_ns` passed. */
  template <class Done>
  bool ask(std::span<const std::uint8_t> bytes, std::int64_t wait_ns, Done done) {
    came_.clear();
    listen();
    if (const UsbStatus status = usb_.postOut(bytes); status != UsbStatus::kOk) broken_ = status;
    const std::int64_t until_ns = std::min(end_ns_, clock_.now() + wait_ns);
    while (!broken() && !stop_.load(std::memory_order_relaxed)) {
      if (done(came_)) return true;
      if (clock_.now() >= until_ns) return false;
      listen();
      usb_.poll(until_ns, *this);
    }
    return false;
  }

  void onIn(UsbStatus status, std::span<const std::uint8_t> bytes) noexcept override {
    --listening_;
    if (status != UsbStatus::kOk && status != UsbStatus::kTimeout) broken_ = status;
    const auto what = payload(bytes);
    if (came_.size() < 4096) came_.insert(came_.end(), what.begin(), what.end());
  }
  void onOut(UsbStatus status) noexcept override {
    if (status != UsbStatus::kOk) broken_ = status;
  }

 private:
  void listen() {
    while (listening_ < 2 && !broken()) {
      const UsbStatus status = usb_.postIn();
      if (status == UsbStatus::kGone) broken_ = status;
      if (status != UsbStatus::kOk) return;
      ++listening_;
    }
  }

  UsbTransport& usb_;
  Clock& clock_;
  const std::atomic<bool>& stop_;
  std::int64_t end_ns_;
  int listening_ = 0;
  UsbStatus broken_ = UsbStatus::kOk;
  std::vector<std::uint8_t> came_;
};

using Bytes = std::vector<std::uint8_t>;

/** Does it answer run packets? */
bool runs(Talk& talk) {
  for (int attempt = 0; attempt < 10 && !talk.over(); ++attempt) {
    if (!talk.set(kToRun)) return false;
    Parser parser;
    std::size_t fed = 0;
    Reading reading;
    const auto answered = [&](const Bytes& came) {
      parser.feed(std::span(came).subspan(fed));
      fed = came.size();
      return parser.next(reading);
    };
    if (talk.ask(encode({}), 20 * kMs, answered)) return true;
    if (talk.broken()) return false;
  }
  return false;
}

bool saysHello(Talk& talk) {
  if (!talk.set(kToLoader)) return false;
  for (int attempt = 0; attempt < 100 && !talk.over() && !talk.broken(); ++attempt) {
    const auto answered = [](const Bytes& came) {
      return std::search(came.begin(), came.end(), kHelloAnswer.begin(), kHelloAnswer.end()) != came.end();
    };
    if (talk.ask(kHello, 40 * kMs, answered)) return true;
  }
  return false;
}

/** One attempt; `step` tells how far it came. */
bool load(Talk& talk, std::span<const std::uint8_t> firmware, std::string& step) {
  step = "greeting its loader";
  if (!saysHello(talk)) return false;
  step = "preparing the upload";
  if (!talk.set(kToUpload)) return false;
  if (!talk.ask(kReady, 200 * kMs, [](const Bytes& came) { return !came.empty() && came[0] == kReady[0]; })) {
    return false;
  }
  for (std::size_t at = 0; at < firmware.size(); at += kChunk) {
    const auto chunk = firmware.subspan(at, std::min(kChunk, firmware.size() - at));
    step = fmt::format("echo of firmware byte {} of {}", at, firmware.size());
    const auto echoed = [&](const Bytes& came) { return came.size() >= chunk.size(); };
    bool same = false;
    if (talk.ask(chunk, 200 * kMs,
                 [&](const Bytes& came) {
                   same = echoed(came) && std::equal(chunk.begin(), chunk.end(), came.begin(), came.end());
                   return echoed(came);
                 }) &&
        same) {
      continue;
    }
    return false;
  }
  step = "start of the firmware";
  return runs(talk);
}

}  // namespace

Result<void> boot(UsbTransport& usb, Clock& clock, std::span<const std::uint8_t> firmware,
                  const std::atomic<bool>& stop) {
  Talk talk(usb, clock, stop);
  if (runs(talk)) return {};
  if (talk.broken() || talk.over()) return talk.why("looking whether its firmware runs");
  if (firmware.empty()) {
    return Error{ErrorCode::kNotFound, "Falcon", "it needs its firmware, and there is none",
                 "Novint's firmware is not ours to ship: take novint_T2.bin or nvent_firmware.bin from libnifalcon or "
                 "Novint's SDK, put it at /var/lib/hapticd/falcon.bin or name it, falcon://default?firmware=/path"};
  }
  std::string step;
  for (int attempt = 0; attempt < kMostLoads && !talk.over(); ++attempt) {
    if (load(talk, firmware, step)) return {};
    if (talk.broken()) break;
  }
  return talk.why(step);
}

}  // namespace hapticd::falcon
