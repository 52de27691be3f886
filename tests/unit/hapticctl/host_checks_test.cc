// The doctor's look at the machine, on machines made up for it.
#include "tools/hapticctl/command/host_checks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <tuple>

#include "tests/support/process/child_process.h"
#include "tests/support/process/temporary_directory.h"

namespace hapticctl {
namespace {

class HostChecksTest : public ::testing::Test {
 protected:
  void write(const std::string& path, const std::string& text) {
    const std::filesystem::path full = root_.string() + path;
    std::filesystem::create_directories(full.parent_path());
    std::ofstream(full) << text << '\n';
  }
  HostCheck check(const std::string& name) {
    const auto all = hostChecks({root_.string(), kernel_});
    const auto at = std::find_if(all.begin(), all.end(), [&](const HostCheck& c) { return c.name == name; });
    EXPECT_NE(at, all.end()) << name;
    return at == all.end() ? HostCheck{} : *at;
  }

  hapticd::test::TemporaryDirectory temporary_;
  const std::filesystem::path root_ = temporary_.path();
  std::string kernel_;  ///< Its version, where that of the machine will not do.
};

TEST_F(HostChecksTest, WhatIsNotThereDoesNotApply) {
  for (const char* name : {"CPU frequency governor", "CPU sleep states", "real-time throttling",
                           "transparent huge pages", "NUMA balancing", "compaction of locked pages"}) {
    EXPECT_EQ(check(name).state, CheckState::kNotApplicable) << name;
  }
  EXPECT_EQ(check("udev rules").state, CheckState::kRed);
}

TEST_F(HostChecksTest, OneSlowCpuIsRed) {
  write("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "performance");
  write("/sys/devices/system/cpu/cpu11/cpufreq/scaling_governor", "performance");
  write("/sys/devices/system/cpu/cpufreq/boost", "1");
  EXPECT_EQ(check("CPU frequency governor").state, CheckState::kGreen);
  write("/sys/devices/system/cpu/cpu11/cpufreq/scaling_governor", "powersave");
  EXPECT_EQ(check("CPU frequency governor").state, CheckState::kRed);
  EXPECT_EQ(check("CPU frequency governor").detail, "powersave");
}

TEST_F(HostChecksTest, TunablesAreReadAsTheKernelWritesThem) {
  write("/sys/kernel/mm/transparent_hugepage/enabled", "always [madvise] never");
  EXPECT_EQ(check("transparent huge pages").state, CheckState::kGreen);
  write("/sys/kernel/mm/transparent_hugepage/enabled", "[always] madvise never");
  EXPECT_EQ(check("transparent huge pages").state, CheckState::kRed);
  for (const auto& [value, state] :
       {std::pair{"950000", CheckState::kGreen}, {"-1", CheckState::kGreen}, {"0", CheckState::kRed}}) {
    write("/proc/sys/kernel/sched_rt_runtime_us", value);
    EXPECT_EQ(check("real-time throttling").state, state) << value;
  }
  write("/proc/sys/vm/compact_unevictable_allowed", "1");
  EXPECT_EQ(check("compaction of locked pages").state, CheckState::kRed);
  write("/proc/sys/kernel/numa_balancing", "0");
  EXPECT_EQ(check("NUMA balancing").state, CheckState::kGreen);
}

TEST_F(HostChecksTest, RealTimeKernelAndRulesAreFound) {
  write("/sys/kernel/realtime", "1");
  write("/usr/lib/udev/rules.d/60-hapticd.rules", "");
  EXPECT_EQ(check("kernel preemption").state, CheckState::kGreen);
  EXPECT_EQ(check("udev rules").detail, "/usr/lib/udev/rules.d/60-hapticd.rules");
}

TEST_F(HostChecksTest, PreemptionIsReadAsTheKernelWritesIt) {
  kernel_ = "#1 SMP PREEMPT_DYNAMIC Debian 6.1";
  for (const auto& [modes, mode, state] : {std::tuple{"none voluntary (full) ", "full", CheckState::kGreen},
                                           {"none (voluntary) full ", "voluntary", CheckState::kRed},
                                           {"(none) voluntary full lazy ", "none", CheckState::kRed}}) {
    write("/sys/kernel/debug/sched/preempt", modes);
    EXPECT_EQ(check("kernel preemption").state, state) << modes;
    EXPECT_TRUE(check("kernel preemption").detail.starts_with(std::string("preemption ") + mode + " (")) << modes;
  }
  std::filesystem::remove_all(root_ / "sys/kernel/debug");  // As for everybody but root.
  EXPECT_TRUE(check("kernel preemption").detail.starts_with("preemption dynamic ("));
  write("/proc/cmdline", "quiet preempt=voluntary ro preempt=full");
  EXPECT_EQ(check("kernel preemption").state, CheckState::kGreen) << check("kernel preemption").detail;
  write("/proc/cmdline", "quiet preempt=none");
  EXPECT_EQ(check("kernel preemption").state, CheckState::kRed);
}

TEST_F(HostChecksTest, LimitsThatThePackageGrantsAreNotWrittenAgain) {
  const auto remedy = [&](const char* name) { return check(name).remedy; };
  for (const auto& [name, item] : {std::pair{"real-time priority", "'@haptic - rtprio 85' >> /etc/security/limits.d"},
                                   {"locked memory", "'@haptic - memlock 1048576' >> /etc/security/limits.d"}}) {
    EXPECT_NE(remedy(name).find(item), std::string::npos) << remedy(name);
  }
  std::filesystem::create_directories(root_ / "etc/security/limits.d");
  std::filesystem::copy_file(HAPTICD_SOURCE_DIR "/systemd/hapticd.limits",
                             root_ / "etc/security/limits.d/hapticd.conf");
  for (const char* name : {"real-time priority", "locked memory"}) {
    EXPECT_EQ(remedy(name).find("echo"), std::string::npos) << remedy(name);
    EXPECT_NE(remedy(name).find("adduser"), std::string::npos) << remedy(name);
  }
}

TEST_F(HostChecksTest, EveryRedHasItsRemedyInOneLine) {
  write("/proc/self/cgroup", "3:memory:/m\n4:cpu,cpuacct:/user.slice");
  write("/sys/fs/cgroup/cpu/cpu.rt_runtime_us", "950000");
  EXPECT_EQ(check("real-time group scheduling").state, CheckState::kGreen) << "the group's own file is not there";
  write("/sys/fs/cgroup/cpu/user.slice/cpu.rt_runtime_us", "0");
  EXPECT_EQ(check("real-time group scheduling").state, CheckState::kRed);
  write("/proc/sys/kernel/sched_rt_runtime_us", "0");
  write("/proc/sys/kernel/numa_balancing", "1");
  std::size_t red = 0;
  for (const HostCheck& c : hostChecks({root_.string(), kernel_})) {
    if (c.state != CheckState::kRed) continue;
    ++red;
    EXPECT_FALSE(c.remedy.empty()) << c.name;
    EXPECT_EQ(c.remedy.find('\n'), std::string::npos) << c.name;
  }
  EXPECT_GE(red, 4u);
}

TEST_F(HostChecksTest, AConfigurationThatWasEditedSinceIsRed) {
  using std::chrono_literals::operator""h;
  const auto now = std::chrono::system_clock::now();
  const std::string file = root_ / "hapticd.toml";
  EXPECT_EQ(configurationCheck("", now).state, CheckState::kGreen) << "built in";
  EXPECT_EQ(configurationCheck("here.toml", now).state, CheckState::kNotApplicable) << "where the daemon was started";
  EXPECT_EQ(configurationCheck(file, now).state, CheckState::kRed) << "gone";
  write("/hapticd.toml", "[servo]");
  std::filesystem::last_write_time(file, std::filesystem::file_time_type::clock::now() - 100h);
  EXPECT_EQ(configurationCheck(file, std::nullopt).state, CheckState::kNotApplicable);
  EXPECT_EQ(configurationCheck(file, now + 1h).state, CheckState::kGreen);
  const HostCheck edited = configurationCheck(file, now - 1h);
  EXPECT_EQ(edited.state, CheckState::kRed) << "an older file was put in its place";
  EXPECT_NE(edited.detail.find(file), std::string::npos) << edited.detail;
  EXPECT_NE(edited.remedy.find("--check-config --config " + file), std::string::npos) << edited.remedy;
}

TEST(StartOf, IsWhenTheProcessWasForked) {
  using std::chrono_literals::operator""ms;
  constexpr auto kTicks = 50ms;  // It is counted in some of ten milliseconds.
  const auto before = std::chrono::system_clock::now();
  hapticd::test::ChildProcess child([](auto) { ::pause(); });
  const auto after = std::chrono::system_clock::now();
  const auto start = startOf(child.pid());
  ASSERT_TRUE(start.has_value());
  EXPECT_GE(*start, before - kTicks);
  EXPECT_LE(*start, after + kTicks);
  EXPECT_FALSE(startOf(0).has_value());
}

}  // namespace
}  // namespace hapticctl
