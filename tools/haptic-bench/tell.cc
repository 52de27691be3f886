#include "tools/haptic-bench/tell.h"

#include <fmt/format.h>

#include <cstdio>
#include <set>

namespace haptic_bench {

void tellOnce(const std::string& line) {
  static std::set<std::string> told;
  if (told.insert(line).second) fmt::print(stderr, "haptic-bench: {}\n", line);
}

}  // namespace haptic_bench
