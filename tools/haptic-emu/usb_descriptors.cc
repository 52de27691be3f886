#include "tools/haptic-emu/usb_descriptors.h"

#include <algorithm>

namespace haptic_emu {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr std::uint8_t kDevice = 1, kConfiguration = 2, kString = 3;
constexpr std::uint8_t kVendorClass = 0xff;

std::uint8_t low(std::uint16_t value) { return static_cast<std::uint8_t>(value & 0xff); }
std::uint8_t high(std::uint16_t value) { return static_cast<std::uint8_t>(value >> 8); }

Bytes deviceDescriptor(const UsbIdentity& who) {
  return {18,
          kDevice,
          0x00,
          0x02,
          0,
          0,
          0,
          8,
          low(who.vendor),
          high(who.vendor),
          low(who.product),
          high(who.product),
          low(who.version),
          high(who.version),
          1,
          2,
          3,
          1};
}

Bytes configurationDescriptor(const UsbIdentity& who) {
  Bytes out{9, kConfiguration, 32, 0, 1, 1, 0, 0x80, 50};
  const Bytes interface { 9, 4, 0, 0, 2, kVendorClass, kVendorClass, kVendorClass, 2 };
  const Bytes in{7, 5, who.in, 2, who.packet_bytes, 0, 0}, to{7, 5, who.out, 2, who.packet_bytes, 0, 0};
  for (const Bytes* part : {&interface, &in, &to}) out.insert(out.end(), part->begin(), part->end());
  return out;
}

std::optional<Bytes> stringDescriptor(const UsbIdentity& who, std::uint8_t index) {
  if (index == 0) return Bytes{4, kString, 0x09, 0x04};  // English.
  if (index > 3) return {};
  const std::string& text = index == 1 ? who.manufacturer : index == 2 ? who.name : who.serial;
  Bytes out{static_cast<std::uint8_t>(2 + 2 * std::min<std::size_t>(text.size(), 100)), kString};
  for (const char c : text.substr(0, 100)) out.insert(out.end(), {static_cast<std::uint8_t>(c), 0});
  return out;
}

std::optional<Bytes> descriptor(const UsbIdentity& who, std::uint16_t value) {
  switch (high(value)) {
    case kDevice:
      return deviceDescriptor(who);
    case kConfiguration:
      return configurationDescriptor(who);
    case kString:
      return stringDescriptor(who, low(value));
    default:
      return {};
  }
}

}  // namespace

std::optional<std::vector<std::uint8_t>> answerStandard(const UsbIdentity& who, const UsbSetup& setup) {
  if ((setup.request_type & 0x60) != 0) return {};  // Of a class or a vendor.
  std::optional<Bytes> answer;
  switch (setup.request) {
    case 0:  // Status: powered by the bus, no endpoint halted.
      answer = Bytes{0, 0};
      break;
    case 6:
      answer = descriptor(who, setup.value);
      break;
    case 8:
      answer = Bytes{1};
      break;
    case 10:
      answer = Bytes{0};
      break;
    case 1:   // Clear feature,
    case 3:   // set feature,
    case 5:   // address,
    case 9:   // configuration,
    case 11:  // interface: nothing to say.
      answer = Bytes{};
      break;
    default:
      break;
  }
  if (answer && answer->size() > setup.length) answer->resize(setup.length);
  return answer;
}

}  // namespace haptic_emu
