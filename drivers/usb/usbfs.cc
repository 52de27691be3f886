#include "drivers/usb/usbfs.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/usbdevice_fs.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace hapticd {

bool usbfsSend(int fd, std::uint8_t endpoint, std::span<const std::uint8_t> bytes, std::uint32_t timeout_ms) noexcept {
  usbdevfs_bulktransfer transfer{};
  transfer.ep = endpoint;
  transfer.len = static_cast<unsigned>(bytes.size());
  transfer.timeout = timeout_ms;
  transfer.data = const_cast<std::uint8_t*>(bytes.data());  // NOLINT: the kernel only reads it
  return ioctl(fd, USBDEVFS_BULK, &transfer) == static_cast<int>(bytes.size());
}

Error usbOpenError(const UsbFound& device, int refused, const std::string& held_by) {
  const std::string where = fmt::format("USB device {} ({})", device.path, device.node());
  switch (refused) {
    case EBUSY:
      return {ErrorCode::kDeviceBusy, where,
              held_by.empty() || held_by == "usbfs" ? "another program owns it"
                                                    : fmt::format("the kernel driver {} owns it", held_by),
              fmt::format("end that program; \"fuser {}\" names it", device.node())};
    case EACCES:
    case EPERM:
      return {ErrorCode::kPermissionDenied, where, "no right to open it",
              "install hapticd's udev rules and join the group haptic, or run the service"};
    case ENOENT:
    case ENODEV:
      return {ErrorCode::kDeviceGone, where, "it is not there any more", "plug it in again"};
    default:
      return {ErrorCode::kSystem, where, std::strerror(refused), "see the kernel's log"};
  }
}

Result<void> usbfsSendOnce(const UsbFound& device, const UsbInterface& interface, std::span<const std::uint8_t> bytes,
                           int times, std::uint32_t timeout_ms) {
  const int fd = open(device.node().c_str(), O_RDWR | O_CLOEXEC);
  if (fd < 0) return usbOpenError(device, errno, {});
  usbdevfs_disconnect_claim claim{};
  claim.interface = interface.number;
  claim.flags = USBDEVFS_DISCONNECT_CLAIM_EXCEPT_DRIVER;  // Never from a program that lives.
  std::strncpy(claim.driver, "usbfs", sizeof claim.driver - 1);
  if (ioctl(fd, USBDEVFS_DISCONNECT_CLAIM, &claim) != 0) {
    const int refused = errno;
    close(fd);
    return usbOpenError(device, refused, "usbfs");
  }
  bool taken = true;
  for (int i = 0; i < times; ++i) taken = usbfsSend(fd, interface.out, bytes, timeout_ms) && taken;
  unsigned number = interface.number;
  (void)ioctl(fd, USBDEVFS_RELEASEINTERFACE, &number);
  close(fd);
  if (taken) return {};
  return Error{ErrorCode::kTimeout, fmt::format("USB device {} ({})", device.path, device.node()),
               "it does not take the packet that sets its forces to zero", "switch its power off"};
}

}  // namespace hapticd
