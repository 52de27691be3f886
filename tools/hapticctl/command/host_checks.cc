#include "tools/hapticctl/command/host_checks.h"

#include <fmt/format.h>
#include <grp.h>
#include <pwd.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/utsname.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>

#include "tools/hapticctl/numbers.h"

namespace hapticctl {
namespace {

using enum CheckState;

/** First line of a file; nothing where it cannot be read. */
std::optional<std::string> firstLine(const HostView& view, const std::string& path) {
  std::ifstream file(view.root + path);
  std::string line;
  if (!std::getline(file, line)) return std::nullopt;
  return line;
}

/** The word in brackets of "always [madvise] never", or of "none voluntary (full)": the kernel writes either. */
std::string selected(const std::string& line) {
  const auto open = line.find_first_of("[("), close = line.find_first_of("])");
  return open == std::string::npos || close == std::string::npos ? line : line.substr(open + 1, close - open - 1);
}

/** How the kernel was told to preempt when it was booted; nothing where it was not. */
std::optional<std::string> bootedPreemption(const HostView& view) {
  std::istringstream words(firstLine(view, "/proc/cmdline").value_or(""));
  std::optional<std::string> mode;
  for (std::string word; words >> word;)
    if (word.rfind("preempt=", 0) == 0) mode = word.substr(8);  // The last one holds.
  return mode;
}

HostCheck kernelPreemption(const HostView& view) {
  utsname name{};
  uname(&name);
  const std::string version = view.kernel_version.empty() ? name.version : view.kernel_version;
  HostCheck out{"kernel preemption", kGreen, {}, {}};
  if (firstLine(view, "/sys/kernel/realtime").value_or("0") == "1" || version.find("PREEMPT_RT") != std::string::npos) {
    out.detail = fmt::format("PREEMPT_RT ({})", name.release);
    return out;
  }
  const auto debug = firstLine(view, "/sys/kernel/debug/sched/preempt");  // Root's alone.
  const std::string mode = debug ? selected(*debug)
                           : version.find("PREEMPT_DYNAMIC") != std::string::npos
                               ? bootedPreemption(view).value_or("dynamic")
                           : version.find("PREEMPT") != std::string::npos ? "full"
                                                                          : "voluntary or none";
  out.state = mode == "full" ? kGreen : kRed;
  out.detail = fmt::format("preemption {} ({}); a real-time kernel keeps 1 kHz under load", mode, name.release);
  out.remedy = "apt install linux-image-rt-" +
               std::string(std::string_view(name.machine) == "x86_64" ? "amd64" : "arm64") + " && reboot";
  return out;
}

HostCheck governor(const HostView& view) {
  HostCheck out{"CPU frequency governor", kNotApplicable, "this machine does not scale its CPUs", {}};
  const std::filesystem::path cpus = view.root + "/sys/devices/system/cpu";
  std::error_code error;
  std::string other;
  std::size_t seen = 0;
  for (const auto& entry : std::filesystem::directory_iterator(cpus, error)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with("cpu") || name.find_first_not_of("0123456789", 3) != std::string::npos || name.size() == 3)
      continue;
    if (const auto mode = firstLine(view, "/sys/devices/system/cpu/" + name + "/cpufreq/scaling_governor")) {
      ++seen;
      if (*mode != "performance") other = *mode;
    }
  }
  if (seen == 0) return out;
  out.state = other.empty() ? kGreen : kRed;
  out.detail = other.empty() ? fmt::format("performance on {} CPUs", seen) : other;
  out.remedy = "echo performance | tee /sys/devices/system/cpu/cpu*/cpufreq/scaling_governor";
  return out;
}

HostCheck dmaLatency(const HostView& view) {
  const std::string path = "/dev/cpu_dma_latency";
  HostCheck out{"CPU sleep states", kGreen, path + " can be held", {}};
  if (access((view.root + path).c_str(), F_OK) != 0)
    return {out.name, kNotApplicable, "this kernel has no " + path, {}};
  if (access((view.root + path).c_str(), W_OK) != 0) {
    out.state = kRed;
    out.detail = path + " is not writable for this user: deep sleep delays the servo";
    out.remedy =
        "chgrp haptic /dev/cpu_dma_latency && chmod 660 /dev/cpu_dma_latency   (the installed udev rule does it)";
  }
  return out;
}

/** Raises a limit of the group. The package's file grants both already, to who logs in as a member. */
HostCheck limitOf(const HostView& view, const char* name, int resource, rlim_t wanted, const std::string& shown_wanted,
                  const char* item) {
  const std::string file = "/etc/security/limits.d/hapticd.conf";
  std::ifstream there(view.root + file);
  bool granted = false;
  for (std::string line; std::getline(there, line);) granted |= line.rfind(item, 0) == 0;
  const passwd* user = getpwuid(geteuid());
  const std::string fix = granted ? fmt::format("adduser {} haptic   (then log in anew: {} grants it)",
                                                user != nullptr ? user->pw_name : "USER", file)
                                  : fmt::format("echo '{}' >> {}   (then log in anew)", item, file);
  rlimit limit{};
  getrlimit(static_cast<__rlimit_resource>(resource), &limit);
  const auto show = [&](rlim_t value) {
    if (value == RLIM_INFINITY) return std::string("unlimited");
    return resource == RLIMIT_MEMLOCK ? bytes(value) : std::to_string(value);
  };
  const bool enough = geteuid() == 0 || limit.rlim_max == RLIM_INFINITY || limit.rlim_max >= wanted;
  HostCheck out{name, enough ? kGreen : kRed, {}, fix};
  out.detail =
      geteuid() == 0 ? "root may without a limit" : fmt::format("{} (wanted {})", show(limit.rlim_max), shown_wanted);
  return out;
}

HostCheck groupMembership() {
  HostCheck out{"group haptic", kGreen, {}, {}};
  if (geteuid() == 0) return {out.name, kNotApplicable, "root needs no group", {}};
  const group* haptic = getgrnam("haptic");
  const passwd* user = getpwuid(geteuid());
  const std::string join =
      fmt::format("adduser {} haptic   (then log in anew)", user != nullptr ? user->pw_name : "USER");
  if (haptic == nullptr) {  // As where it was installed into a folder: what is given to the group reaches nobody.
    return {out.name, kRed, "no such group: the hapticd package makes it", "groupadd --system haptic && " + join};
  }
  const gid_t wanted = haptic->gr_gid;
  std::vector<gid_t> groups(static_cast<std::size_t>(std::max(getgroups(0, nullptr), 0)));
  const int n = getgroups(static_cast<int>(groups.size()), groups.data());
  groups.resize(static_cast<std::size_t>(std::max(n, 0)));
  if (getegid() == wanted || std::find(groups.begin(), groups.end(), wanted) != groups.end()) {
    out.detail = "this user is in it";
  } else {
    out.state = kRed;
    out.detail = "this user is not in it: devices and the system daemon's socket are closed";
    out.remedy = join;
  }
  return out;
}

/** A tunable under /proc or /sys that should have one of some values. */
HostCheck tunable(const HostView& view, const char* name, const std::string& path, bool (*good)(const std::string&),
                  const char* why, const std::string& remedy) {
  const auto line = firstLine(view, path);
  if (!line) return {name, kNotApplicable, "this kernel has no " + path, {}};
  const std::string value = selected(*line);
  const bool ok = good(value);
  return {name, ok ? kGreen : kRed, ok ? value : fmt::format("{}: {}", value, why), remedy};
}

bool isZero(const std::string& value) { return value == "0"; }
bool leavesRoom(const std::string& value) { return value == "-1" || (value != "0" && value.size() > 5); }
bool notAlways(const std::string& value) { return value != "always"; }

/** The v1 "cpu" controller's group of this process, "/" where it is not told. */
std::string cpuGroup(const HostView& view) {
  std::ifstream file(view.root + "/proc/self/cgroup");
  for (std::string line; std::getline(file, line);) {  // "4:cpu,cpuacct:/user.slice"
    const auto first = line.find(':'), second = line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string controllers = "," + line.substr(first + 1, second - first - 1) + ",";
    if (controllers.find(",cpu,") != std::string::npos) return line.substr(second + 1);
  }
  return "/";
}

HostCheck realtimeGroups(const HostView& view) {
  HostCheck out{"real-time group scheduling", kGreen, "off", {}};
  for (const std::string& mount :
       {std::string("/sys/fs/cgroup/cpu"), std::string("/sys/fs/cgroup/cpu,cpuacct"), std::string("/sys/fs/cgroup")}) {
    const std::string group = mount + cpuGroup(view);
    const auto runtime = firstLine(view, group + (group.ends_with('/') ? "" : "/") + "cpu.rt_runtime_us");
    if (!runtime) continue;
    if (leavesRoom(*runtime)) {
      out.detail = fmt::format("on; this group may use {} us of each period", *runtime);
      return out;
    }
    out.state = kRed;
    out.detail = fmt::format("RT_GROUP_SCHED is on and gives the group {} no real-time time", cpuGroup(view));
    out.remedy = fmt::format("echo 950000 > {}{}cpu.rt_runtime_us", group, group.ends_with('/') ? "" : "/");
    return out;
  }
  return out;
}

HostCheck udevRules(const HostView& view) {
  for (const char* place : {"/etc/udev/rules.d", "/usr/lib/udev/rules.d", "/lib/udev/rules.d"}) {
    std::error_code error;
    for (const auto& entry : std::filesystem::directory_iterator(view.root + place, error)) {
      if (entry.path().filename().string().find("hapticd") != std::string::npos) {
        return {"udev rules", kGreen, entry.path().string().substr(view.root.size()), {}};
      }
    }
  }
  return {"udev rules", kRed, "none: devices belong to root alone",
          "install the hapticd package, or copy its lib/udev/rules.d/*-hapticd.rules to /etc/udev/rules.d"};
}

}  // namespace

