#include "tools/haptic-emu/falcon/falcon_model.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace haptic_emu {
namespace {

constexpr std::uint16_t kLoaderDivisor = 0x4138, kUploadDivisor = 0x0015, kRunDivisor = 0x0002;
constexpr std::uint8_t kModem[2] = {0x31, 0x60};
constexpr std::size_t kMostPayload = 62;
constexpr int kOffset = 700;  ///< What an encoder is off by before homing.

/** Ten bits a byte at 3 MHz / divisor; the chip's code for 9600 baud has a fraction in its high bits. */
std::int64_t byteTime(std::uint16_t divisor) {
  return divisor == kLoaderDivisor ? 1'041'667 : std::int64_t{10} * 1'000'000'000 * divisor / 3'000'000;
}

std::uint8_t letter(int value) { return static_cast<std::uint8_t>('A' + value); }

}  // namespace

FalconModel::FalconModel() : hand(HandParameters{.at = Vec3(0, 0, 0.125)}) {}

void FalconModel::powerUp() {
  mode_ = Mode::kWaiting;
  divisor_ = kLoaderDivisor;
  latency_ns_ = 16'000'000;
  dtr_ = false;
  heard_.clear();
  firmware_.clear();
  said_.clear();
  motors_ = {};
  lights_ = 0;
  homed_ = 0;
  was_far_out_ = false;
}

void FalconModel::warmUp() {
  mode_ = Mode::kRunning;
  homed_ = 7;
}

void FalconModel::advance(std::int64_t t_ns) {
  for (; now_ns_ + Hand::kStep_ns <= t_ns; now_ns_ += Hand::kStep_ns) {
    hand.step(force());
    if ((lights_ & 1) != 0) home();
  }
  if (was_plugged_ && !plugged()) powerUp();
  was_plugged_ = plugged();
}

void FalconModel::home() {
  const double z = hand.position().z();
  was_far_out_ = was_far_out_ || z > kFarOut;
  if (was_far_out_ && z < kInAgain) homed_ = 7;
}

bool FalconModel::control(const hapticd::UsbControl& request) {
  if (request.request_type != 0x40 || request.index != 0) return false;
  switch (request.request) {
    case 0:  // Reset, or purge one way.
      if (request.value > 2) return false;
      if (request.value != 2) said_.clear();
      if (request.value != 1) heard_.clear();
      return true;
    case 1: {  // Modem lines: the high byte says which, the low byte how.
      if ((request.value & 0x0100) == 0) return true;
      const bool up = (request.value & 1) != 0;
      if (up && !dtr_) {
        // The edge resets the processor.
        mode_ = Mode::kWaiting;
        homed_ = 0;
        firmware_.clear();
        motors_ = {};
      }
      dtr_ = up;
      return true;
    }
    case 2:
    case 4:
      return true;
    case 3:
      divisor_ = request.value;
      if (divisor_ == kRunDivisor && mode_ == Mode::kLoading) {
        mode_ = firmware_.size() >= kLeastFirmware ? Mode::kRunning : Mode::kWaiting;
      }
      heard_.clear();
      return true;
    case 9:
      latency_ns_ = std::int64_t{request.value} * 1'000'000;
      return request.value > 0 && request.value < 256;
    default:
      return false;
  }
}

void FalconModel::out(std::span<const std::uint8_t> bytes) {
  for (const std::uint8_t byte : bytes) take(byte);
}

void FalconModel::say(std::span<const std::uint8_t> bytes) {
  std::vector<std::uint8_t> said(bytes.begin(), bytes.end());
  if (faults.active(FaultKind::kSilence, now_ns_)) return;
  if (faults.active(FaultKind::kTruncation, now_ns_)) said.resize(said.size() - 1 - noise_.byte() % said.size());
  if (faults.active(FaultKind::kGarbage, now_ns_)) {
    const auto where = static_cast<std::ptrdiff_t>(noise_.byte() % (said.size() + 1));
    said.insert(said.begin() + where, noise_.byte());
  }
  const std::int64_t ready_ns = now_ns_ + (running() ? 0 : loader_thinks_ns);
  std::int64_t at_ns = std::max(ready_ns, line_free_ns_);
  for (const std::uint8_t byte : said) said_.push_back({at_ns += byteTime(divisor_), byte});
  line_free_ns_ = at_ns;
}

