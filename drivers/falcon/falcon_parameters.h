/** @file
 * Keys of a falcon:// URI, and the device they make.
 */
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "drivers/parameters.h"
#include "drivers/registry.h"
#include "drivers/usb/transport.h"
#include "drivers/usb/usb_list.h"

namespace hapticd {

struct FalconParameters {
  std::string firmware = "/var/lib/hapticd/falcon.bin";
  double counts_per_nm = 10'000;
  double centre_z = 0.125;
};
[[nodiscard]] const std::vector<Parameter<FalconParameters>>& falconParameterTable();

/** All that a Falcon needs to run. */
struct FalconSetup {
  FalconParameters parameters;
  DeviceInfo info;
  UsbOpener open_usb;
  /** Called when the device turns out to need it; empty when there is none. */
  std::function<Result<std::vector<std::uint8_t>>()> read_firmware;
};

/** A Falcon by its serial number, its path or "default", and the same one whenever it is plugged in again. */
class FalconName {
 public:
  explicit FalconName(std::string name) : name_(std::move(name)) {}
  /** Of what is plugged in, as chooseUsb(); from the first time on no other. */
  [[nodiscard]] Result<UsbFound> choose(const std::vector<UsbFound>& plugged);
  /** What stays the same when it is plugged in again: a serial number that no other has, else its path. */
  [[nodiscard]] const std::string& text() const noexcept { return name_; }

 private:
  std::string name_;
  std::string path_;  ///< Where it was last.
};

/** All that a URI's name may stand for: several of one serial number, and of "default" whatever is plugged in. */
[[nodiscard]] std::vector<UsbFound> falconsMeant(const std::string& name, const std::vector<UsbFound>& plugged);

/** What a Falcon is and can do, by data sheet and CHAI3D. */
[[nodiscard]] DeviceInfo falconInfo(const FalconParameters& parameters);

/** The setup of a URI for a device of `plugged`, which need not be there yet. */
[[nodiscard]] Result<FalconSetup> resolveFalcon(const DeviceUri& uri, const std::vector<UsbFound>& plugged);

/** The firmware from a file of the user; an empty one when there is no such file. kInvalidArgument if it is none,
 * kPermissionDenied if it cannot be read. */
[[nodiscard]] Result<std::vector<std::uint8_t>> readFalconFirmware(const std::string& path);

}  // namespace hapticd
