#include "drivers/vendor/vendor_driver.h"

#include <poll.h>

#include "drivers/usb/usb_list.h"
#include "drivers/vendor/helper_device.h"
#include "drivers/vendor/helper_protocol.h"
#include "drivers/vendor/sdk/dhd_io.h"
#include "drivers/vendor/sdk/openhaptics_io.h"

namespace hapticd {
namespace {

constexpr std::uint16_t kForceDimension = 0x1451;
constexpr std::uint16_t kProducts[] = {0x0301, 0x0402, 0x0403, 0x040C};

Result<std::unique_ptr<Device>> helperFor(DeviceInfo info) {
  static MonotonicClock clock;
  return std::unique_ptr<Device>(std::make_unique<HelperDevice>(std::move(info), HelperOptions{}, clock));
}

Result<std::unique_ptr<Device>> makeDhd(const DeviceUri& uri) {
  auto setup = resolveDhd(uri);
  if (!setup) return setup.error();
  return helperFor(std::move(setup->info));
}

Result<std::unique_ptr<Device>> makeHd(const DeviceUri& uri) {
  auto setup = resolveHd(uri);
  if (!setup) return setup.error();
  return helperFor(std::move(setup->info));
}

/** Which device is which only the SDK knows: whatever is plugged in is the default. Not taken unasked. */
void findDhd(std::vector<DeviceFound>& found) {
  for (const std::uint16_t product : kProducts) {
    if (findUsb(kForceDimension, product).empty()) continue;
    if (auto setup = resolveDhd({"dhd", "default", {}})) found.push_back({std::move(setup->info), false});
    return;
  }
}

/** Touches have names in the maker's set-up, not on the bus. */
void findHd(std::vector<DeviceFound>&) {}

Result<void> zero(const DeviceUri& uri) { return zeroVendor(uri, {}); }

}  // namespace

/** A helper that opens the device brings it to zero; the dead daemon's own may still be on it for a moment. */
Result<void> zeroVendor(const DeviceUri& uri, const HelperOptions& options) {
  constexpr int kPatience_ms = 1500, kAgain_ms = 100;
  SharedLinkMapping memory;
  if (auto made = memory.make(); !made) return made;
  memory.get()->generation.store(1);
  Result<void> done = Error{ErrorCode::kTimeout, "hapticd-vendor", "no answer", {}};
  for (int waited_ms = 0; !done && waited_ms < kPatience_ms; waited_ms += kAgain_ms) {
    if (waited_ms > 0) (void)::poll(nullptr, 0, kAgain_ms);
    auto helper = HelperProcess::start(options);
    if (!helper) return helper.error();
    if (done = sendRequest(helper->socket(), {formatDeviceUri(uri), 1}, memory.descriptor()); !done) continue;
    const auto answer = receiveAnswer(helper->socket(), kPatience_ms - waited_ms);
    done = answer ? answer.value().opened : Result<void>(answer.error());
    if (!answer) break;
  }
  return done;
}

Result<std::unique_ptr<DeviceIo>> makeVendorIo(const DeviceUri& uri, Clock& clock) {
  if (uri.scheme == kDhdDriver.scheme) {
    auto setup = resolveDhd(uri);
    if (!setup) return setup.error();
    return std::unique_ptr<DeviceIo>(std::make_unique<DhdIo>(std::move(*setup), clock));
  }
  if (uri.scheme == kOpenHapticsDriver.scheme) {
    auto setup = resolveHd(uri);
    if (!setup) return setup.error();
    return std::unique_ptr<DeviceIo>(std::make_unique<OpenHapticsIo>(std::move(*setup), clock));
  }
  return Error{
      ErrorCode::kUnsupported, uri.scheme + "://", "hapticd-vendor drives dhd:// and openhaptics:// alone", {}};
}

std::vector<SdkPresence> vendorSdks() {
  std::vector<SdkPresence> sdks = {{"Force Dimension", kDhdDriver.scheme, kDhdLibrary, {}},
                                   {"OpenHaptics", kOpenHapticsDriver.scheme, kHdLibrary, {}}};
  for (SdkPresence& sdk : sdks) sdk.path = whereSdkIs(std::string(sdk.library));
  return sdks;
}

const Driver kDhdDriver = {"dhd", "dhd://default?sdk=/path/libdhd.so.3", true, &findDhd, &makeDhd, &zero};
const Driver kOpenHapticsDriver = {"openhaptics", "openhaptics://default?sdk=/path/libHD.so", true, &findHd, &makeHd,
                                   &zero};

}  // namespace hapticd
