#include "tools/haptic-bench/device/played_sdk.h"

#include <fmt/format.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>

#include "drivers/vendor/helper_device.h"
#include "drivers/vendor/vendor_driver.h"
#include "tools/haptic-bench/beside_program.h"
#include "tools/haptic-bench/device/servo_thread.h"
#include "tools/haptic-bench/failure.h"

namespace haptic_bench {
namespace {

using namespace hapticd;  // NOLINT(google-build-using-namespace)
constexpr std::size_t kStateBytes = 4096;

/** The beginning of what the played SDK keeps of its device: all that scripts and this know. */
struct Grip {
  std::atomic<double> place[3];
  std::atomic<double> force[3];
};

/** Shared by each copy of the library that is loaded after the first call, in this process and in its children. */
const Grip& sharedGrip() {
  static const Grip* const grip = [] {
    const int file = ::memfd_create("played-sdk", MFD_CLOEXEC);
    void* const at = file < 0 || ::ftruncate(file, kStateBytes) != 0
                         ? MAP_FAILED
                         : ::mmap(nullptr, kStateBytes, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    if (at == MAP_FAILED) {
      throw Failure("played SDK", std::string("its memory: ") + std::strerror(errno), {});
    }
    ::setenv("FAKE_SDK_STATE", fmt::format("/proc/{}/fd/{}", ::getpid(), file).c_str(), 1);
    ::setenv("FAKE_SDK_THREAD", "1", 1);
    return static_cast<const Grip*>(at);
  }();
  return *grip;
}

std::string uriOf(const std::string& scheme, const std::string& sdk) { return scheme + "://default?sdk=" + sdk; }

class PlayedDhd final : public PlayedDevice {
 public:
  PlayedDhd(const std::string& sdk, Clock& clock) : grip_(sharedGrip()) {
    device_ = std::make_unique<IoDevice>(orFail(makeVendorIo({"dhd", "default", {{"sdk", sdk}}}, clock)),
                                         IoOptions{.thread = false}, clock);
  }
  IoDevice& device() override { return *device_; }
  Vec3 force() const override { return {grip_.force[0], grip_.force[1], grip_.force[2]}; }

 private:
  const Grip& grip_;
  std::unique_ptr<IoDevice> device_;
};

std::int64_t processorTime_ns(pid_t process) {
  clockid_t clock = 0;
  timespec spent{};
  if (::clock_getcpuclockid(process, &clock) != 0 || ::clock_gettime(clock, &spent) != 0) return 0;
  return spent.tv_sec * 1'000'000'000 + spent.tv_nsec;
}

}  // namespace

std::string playedSdk() { return besideProgram({"../../tests/libfake_vendor_sdk.so"}); }

std::unique_ptr<PlayedDevice> playDhd(const std::string& sdk, Clock& clock) {
  return std::make_unique<PlayedDhd>(sdk, clock);
}

HelperFigures runHelper(const std::string& scheme, const std::string& sdk, double seconds) {
  (void)sharedGrip();
  MonotonicClock clock;
  DeviceInfo info;
  info.uri = uriOf(scheme, sdk);
  HelperDevice device(info, {"", besideProgram({"../../daemon/hapticd-vendor"})}, clock);
  orFail(device.open());
  const std::int64_t ticks = std::llround(seconds * 1000), spent_ns = processorTime_ns(device.helper());
  Histogram age;
  std::int64_t inside_ns = 0;
  DeviceSample sample;
  onServoThread(ticks, clock, [&](std::int64_t, std::int64_t now_ns) {
    device.read(now_ns, sample);
    device.write(now_ns, {});
    inside_ns += clock.now() - now_ns;
    if (sample.fresh) age.record(now_ns - sample.t_ns);
  });
  const auto a_tick = [ticks](std::int64_t ns) { return static_cast<double>(ns) * 1e-3 / static_cast<double>(ticks); };
  const HelperFigures figures{device.roundTrip()->summary(), age.summary(), a_tick(inside_ns),
                              a_tick(processorTime_ns(device.helper()) - spent_ns)};
  if (device.helper() == 0) throw Failure(info.uri, "hapticd-vendor has died", {});
  return figures;
}

}  // namespace haptic_bench
