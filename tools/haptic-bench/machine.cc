#include "tools/haptic-bench/machine.h"

#include <fmt/format.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <fstream>

namespace haptic_bench {
namespace {

/** First line of a file; "unknown" when it is not there. */
std::string firstLine(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  return std::getline(file, line) && !line.empty() ? line : "unknown";
}

/** The value of a "name : value" line of /proc/cpuinfo. */
std::string cpuInfo(const std::string& name) {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    const std::size_t colon = line.find(": ");
    if (colon != std::string::npos && line.compare(0, name.size(), name) == 0) return line.substr(colon + 2);
  }
  return "";
}

std::string preemption(const utsname& kernel) {
  if (firstLine("/sys/kernel/realtime") == "1") return "PREEMPT_RT";
  const std::string version = kernel.version;
  for (const char* name : {"PREEMPT_DYNAMIC", "PREEMPT"}) {
    if (version.find(name) != std::string::npos) return name;
  }
  return "voluntary or none";
}

}  // namespace

std::vector<std::string> describeMachine() {
  utsname kernel{};
  uname(&kernel);
  std::string cpu = cpuInfo("model name");
  if (cpu.empty()) {  // Kernels for ARM name no processor, but most the board; with a zero byte at the end.
    const std::string board = firstLine("/proc/device-tree/model");
    cpu = board == "unknown" ? kernel.machine : board.c_str();
  }
  const bool hypervisor = cpuInfo("flags").find("hypervisor") != std::string::npos;
  return {
    fmt::format("cpu: {}, {} online{}", cpu, sysconf(_SC_NPROCESSORS_ONLN), hypervisor ? ", virtual machine" : ""),
        fmt::format("kernel: {} {} {}, {}", kernel.sysname, kernel.release, kernel.machine, preemption(kernel)),
        fmt::format("governor: {}", firstLine("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor")),
        fmt::format("clock source: {}", firstLine("/sys/devices/system/clocksource/clocksource0/current_clocksource")),
        fmt::format("load: {}", firstLine("/proc/loadavg")),
#if defined(__clang__)
        fmt::format("build: clang {}, {}", __clang_version__, HAPTICD_BUILD_FLAGS),
#else
        fmt::format("build: gcc {}, {}", __VERSION__, HAPTICD_BUILD_FLAGS),
#endif
  };
}

}  // namespace haptic_bench
