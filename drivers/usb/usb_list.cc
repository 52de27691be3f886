#include "drivers/usb/usb_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>

#include "drivers/number.h"

namespace hapticd {
namespace {

namespace fs = std::filesystem;

/** The first line of a sysfs attribute without control characters; "" when there is none. */
std::string attribute(const fs::path& device, const char* name) {
  std::ifstream file(device / name);
  std::string line;
  std::getline(file, line);
  std::erase_if(line, [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; });
  return std::string(trimmed(line.substr(0, 256)));
}

bool parseHex(const std::string& text, std::uint16_t& value) {
  const char* end = text.data() + text.size();
  const auto [at, error] = std::from_chars(text.data(), end, value, 16);
  return error == std::errc() && at == end;
}

}  // namespace

std::string UsbFound::node() const { return fmt::format("/dev/bus/usb/{:03}/{:03}", bus, address); }

std::vector<UsbFound> findUsb(std::uint16_t vendor, std::uint16_t product, std::string_view folder) {
  std::vector<UsbFound> found;
  std::error_code unreadable;
  for (fs::directory_iterator entry(fs::path(folder), unreadable), end; !unreadable && entry != end;
       entry.increment(unreadable)) {
    const fs::path& path = entry->path();
    UsbFound device;
    // Interfaces ("1-2:1.0") have no idVendor.
    if (!parseHex(attribute(path, "idVendor"), device.vendor) || device.vendor != vendor) continue;
    if (!parseHex(attribute(path, "idProduct"), device.product) || device.product != product) continue;
    const auto bus = parseInteger(attribute(path, "busnum")), address = parseInteger(attribute(path, "devnum"));
    if (!bus || !address || *bus > 999 || *address > 999) continue;  // It is just going away.
    device.bus = static_cast<std::uint32_t>(*bus);
    device.address = static_cast<std::uint32_t>(*address);
    device.path = path.filename().string();
    device.serial = attribute(path, "serial");
    device.manufacturer = attribute(path, "manufacturer");
    device.name = attribute(path, "product");
    found.push_back(std::move(device));
  }
  std::sort(found.begin(), found.end(), [](const UsbFound& a, const UsbFound& b) { return a.path < b.path; });
  return found;
}

Result<UsbFound> chooseUsb(const std::vector<UsbFound>& found, std::string_view which, std::string_view what) {
  const bool any = which.empty() || which == "default";
  std::vector<std::string> there;
  for (const UsbFound& device : found) {
    if (any || device.path == which || (!device.serial.empty() && device.serial == which)) return device;
    there.push_back(device.serial.empty() ? device.path : fmt::format("{} ({})", device.serial, device.path));
  }
  const std::string where = any ? std::string(what) : fmt::format("{} \"{}\"", what, which.substr(0, 80));
  if (there.empty()) {
    return Error{ErrorCode::kNotFound, where, fmt::format("no {} is plugged in", what),
                 "plug it in and switch it on; lsusb shows what the kernel sees"};
  }
  return Error{ErrorCode::kNotFound, where, "no such serial number or path",
               fmt::format("there are {}", fmt::join(there, ", "))};
}

std::string usbInterfaceDriver(const UsbFound& device, std::uint8_t number, std::string_view folder) {
  std::error_code none;
  // Configuration 1: the devices we drive have no other.
  const fs::path link = fs::path(folder) / fmt::format("{}:1.{}", device.path, number) / "driver";
  return fs::read_symlink(link, none).filename().string();
}

}  // namespace hapticd
