#include "drivers/usb/usb_list.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "drivers/usb/libusb_transport.h"

namespace hapticd {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

/** A folder as /sys/bus/usb/devices is. */
class UsbList : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "hapticd-usb-XXXXXX").string();
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override { fs::remove_all(folder_); }
  void write(const std::string& device, const std::string& attribute, const std::string& text) {
    fs::create_directories(folder_ / device);
    std::ofstream(folder_ / device / attribute) << text << '\n';
  }
  void plug(const std::string& path, const char* address, const char* serial) {
    write(path, "idVendor", "0403");
    write(path, "idProduct", "cb48");
    write(path, "busnum", "1");
    write(path, "devnum", address);
    if (*serial != '\0') write(path, "serial", serial);
  }
  std::vector<UsbFound> find() { return findUsb(0x0403, 0xcb48, folder_.string()); }
  fs::path folder_;
};

TEST_F(UsbList, FindsWhatIsPluggedInByIds) {
  plug("1-2.3", "17", "AB12");
  plug("1-1", "4", "");
  write("1-4", "idVendor", "0403");
  write("1-4", "idProduct", "6001");
  write("1-2.3:1.0", "bInterfaceNumber", "00");
  write("1-5", "idVendor", "zz");
  plug("1-6", "gone", "");
  const auto found = find();
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].path, "1-1");
  EXPECT_EQ(found[1].serial, "AB12");
  EXPECT_EQ(found[1].node(), "/dev/bus/usb/001/017");
}

TEST_F(UsbList, ChoosesBySerialPathOrTheFirst) {
  plug("1-1", "4", "");
  plug("1-2", "5", "AB12");
  const auto found = find();
  EXPECT_EQ(chooseUsb(found, "default", "Falcon")->path, "1-1");
  EXPECT_EQ(chooseUsb(found, "AB12", "Falcon")->path, "1-2");
  EXPECT_EQ(chooseUsb(found, "1-2", "Falcon")->address, 5u);
  const auto wrong = chooseUsb(found, "AB13", "Falcon");
  ASSERT_FALSE(wrong.ok());
  EXPECT_EQ(wrong.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(toString(wrong.error()), HasSubstr("there are 1-1, AB12 (1-2)"));
  const auto none = chooseUsb({}, "", "Falcon");
  ASSERT_FALSE(none.ok());
  EXPECT_THAT(toString(none.error()), HasSubstr("no Falcon is plugged in"));
}

TEST_F(UsbList, NamesTheDriverOfAnInterface) {
  plug("1-1", "4", "");
  const UsbFound device = find().front();
  EXPECT_EQ(usbInterfaceDriver(device, 0, folder_.string()), "");
  fs::create_directories(folder_ / "1-1:1.0");
  fs::create_symlink("../../bus/usb/drivers/ftdi_sio", folder_ / "1-1:1.0" / "driver");
  EXPECT_EQ(usbInterfaceDriver(device, 0, folder_.string()), "ftdi_sio");
}

TEST_F(UsbList, NoUsbAtAllFindsNothing) { EXPECT_TRUE(findUsb(1, 2, (folder_ / "no").string()).empty()); }

TEST(Libusb, ADeviceThatIsNotThereIsNamed) {
  UsbFound device;
  device.bus = device.address = 999;
  device.path = "9-9";
  const auto opened = openLibusb(device, {});
  ASSERT_FALSE(opened.ok());
  EXPECT_EQ(opened.error().code, ErrorCode::kDeviceGone);
  EXPECT_THAT(toString(opened.error()), HasSubstr("9-9 (/dev/bus/usb/999/999)"));
}

}  // namespace
}  // namespace hapticd
