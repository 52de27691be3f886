/** @file
 * A played HID device behind a kernel that is umockdev's: sysfs, udev's database and a hidraw node that answers. The
 * program must run under umockdev-wrapper.
 */
#pragma once

#include <umockdev.h>

#include <mutex>
#include <string>
#include <vector>

#include "tools/haptic-emu/hid_model.h"

namespace hapticd::test {

struct HidIdentity {
  std::uint16_t vendor = 0, product = 0;
  std::string manufacturer, name, serial;
};

/** Plugged in while it lives. Reading, writing and ioctls come on a thread of umockdev's; `hold()` to touch the model.
 */
class HidrawTestbed {
 public:
  static constexpr const char* kNode = "/dev/hidraw7";

  /** `before`: descriptors of other interfaces of it, which come before the played one and answer nothing. */
  HidrawTestbed(haptic_emu::HidModel& model, const HidIdentity& identity,
                const std::vector<haptic_emu::HidModel::Bytes>& before = {});
  ~HidrawTestbed();
  HidrawTestbed(const HidrawTestbed&) = delete;
  HidrawTestbed& operator=(const HidrawTestbed&) = delete;

  [[nodiscard]] std::unique_lock<std::mutex> hold() { return std::unique_lock(mutex_); }

 private:
  void goOn();
  bool feature(UMockdevIoctlData* memory, bool set);
  static gboolean onIoctl(UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer self);
  static gboolean onRead(UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer self);
  static gboolean onWrite(UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer self);

  haptic_emu::HidModel& model_;
  std::int64_t start_ns_;
  std::mutex mutex_;
  UMockdevTestbed* bed_ = nullptr;
  UMockdevIoctlBase* handler_ = nullptr;
};

}  // namespace hapticd::test
