#include "drivers/hid/enumerate.h"

#include <fmt/format.h>
#include <hidapi/hidapi.h>

#include <cstdio>
#include <filesystem>
#include <memory>

namespace hapticd {
namespace {

/** Without the locale: device strings are UTF-16 from the wire, widened; anything else becomes '?'. */
std::string utf8(const wchar_t* text) {
  std::string out;
  for (; text != nullptr && *text != 0 && out.size() < 200; ++text) {
    const auto c = static_cast<std::uint32_t>(*text);  // NOLINT(bugprone-signed-char-misuse)
    if (c < 0x20 || c == 0x7f || c > 0xffff || (c >= 0xd800 && c < 0xe000)) {
      out += '?';
    } else if (c < 0x80) {
      out += static_cast<char>(c);
    } else if (c < 0x800) {
      out += static_cast<char>(0xc0 | (c >> 6));
      out += static_cast<char>(0x80 | (c & 0x3f));
    } else {
      out += static_cast<char>(0xe0 | (c >> 12));
      out += static_cast<char>(0x80 | ((c >> 6) & 0x3f));
      out += static_cast<char>(0x80 | (c & 0x3f));
    }
  }
  return out;
}

std::string deviceFolderOf(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  return "/sys/class/hidraw/" + (slash == std::string::npos ? path : path.substr(slash + 1)) + "/device";
}

/** Of a node, without opening it. */
std::vector<std::uint8_t> reportDescriptorOf(const std::string& path) {
  constexpr std::size_t kLargest = 4096;  // HID_MAX_DESCRIPTOR_SIZE of the kernel.
  const std::string file = deviceFolderOf(path) + "/report_descriptor";
  std::vector<std::uint8_t> bytes(kLargest);
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> in(std::fopen(file.c_str(), "rbe"), &std::fclose);
  bytes.resize(in ? std::fread(bytes.data(), 1, bytes.size(), in.get()) : 0);
  return bytes;
}

bool isSame(const HidFound& was, const HidFound& now) {
  const bool alike = was.vendor == now.vendor && was.product == now.product && was.serial == now.serial;
  if (!alike || !now.serial.empty()) return alike;
  return was.manufacturer == now.manufacturer && was.name == now.name && was.socket == now.socket;
}

/** What programs bring, as that of Bluetooth does, all has one. */
bool isPlaceOfOne(const std::string& socket) {
  return !socket.empty() && socket.find("/devices/virtual/") == std::string::npos;
}

}  // namespace

std::mutex& hidapiLock() {
  static std::mutex lock;
  return lock;
}

std::vector<HidFound> findHid() {
  const std::lock_guard lock(hidapiLock());
  const std::unique_ptr<hid_device_info, void (*)(hid_device_info*)> list(hid_enumerate(0, 0), &hid_free_enumeration);
  std::vector<HidFound> found;
  for (const hid_device_info* at = list.get(); at != nullptr; at = at->next) {
    const std::string path = at->path == nullptr ? "" : at->path;
    // hidapi lists a node once for each usage, one after the other.
    if (!found.empty() && found.back().path == path) continue;
    HidFound& one = found.emplace_back();
    one.path = path;
    one.vendor = at->vendor_id;
    one.product = at->product_id;
    one.serial = utf8(at->serial_number);
    one.manufacturer = utf8(at->manufacturer_string);
    one.name = utf8(at->product_string);
    one.usage_page = at->usage_page;
    std::error_code unknown;
    const std::filesystem::path device = std::filesystem::canonical(deviceFolderOf(path), unknown);
    one.instance = device.filename().string();
    one.socket = device.parent_path().string();
    one.descriptor = reportDescriptorOf(path);
  }
  return found;
}

Result<HidFound> choose(const std::vector<HidFound>& found, const HidWanted& wanted) {
  std::string there;
  bool another = false;
  // At a replug the kernel may have given its node another number: then its socket tells it.
  enum : std::uint8_t { kNone, kNamed, kInPlace, kBoth } best = kNone;
  const HidFound* chosen = nullptr;
  for (const HidFound& one : found) {
    if (wanted.fits && !wanted.fits(one)) continue;
    const bool meant =
        (wanted.path.empty() || wanted.path == one.path) && (wanted.serial.empty() || wanted.serial == one.serial);
    const bool same = !wanted.same || isSame(*wanted.same, one);
    const bool in_place = wanted.same && isPlaceOfOne(one.socket) && one.socket == wanted.same->socket;
    const auto fit = !same ? kNone : meant ? (in_place ? kBoth : kNamed) : in_place ? kInPlace : kNone;
    if (fit > best) {
      best = fit;
      chosen = &one;
    }
    another = another || meant;
    there += fmt::format("{}{} ({})", there.empty() ? "" : ", ", one.path, one.serial);
  }
  if (chosen != nullptr) return *chosen;
  if (another) {
    return Error{ErrorCode::kNotFound, "HID devices",
                 fmt::format("another stands in the place of {}: there are {}", wanted.what, there),
                 wanted.same->serial.empty() ? "plug in the one that was, into the socket where it was"
                                             : "plug in the one that was, of serial number " + wanted.same->serial};
  }
  const std::string which = !wanted.path.empty()     ? " at " + wanted.path
                            : !wanted.serial.empty() ? " of serial number " + wanted.serial
                                                     : "";
  return Error{ErrorCode::kNotFound, "HID devices", fmt::format("{}{} is not plugged in", wanted.what, which),
               there.empty() ? "plug it in; lsusb lists what the kernel sees" : "there are " + there};
}

}  // namespace hapticd