std::vector<HostCheck> hostChecks(const HostView& view) {
  return {
      kernelPreemption(view),
      governor(view),
      groupMembership(),  // Before those that are given to it.
      dmaLatency(view),
      limitOf(view, "real-time priority", RLIMIT_RTPRIO, 85, "85", "@haptic - rtprio 85"),
      limitOf(view, "locked memory", RLIMIT_MEMLOCK, rlim_t{512} << 20, "512 MiB", "@haptic - memlock 1048576"),
      tunable(view, "real-time throttling", "/proc/sys/kernel/sched_rt_runtime_us", leavesRoom,
              "leaves the servo too little time", "sysctl -w kernel.sched_rt_runtime_us=950000"),
      realtimeGroups(view),
      tunable(view, "transparent huge pages", "/sys/kernel/mm/transparent_hugepage/enabled", notAlways,
              "the kernel may stop threads to compact memory",
              "echo madvise > /sys/kernel/mm/transparent_hugepage/enabled"),
      tunable(view, "NUMA balancing", "/proc/sys/kernel/numa_balancing", isZero,
              "it unmaps pages to watch them: faults in the servo", "sysctl -w kernel.numa_balancing=0"),
      tunable(view, "compaction of locked pages", "/proc/sys/vm/compact_unevictable_allowed", isZero,
              "moves locked pages: faults in the servo", "sysctl -w vm.compact_unevictable_allowed=0"),
      udevRules(view),
  };
}

