// Contract 1 on the devices that the servo calls itself: read, write and setIntent under the detectors.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <limits>
#include <string>

#include "drivers/registry.h"
#include "rt/cycle/realtime.h"
#include "tests/support/detectors.h"

namespace hapticd {
namespace {

/** A recording of a few thousand rows. */
class Recording {
 public:
  Recording() {
    const int fd = mkstemp(path_.data());
    std::FILE* file = fdopen(fd, "w");
    for (int i = 0; i < 5000; ++i) std::fprintf(file, "%d.%03d,0.0%d,0,0,1,0,0,0\n", i / 1000, i % 1000, i % 10);
    std::fclose(file);
  }
  ~Recording() { unlink(path_.c_str()); }
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_ = ::testing::TempDir() + "hapticd-recording-XXXXXX";
};

void step(Device& device, std::int64_t i, DeviceSample& sample) {
  const std::int64_t gap = i % 1000 == 999 ? 500'000'000 : 0;
  const std::int64_t now_ns = i * 1'000'000 + gap;
  device.read(now_ns, sample);
  DeviceCommand command;
  command.enabled = i % 50 != 0;
  command.force = -2000 * sample.p;
  command.torque = Vec3(0.01, 0.02, 0.03);
  command.gripper_force = 20;
  if (i % 97 == 0) command.force.x() = std::numeric_limits<double>::quiet_NaN();
  device.write(now_ns, command);
  DeviceIntent intent;
  intent.p = Vec3(0.2, 0, 0) * static_cast<double>(i % 3);
  device.setIntent(intent);
  if (i % 500 == 0) device.safe();
}

void expectClean(const std::string& uri) {
  SCOPED_TRACE(uri);
  auto made = makeDevice(uri);
  ASSERT_TRUE(made.ok()) << toString(made.error());
  Device& device = **made;
  ASSERT_TRUE(device.open().ok());
  DeviceSample sample;
  test::expectClean(
      [&] {
        disableDenormals();
        for (int i = 0; i < 100; ++i) step(device, i, sample);
      },
      [&] {
        for (int i = 100; i < 10'100; ++i) step(device, i, sample);
      });
}

TEST(Devices, EveryMotionOfTheSimulatorIsClean) {
  for (const char* motion : {"live", "hold", "tap", "stroke", "circle", "lissajous", "minjerk"}) {
    expectClean(std::string("sim://sigma7?position_delay=3&delay=9&motion=") + motion);
  }
  expectClean("sim://falcon?lower=-0.001,-0.001,-0.001&upper=0.001,0.001,0.001&motion=circle");
}

TEST(Devices, RecordingsAreClean) {
  const Recording recording;
  expectClean("sim://omega7?motion=csv&loop=1&file=" + recording.path());
  expectClean("replay://" + recording.path() + "?loop=1&speed=3");
}

}  // namespace
}  // namespace hapticd
