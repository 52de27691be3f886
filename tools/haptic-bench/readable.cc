#include "tools/haptic-bench/readable.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace haptic_bench {

Readable readable(const std::string& unit, double value) {
  static const std::vector<std::string> kKinds[] = {
      {"ns", "us", "ms", "s"}, {"um", "mm", "m"}, {"uJ", "mJ", "J"}, {"byte", "kB", "MB", "GB"}};
  for (const std::vector<std::string>& kind : kKinds) {  // Each a thousand times the one before.
    auto at = std::find(kind.begin(), kind.end(), unit);
    if (at == kind.end()) continue;
    double size = std::abs(value), factor = 1;
    for (; size >= 9999.5 && std::isfinite(size) && at + 1 != kind.end(); ++at) size /= 1e3, factor /= 1e3;
    for (; size < 0.1 && size > 0 && at != kind.begin(); --at) size *= 1e3, factor *= 1e3;
    return {*at, factor};
  }
  return {unit, 1};
}

}  // namespace haptic_bench
