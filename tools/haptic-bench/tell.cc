#include "tools/haptic-bench/tell.h"

#include <fmt/format.h>

#include <chrono>
#include <set>

#include "rt/base/standard_streams.h"

namespace haptic_bench {

void tellOnce(const std::string& line) {
  static std::set<std::string> told;
  if (told.insert(line).second) hapticd::tellError(fmt::format("haptic-bench: {}\n", line));
}

void tellTime(const std::string& what) {
  static const auto start = std::chrono::steady_clock::now();
  const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start;
  hapticd::tellError(fmt::format("{:5.0f} s  {}\n", passed.count(), what));
}

}  // namespace haptic_bench
