#include "tests/umockdev/hidraw_testbed.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <linux/hidraw.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cerrno>
#include <memory>

#include "rt/base/clock.h"

namespace hapticd::test {
namespace {

constexpr const char* kUsb = "/devices/pci0000:00/0000:00:14.0/usb1/1-2";

std::string device(const HidIdentity& who) {
  return fmt::format(
      "P: {0}\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_device\nA: idVendor={1:04x}\nA: idProduct={2:04x}\nA: bcdDevice=0100\n"
      "A: manufacturer={3}\nA: product={4}\nA: serial={5}\n\n",
      kUsb, who.vendor, who.product, who.manufacturer, who.name, who.serial);
}

std::string interface(const HidIdentity& who, const haptic_emu::HidModel::Bytes& descriptor, std::size_t number,
                      std::size_t node) {
  std::string hex;
  for (const std::uint8_t byte : descriptor) hex += fmt::format("{:02X}", byte);
  const std::string name = fmt::format("0003:{:04X}:{:04X}.{:04X}", who.vendor, who.product, node);
  const std::string hid = fmt::format("{}/1-2:1.{}/{}", kUsb, number, name);
  return fmt::format(
      "P: {0}/1-2:1.{1}\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_interface\nA: bInterfaceNumber={1:02}\n\n"
      "P: {6}\nE: SUBSYSTEM=hid\nE: HID_ID=0003:{2:08X}:{3:08X}\nE: HID_NAME={4}\nE: HID_UNIQ={5}\n"
      "H: report_descriptor={7}\n\n"
      "P: {6}/hidraw/hidraw{8}\nN: hidraw{8}\nE: SUBSYSTEM=hidraw\nE: DEVNAME=/dev/hidraw{8}\nL: device=../../../{9}\n"
      "A: dev=241:{8}\\n\n\n",
      kUsb, number, who.vendor, who.product, who.manufacturer + " " + who.name, who.serial, hid, hex, node, name);
}

constexpr unsigned kSetFeature = _IOC_NR(HIDIOCSFEATURE(1)), kGetFeature = _IOC_NR(HIDIOCGFEATURE(1));

/** The answer goes into the caller's memory. */
void put(UMockdevIoctlData* where, std::span<const std::uint8_t> bytes) {
  umockdev_ioctl_data_update(where, 0, const_cast<std::uint8_t*>(bytes.data()), static_cast<int>(bytes.size()));
}

}  // namespace

HidrawTestbed::HidrawTestbed(haptic_emu::HidModel& model, const HidIdentity& identity,
                             const std::vector<haptic_emu::HidModel::Bytes>& before)
    : model_(model), start_ns_(MonotonicClock().now()) {
  bed_ = umockdev_testbed_new();
  GError* error = nullptr;
  std::string all = device(identity);
  for (std::size_t i = 0; i < before.size(); ++i) all += interface(identity, before[i], i, 1 + i);
  all += interface(identity, model.descriptor(), before.size(), 7);
  const bool added = umockdev_testbed_add_from_string(bed_, all.c_str(), &error);
  EXPECT_TRUE(added) << (error != nullptr ? error->message : "");
  handler_ = umockdev_ioctl_base_new();
  g_signal_connect(handler_, "handle-ioctl", G_CALLBACK(&HidrawTestbed::onIoctl), this);
  g_signal_connect(handler_, "handle-read", G_CALLBACK(&HidrawTestbed::onRead), this);
  g_signal_connect(handler_, "handle-write", G_CALLBACK(&HidrawTestbed::onWrite), this);
  EXPECT_TRUE(umockdev_testbed_attach_ioctl(bed_, kNode, handler_, &error)) << (error != nullptr ? error->message : "");
  // The node is a pty whose reads are answered by onRead(); a line in it says for ever that there is something to read.
  EXPECT_EQ(write(umockdev_testbed_get_dev_fd(bed_, kNode), "\n", 1), 1);
}

void HidrawTestbed::goOn() { model_.advance(MonotonicClock().now() - start_ns_); }

HidrawTestbed::~HidrawTestbed() {
  (void)umockdev_testbed_detach_ioctl(bed_, kNode, nullptr);
  g_object_unref(handler_);
  g_object_unref(bed_);
}

gboolean HidrawTestbed::onIoctl(UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer self) {
  auto& me = *static_cast<HidrawTestbed*>(self);
  const auto held = me.hold();
  me.goOn();
  const unsigned long request = umockdev_ioctl_client_get_request(client);
  UMockdevIoctlData* memory =
      umockdev_ioctl_data_resolve(umockdev_ioctl_client_get_arg(client), 0, _IOC_SIZE(request), nullptr);
  int error = EINVAL;
  long done = 0;
  if (request == HIDIOCGRDESCSIZE) {
    const auto size = static_cast<std::uint32_t>(me.model_.descriptor().size());
    put(memory, {reinterpret_cast<const std::uint8_t*>(&size), sizeof size});
    error = 0;
  } else if (request == HIDIOCGRDESC) {
    hidraw_report_descriptor all{};
    all.size = static_cast<std::uint32_t>(me.model_.descriptor().size());
    std::copy(me.model_.descriptor().begin(), me.model_.descriptor().end(), all.value);
    put(memory, {reinterpret_cast<const std::uint8_t*>(&all), sizeof all});
    error = 0;
  } else if (_IOC_TYPE(request) == 'H' && (_IOC_NR(request) == kSetFeature || _IOC_NR(request) == kGetFeature)) {
    error = me.feature(memory, _IOC_NR(request) == kSetFeature) ? 0 : EPIPE;
    done = static_cast<long>(_IOC_SIZE(request));
  }
  if (memory != nullptr) umockdev_ioctl_data_unref(memory);
  umockdev_ioctl_client_complete(client, error == 0 ? done : -1, error);
  return TRUE;
}

bool HidrawTestbed::feature(UMockdevIoctlData* memory, bool set) {
  std::uint8_t* bytes = nullptr;
  int size = 0;
  umockdev_ioctl_data_retrieve(memory, &bytes, &size);
  const std::unique_ptr<std::uint8_t, void (*)(void*)> owner(bytes, &g_free);
  if (size < 1) return false;
  if (set) return model_.setFeature({bytes, static_cast<std::size_t>(size)});
  const auto answer = model_.getFeature(bytes[0]);
  if (answer) put(memory, *answer);
  return answer.has_value();
}

gboolean HidrawTestbed::onRead(UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer self) {
  auto& me = *static_cast<HidrawTestbed*>(self);
  const auto held = me.hold();
  me.goOn();
  const auto report = me.model_.in();
  if (report) put(umockdev_ioctl_client_get_arg(client), *report);
  umockdev_ioctl_client_complete(client, report ? static_cast<long>(report->size()) : -1, report ? 0 : EAGAIN);
  return TRUE;
}

gboolean HidrawTestbed::onWrite(UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer self) {
  auto& me = *static_cast<HidrawTestbed*>(self);
  const auto held = me.hold();
  me.goOn();
  std::uint8_t* bytes = nullptr;
  int size = 0;
  umockdev_ioctl_data_retrieve(umockdev_ioctl_client_get_arg(client), &bytes, &size);
  std::span<const std::uint8_t> report(bytes, static_cast<std::size_t>(size));
  if (!report.empty() && report[0] == 0) report = report.subspan(1);  // Unnumbered on the wire.
  const bool taken = me.model_.out(report);
  umockdev_ioctl_client_complete(client, taken ? size : -1, taken ? 0 : EPIPE);
  g_free(bytes);
  return TRUE;
}

}  // namespace hapticd::test
