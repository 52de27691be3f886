// A group's servo runs on the processors that the configuration names, or not at all.
#include <sched.h>

#include <atomic>
#include <thread>

#include "daemon/device/device_group.h"
#include "tests/session/bench.h"
#include "tests/session/still_device.h"

namespace hapticd::test {
namespace {

/** Says where the servo may run. */
class WhereDevice final : public StillDevice {
 public:
  explicit WhereDevice(std::atomic<int>& allowed) : StillDevice("where", "test://where"), allowed_(allowed) {}
  Result<void> open() override { return {}; }
  void giveUp() noexcept override {}
  void close() noexcept override {}
  void read(std::int64_t now_ns, DeviceSample& sample) HD_RT override {
    cpu_set_t set;
    if (sched_getaffinity(0, sizeof set, &set) == 0) allowed_.store(CPU_COUNT(&set) == 1 ? lowest(set) : -2);
    StillDevice::read(now_ns, sample);
  }
  static int lowest(const cpu_set_t& set) {
    for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu)
      if (CPU_ISSET(cpu, &set)) return cpu;
    return -3;
  }

 private:
  std::atomic<int>& allowed_;
};

class GroupCpus : public testing::Test {
 protected:
  Result<std::unique_ptr<DeviceGroup>> start(std::vector<std::uint32_t> cpus) {
    std::vector<std::unique_ptr<Device>> devices;
    devices.push_back(std::make_unique<WhereDevice>(allowed));
    GroupOptions options;
    options.cycle.period_ns = kMs;
    options.allow_no_rt = true;
    options.cpus = std::move(cpus);
    return DeviceGroup::start(options, std::move(devices), meshes, clock);
  }
  std::atomic<int> allowed{-1};
  MeshTable meshes;
  MonotonicClock clock;
};

TEST_F(GroupCpus, AreThoseThatAreNamed) {
  cpu_set_t ours;
  ASSERT_EQ(sched_getaffinity(0, sizeof ours, &ours), 0);
  const int cpu = WhereDevice::lowest(ours);
  const auto group = start({static_cast<std::uint32_t>(cpu)});
  ASSERT_TRUE(group.ok()) << toString(group.error());
  while (allowed == -1) std::this_thread::yield();
  EXPECT_EQ(allowed, cpu);
}

TEST_F(GroupCpus, ThatAreNotThereAreRefused) {
  for (const std::uint32_t cpu : {1023u, 100'000u}) {
    const auto group = start({cpu});
    ASSERT_FALSE(group.ok());
    EXPECT_EQ(group.error().where, "cpus");
  }
  EXPECT_EQ(allowed, -1);
}

}  // namespace
}  // namespace hapticd::test
