#include "drivers/falcon/falcon_driver.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>

#include "drivers/falcon/falcon_io.h"
#include "drivers/link/io_device.h"
#include "drivers/usb/libusb_transport.h"
#include "drivers/usb/usbfs.h"

namespace hapticd {
namespace {

constexpr std::uint32_t kZeroTimeout_ms = 100;
constexpr std::size_t kMostFirmware = 64 * 1024;

std::vector<UsbFound> falconsPlugged() { return findUsb(falcon::kVendor, falcon::kProduct); }

/** Those who have its serial number, itself too. */
std::ptrdiff_t namesakes(const std::string& serial, const std::vector<UsbFound>& plugged) {
  return std::count_if(plugged.begin(), plugged.end(), [&](const UsbFound& d) { return d.serial == serial; });
}

std::string nameOf(const UsbFound& device, const std::vector<UsbFound>& plugged) {
  return device.serial.empty() || namesakes(device.serial, plugged) > 1 ? device.path : device.serial;
}

Result<std::unique_ptr<Device>> make(const DeviceUri& uri) {
  static MonotonicClock clock;
  return makeIoDevice<FalconIo>(resolveFalcon(uri, falconsPlugged()), clock);
}

void find(std::vector<DeviceFound>& found) {
  const auto devices = falconsPlugged();
  for (const UsbFound& device : devices) {
    auto setup = resolveFalcon({"falcon", nameOf(device, devices), {}}, devices);
    if (setup) found.push_back({std::move(setup->info), true});
  }
}

Result<void> zero(const DeviceUri& uri) {
  const auto plugged = falconsPlugged();
  const auto meant = falconsMeant(uri.authority, plugged);
  if (meant.empty()) return chooseUsb(plugged, uri.authority, "Novint Falcon").error();
  Result<void> all;
  for (const UsbFound& device : meant) {
    const auto sent = usbfsSendOnce(device, falcon::kInterface, falcon::encode({}), FalconIo::kZeros, kZeroTimeout_ms);
    if (!sent) all = sent;
  }
  return all;
}

}  // namespace

std::vector<UsbFound> falconsMeant(const std::string& name, const std::vector<UsbFound>& plugged) {
  std::vector<UsbFound> meant;
  std::copy_if(plugged.begin(), plugged.end(), std::back_inserter(meant),
               [&](const UsbFound& one) { return chooseUsb({one}, name, {}).ok(); });
  return meant;
}

Result<UsbFound> FalconName::choose(const std::vector<UsbFound>& plugged) {
  // One of the same serial number may have been plugged in since.
  const bool by_path = !path_.empty() && namesakes(name_, plugged) > 1;
  auto device = chooseUsb(plugged, by_path ? path_ : name_, "Novint Falcon");
  if (!device) return device;
  if (path_.empty()) name_ = nameOf(*device, plugged);
  path_ = device->path;
  return device;
}

const std::vector<Parameter<FalconParameters>>& falconParameterTable() {
  using S = FalconParameters;
  static const std::vector<Parameter<S>> kTable = {
      {{"firmware", "", 0, 0, "File with the device's firmware, which is not ours to ship."}, &S::firmware},
      {{"counts_per_nm", "", 1000, 40'000, "Motor counts for a newton metre at an arm; hang a weight to calibrate."},
       &S::counts_per_nm},
      {{"centre_z", "m", 0.07, 0.17, "Distance from the base that is x = 0."}, &S::centre_z},
  };
  return kTable;
}

DeviceInfo falconInfo(const FalconParameters& parameters) {
  DeviceInfo info;
  info.model = "Falcon";
  info.manufacturer = "Novint";
  info.driver = "falcon";
  info.driver_version = "1";
  // By CHAI3D's description of it; the motors' own limit is 4095 counts, 16 N along x and 6 N across in the middle, at
  // the usual scale. One whose counts make less has less; one that seems to make more is given no more.
  constexpr double kUsualForce = 8;
  const double strength = FalconParameters{}.counts_per_nm / parameters.counts_per_nm;
  info.max_force = kUsualForce * std::min(1.0, strength);
  info.max_stiffness = 3000;
  info.max_damping = 20;
  info.workspace_radius = 0.04;
  info.workspace_lower = Vec3(0.095 - parameters.centre_z, -0.03, -0.03);
  info.workspace_upper = Vec3(0.155 - parameters.centre_z, 0.03, 0.03);
  info.max_workspace_lower = Vec3(0.075 - parameters.centre_z, -0.06, -0.06);
  info.max_workspace_upper = Vec3(0.178 - parameters.centre_z, 0.06, 0.06);
  info.position_resolution = 41e-6;  // Along x at z = 0.12; across it is finer.
  info.force_resolution = kUsualForce * strength / falcon::kMostCounts;
  info.native_rate_hz = 1000;
  info.latency_s = 0.002;
  info.buttons = 4;
  info.calibration_style = "pull the grip out as far as it goes, then push it in, until the light turns blue";
  return info;
}

Result<std::vector<std::uint8_t>> readFalconFirmware(const std::string& path) {
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file && (errno == ENOENT || errno == ENOTDIR)) return std::vector<std::uint8_t>{};
  if (!file) {
    const int refused = errno;
    return Error{refused == EACCES ? ErrorCode::kPermissionDenied : ErrorCode::kSystem,
                 fmt::format("firmware {}", path), std::strerror(refused),
                 "let hapticd read it, and the folders it is in"};
  }
  std::vector<char> bytes(kMostFirmware + 1);
  file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  const auto size = static_cast<std::size_t>(file.gcount());
  // Those that are known have 7 to 9 kB.
  if (size < 1024 || size > kMostFirmware) {
    return Error{ErrorCode::kInvalidArgument, fmt::format("firmware {}", path),
                 fmt::format("{} bytes are no firmware of a Falcon",
                             size > kMostFirmware ? "too many" : fmt::format("{}", size)),
                 "give the .bin of Novint, some 8 kB"};
  }
  return std::vector<std::uint8_t>(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
}

Result<FalconSetup> resolveFalcon(const DeviceUri& uri, const std::vector<UsbFound>& plugged) {
  FalconSetup setup;
  if (auto applied = applyQuery(falconParameterTable(), uri.query, setup.parameters); !applied) return applied.error();
  setup.info = falconInfo(setup.parameters);
  FalconName name(uri.authority.empty() ? "default" : uri.authority);
  // It may be plugged in later; then it goes by the name it was given.
  if (const auto device = name.choose(plugged)) setup.info.serial = device.value().serial;
  setup.info.uri = formatDeviceUri({"falcon", name.text(), difference(falconParameterTable(), setup.parameters, {})});
  setup.open_usb = [name]() mutable -> Result<std::unique_ptr<UsbTransport>> {
    const auto device = name.choose(falconsPlugged());
    if (!device) return device.error();
    return openLibusb(device.value(), falcon::kInterface);
  };
  setup.read_firmware = [path = setup.parameters.firmware] { return readFalconFirmware(path); };
  return setup;
}

const Driver kFalconDriver = {"falcon", "falcon://default?firmware=PATH", true, &find, &make, &zero};

}  // namespace hapticd