std::optional<std::chrono::system_clock::time_point> startOf(int pid) {
  std::ifstream file(fmt::format("/proc/{}/stat", pid));
  std::string line;
  if (!std::getline(file, line)) return std::nullopt;
  constexpr int kStartTime = 22 - 2;  // proc(5), counted from behind the name, which may have blanks in it.
  std::istringstream fields(line.substr(line.rfind(')') + 1));
  std::string field;
  for (int i = 0; i < kStartTime; ++i) fields >> field;
  long long ticks = 0;
  timespec up{};
  if (!fields || std::sscanf(field.c_str(), "%lld", &ticks) != 1 || ::clock_gettime(CLOCK_BOOTTIME, &up) != 0)
    return std::nullopt;
  const double age_s = static_cast<double>(up.tv_sec) + 1e-9 * static_cast<double>(up.tv_nsec) -
                       static_cast<double>(ticks) / static_cast<double>(::sysconf(_SC_CLK_TCK));
  using Clock = std::chrono::system_clock;
  return Clock::now() - std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(age_s));
}

HostCheck configurationCheck(const std::string& file, std::optional<std::chrono::system_clock::time_point> started) {
  constexpr std::chrono::seconds kUntilRead{1};  // What is edited so soon it may have read.
  const auto answer = [](CheckState state, std::string detail, std::string remedy = {}) {
    return HostCheck{"configuration", state, std::move(detail), std::move(remedy)};
  };
  if (file.empty()) return answer(kGreen, "built in");
  if (file[0] != '/' || !started) return answer(kNotApplicable, file + ": whether it was edited is not seen from here");
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0) {
    if (errno != ENOENT && errno != ENOTDIR) return answer(kNotApplicable, file + ": " + std::strerror(errno));
    return answer(kRed, file + ": it is gone since hapticd read it", "put it back, or restart hapticd without it");
  }
  // Of the inode: an older file that is put in its place changes that, too.
  const auto edited =
      std::chrono::system_clock::time_point(std::chrono::duration_cast<std::chrono::system_clock::duration>(
          std::chrono::seconds(status.st_ctim.tv_sec) + std::chrono::nanoseconds(status.st_ctim.tv_nsec)));
  if (edited < *started + kUntilRead) return answer(kGreen, file);
  return answer(kRed, file + ": it was edited since hapticd read it",
                fmt::format("hapticd --check-config --config {}, then restart hapticd", file));
}

const char* stateName(CheckState state) { return state == kGreen ? "green" : state == kRed ? "red" : "not applicable"; }

Json toJson(const std::vector<HostCheck>& checks) {
  Json out = Json::array();
  for (const HostCheck& c : checks) {
    out.push_back({{"name", c.name},
                   {"state", stateName(c.state)},
                   {"detail", c.detail},
                   {"remedy", c.state == kRed ? c.remedy : std::string()}});
  }
  return out;
}

}  // namespace hapticctl
