#include "tools/haptic-emu/usbip.h"

#include <algorithm>
#include <cerrno>

namespace haptic_emu {
namespace {

constexpr std::uint32_t kSubmit = 1, kUnlink = 2, kReplySubmit = 3, kReplyUnlink = 4;
constexpr std::uint32_t kDirectionIn = 1;

std::uint32_t wordAt(std::span<const std::uint8_t> message, std::size_t index) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value = value << 8 | message[4 * index + i];
  return value;
}

void putWord(std::uint32_t value, std::vector<std::uint8_t>& out) {
  for (int shift = 24; shift >= 0; shift -= 8) out.push_back(static_cast<std::uint8_t>(value >> shift));
}

}  // namespace

bool UsbIp::whole(std::size_t& length) const {
  length = 0;
  if (in_.size() < kHeader) return true;
  const std::uint32_t command = wordAt(in_, 0);
  if (command != kSubmit && command != kUnlink) return false;
  std::size_t wanted = kHeader;
  if (command == kSubmit) {
    const std::uint32_t bytes = wordAt(in_, 6);
    if (bytes > kMostBytes) return false;
    if (wordAt(in_, 3) != kDirectionIn) wanted += bytes;
  }
  if (in_.size() >= wanted) length = wanted;
  return true;
}

bool UsbIp::feed(std::span<const std::uint8_t> bytes) {
  in_.insert(in_.end(), bytes.begin(), bytes.end());
  for (std::size_t length = 0;;) {
    if (!whole(length)) return false;
    if (length == 0) return true;
    const std::vector<std::uint8_t> message(in_.begin(), in_.begin() + static_cast<std::ptrdiff_t>(length));
    in_.erase(in_.begin(), in_.begin() + static_cast<std::ptrdiff_t>(length));
    if (wordAt(message, 0) == kUnlink) {
      unlink(message);
    } else if (!submit(message)) {
      return false;
    }
  }
}

bool UsbIp::submit(std::span<const std::uint8_t> message) {
  const std::uint32_t sequence = wordAt(message, 1), endpoint = wordAt(message, 4), length = wordAt(message, 6);
  const bool in = wordAt(message, 3) == kDirectionIn;
  if (!model_.plugged()) {
    reply(sequence, -ESHUTDOWN, {}, 0);
    return true;
  }
  const UsbIdentity who = model_.identity();
  if (endpoint == 0) {
    const auto setup = message.subspan(40, 8);
    const auto pair = [&](std::size_t i) { return static_cast<std::uint16_t>(setup[i] | setup[i + 1] << 8); };
    control(sequence, {setup[0], setup[1], pair(2), pair(4), pair(6)}, in, length);
  } else if (in && endpoint == (who.in & 0x7fu)) {
    if (asked_.size() == kMostAsked) return false;
    asked_.push_back({sequence, length});
    match();
  } else if (!in && endpoint == who.out) {
    model_.out(message.subspan(kHeader));
    reply(sequence, 0, {}, length);
    match();
  } else {
    reply(sequence, -EPIPE, {}, 0);
  }
  return true;
}

void UsbIp::control(std::uint32_t sequence, const UsbSetup& setup, bool in, std::uint32_t length) {
  if (const auto answer = answerStandard(model_.identity(), setup)) {
    const auto size = std::min<std::size_t>(answer->size(), length);
    reply(sequence, 0, in ? std::span(*answer).first(size) : std::span<const std::uint8_t>{},
          in ? static_cast<std::uint32_t>(size) : length);
    return;
  }
  const bool done = !in && model_.control({setup.request_type, setup.request, setup.value, setup.index});
  reply(sequence, done ? 0 : -EPIPE, {}, done ? length : 0);
}

void UsbIp::unlink(std::span<const std::uint8_t> message) {
  const std::uint32_t sequence = wordAt(message, 1), victim = wordAt(message, 5);
  const auto at = std::find_if(asked_.begin(), asked_.end(), [=](const Asked& a) { return a.sequence == victim; });
  const bool found = at != asked_.end();
  if (found) asked_.erase(at);
  putWord(kReplyUnlink, out_);
  putWord(sequence, out_);
  for (int i = 0; i < 3; ++i) putWord(0, out_);
  putWord(static_cast<std::uint32_t>(found ? -ECONNRESET : 0), out_);
  out_.resize(out_.size() + 24);
}

void UsbIp::reply(std::uint32_t sequence, std::int32_t status, std::span<const std::uint8_t> data,
                  std::uint32_t actual) {
  putWord(kReplySubmit, out_);
  putWord(sequence, out_);
  for (int i = 0; i < 3; ++i) putWord(0, out_);
  putWord(static_cast<std::uint32_t>(status), out_);
  putWord(actual, out_);
  out_.resize(out_.size() + 20);
  out_.insert(out_.end(), data.begin(), data.end());
}

void UsbIp::match() {
  while (!asked_.empty()) {
    const auto packet = model_.in(std::min<std::uint32_t>(asked_.front().length, model_.identity().packet_bytes));
    if (!packet) return;
    const auto size = std::min<std::size_t>(packet->size(), asked_.front().length);
    reply(asked_.front().sequence, 0, std::span(*packet).first(size), static_cast<std::uint32_t>(size));
    asked_.pop_front();
  }
}

void UsbIp::advance(std::int64_t t_ns) {
  model_.advance(t_ns);
  if (model_.plugged()) match();
}

std::vector<std::uint8_t> UsbIp::take() {
  std::vector<std::uint8_t> bytes;
  bytes.swap(out_);
  return bytes;
}

}  // namespace haptic_emu
