#include "drivers/registry.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "drivers/driver.h"
#include "drivers/falcon/falcon_driver.h"
#include "drivers/hidpid/hidpid_driver.h"
#include "drivers/pantograph/pantograph_driver.h"
#include "drivers/parameters.h"
#include "drivers/replay/replay_driver.h"
#include "drivers/sim/sim_driver.h"
#include "drivers/spacemouse/spacemouse_driver.h"
#include "drivers/vendor/vendor_driver.h"
#include "drivers/woodyhid/woodyhid_driver.h"
#include "rt/base/edit_distance.h"

namespace hapticd {
namespace {

/** Every driver, hardware first. A driver folder adds one line. */
constexpr const Driver* kDrivers[] = {
    &kFalconDriver, &kWoodyDriver,       &kHidPidDriver, &kPantographDriver, &kSpaceMouseDriver,
    &kDhdDriver,    &kOpenHapticsDriver, &kSimDriver,    &kReplayDriver,
};

/** Schemes that mean something to haptics people and that this build cannot open. */
struct KnownScheme {
  std::string_view scheme, why, remedy;
};
constexpr KnownScheme kUnsupportedSchemes[] = {
    {"remote", "devices of another machine are not reached through a URI of this one",
     "run hapticd on that machine and connect a client to it"},
    {"phantom", "Phantom and Touch devices go by the vendor's own library here",
     "openhaptics://default with OpenHaptics installed, or sim://touch for a simulated one"},
    {"ehap", "e-Haptik channels are not carried by this build", "open the device itself, e.g. sim://default"},
};

std::string listForms() {
  std::vector<std::string_view> forms;
  for (const Driver* driver : kDrivers) forms.push_back(driver->form);
  return fmt::format("{}", fmt::join(forms, ", "));
}

/** For who has mistyped a scheme, or left "://" away. */
std::string schemeMeant(std::string_view text) {
  for (const std::size_t edits : {0, 1, 2}) {
    for (const Driver* driver : kDrivers) {
      if (driver->scheme.size() > 2 * edits && editDistance(text.substr(0, 64), driver->scheme) == edits)
        return fmt::format("did you mean {}? ", driver->form);
    }
  }
  return {};
}

Result<const Driver*> driverOf(const DeviceUri& uri) {
  for (const Driver* driver : kDrivers) {
    if (driver->scheme == uri.scheme) return driver;
  }
  for (const KnownScheme& known : kUnsupportedSchemes) {
    if (known.scheme == uri.scheme) {
      return Error{ErrorCode::kUnsupported, uri.scheme + "://", std::string(known.why), std::string(known.remedy)};
    }
  }
  return Error{ErrorCode::kNotFound, uri.scheme.substr(0, 80) + "://", "no driver has this scheme",
               schemeMeant(uri.scheme) + fmt::format("there are {}", listForms())};
}

}  // namespace

bool isHardware(std::string_view scheme) noexcept {
  return std::any_of(std::begin(kDrivers), std::end(kDrivers),
                     [=](const Driver* driver) { return driver->real && driver->scheme == scheme; });
}

bool isAskedFor(std::string_view uri, std::string_view asked) noexcept {
  if (uri == asked) return true;
  const std::size_t question = uri.find('?');
  if (question == std::string_view::npos || uri.substr(0, question) != asked) return false;
  const std::string_view query = uri.substr(question);
  const auto has = [&](std::string_view key) { return query.find(key) != std::string_view::npos; };
  const bool told_apart = has("?path=") || has("&path=") || has("?serial=") || has("&serial=");
  return !told_apart && isHardware(uri.substr(0, uri.find("://")));
}

std::vector<DeviceFound> findDevices() {
  std::vector<DeviceFound> found;
  for (const Driver* driver : kDrivers) driver->find(found);
  return found;
}

Result<std::string> chooseDevice(std::string_view serial, const std::vector<DeviceFound>& found) {
  std::vector<std::string> known;
  for (const DeviceFound& one : found) {
    if (serial.empty() ? one.real : one.info.serial == serial) return one.info.uri;
    known.push_back(fmt::format("{} ({})", one.info.serial, one.info.uri));
  }
  if (serial.empty()) return std::string("sim://default");
  return Error{
      ErrorCode::kNotFound, fmt::format("device \"{}\"", serial.substr(0, 80)),
      "no device has that name or serial number",
      schemeMeant(serial) + fmt::format("there are {}; or give a URI: {}", fmt::join(known, ", "), listForms())};
}

Result<std::unique_ptr<Device>> makeDevice(std::string_view uri_or_serial, const std::string& within) {
  if (uri_or_serial.find("://") == std::string_view::npos) {
    const auto chosen = chooseDevice(uri_or_serial, findDevices());
    return chosen ? makeDevice(chosen.value()) : chosen.error();
  }
  Result<DeviceUri> uri = parseDeviceUri(uri_or_serial);
  if (!uri) return uri.error();
  uri->within = within;
  const Result<const Driver*> driver = driverOf(*uri);
  if (!driver) return driver.error();
  return driver.value()->make(*uri);
}

Result<void> zeroDevice(std::string_view text) {
  const Result<DeviceUri> uri = parseDeviceUri(text);
  if (!uri) return uri.error();
  const Result<const Driver*> driver = driverOf(*uri);
  if (!driver) return driver.error();
  return driver.value()->zero(*uri);
}

}  // namespace hapticd