void FalconModel::take(std::uint8_t byte) {
  heard_.push_back(byte);
  const auto ends = [this](std::initializer_list<std::uint8_t> with) {
    return heard_.size() >= with.size() && std::equal(with.begin(), with.end(), heard_.end() - std::ssize(with));
  };
  switch (mode_) {
    case Mode::kWaiting:
      if (divisor_ == kLoaderDivisor && dtr_ && ends({0x0a, 0x43, 0x0d})) {
        constexpr std::uint8_t kAnswer[] = {0x0a, 0x44, 0x2c, 0x0d};
        say(kAnswer);
        mode_ = Mode::kGreeted;
      }
      return;
    case Mode::kGreeted:
      if (divisor_ == kUploadDivisor && !dtr_ && byte == 0x41) {
        say({&byte, 1});
        mode_ = Mode::kLoading;
        ++uploads_;
      }
      return;
    case Mode::kLoading: {
      if (divisor_ != kUploadDivisor) return;
      firmware_.push_back(byte);
      const auto echo = static_cast<std::uint8_t>(faults.active(FaultKind::kWrongEcho, now_ns_) ? byte ^ 0x10 : byte);
      say({&echo, 1});
      return;
    }
    case Mode::kRunning:
      if (divisor_ != kRunDivisor) return;
      while (!heard_.empty() && heard_.front() != '<') heard_.erase(heard_.begin());
      if (heard_.size() < 16) return;
      if (heard_[15] == '>') order();
      heard_.clear();
  }
}

void FalconModel::order() {
  for (std::size_t m = 0; m < 3; ++m) {
    int value = 0;
    for (std::size_t nibble = 0; nibble < 4; ++nibble) value |= (heard_[1 + 4 * m + nibble] - 'A') << (4 * nibble);
    motors_[m] = static_cast<std::int16_t>(value > 32767 ? value - 65536 : value);
    if (!homed()) most_unhomed_ = std::max(most_unhomed_, std::abs(value));
  }
  lights_ = static_cast<std::uint8_t>(heard_[13] - 'A');
  ++orders_;
  reply();
}

void FalconModel::reply() {
  std::uint8_t packet[16] = {'<'};
  Vec3 counts = falconCounts(hand.position());
  if (!homed()) counts += Vec3::Constant(kOffset);
  if (faults.active(FaultKind::kEncoderJump, now_ns_)) counts.x() += 6000;
  for (int leg = 0; leg < 3; ++leg) {
    const double bounded = std::isfinite(counts[leg]) ? std::clamp(counts[leg], -32768.0, 32767.0) : 32767.0;
    const long value = std::lround(bounded) & 0xffff;
    for (int nibble = 0; nibble < 4; ++nibble) packet[1 + 4 * leg + nibble] = letter(value >> (4 * nibble) & 15);
  }
  packet[13] = letter((buttons & 15) | homed_ << 4);
  packet[14] = 'A';
  packet[15] = '>';
  say(packet);
}

std::optional<std::vector<std::uint8_t>> FalconModel::in(std::size_t most) {
  const std::size_t room = std::min(most, kMostPayload + 2) - 2;
  std::size_t ready = 0;
  while (ready < said_.size() && ready < room && said_[ready].at_ns <= now_ns_) ++ready;
  // The chip answers when a packet is full or its timer has run out, with nothing if there is nothing.
  if (ready < room && now_ns_ - last_in_ns_ < latency_ns_) return {};
  last_in_ns_ = now_ns_;
  std::vector<std::uint8_t> packet(std::begin(kModem), std::end(kModem));
  for (; ready > 0; --ready, said_.pop_front()) packet.push_back(said_.front().byte);
  return packet;
}

}  // namespace haptic_emu
