/** @file
 * For how long a hand may have moved: by that a driver judges whether its device can be where it says.
 */
#pragma once

#include <algorithm>
#include <cstdint>

#include "rt/base/contract.h"

namespace hapticd {

/**
 * A hand goes on while nothing is heard; while what is heard is not believed it gets no more time for a jump, but for
 * the 1 to 5 ms that readings may be apart. One thread, servo-safe.
 */
class HandTime {
 public:
  /** [ms] `since_ns` is the last reading that was believed; of those after it `disbelieved` in a row were not. */
  [[nodiscard]] double ms(std::int64_t since_ns, std::int64_t now_ns, int disbelieved) HD_RT {
    const double since_ms = static_cast<double>(now_ns - since_ns) * 1e-6;
    if (disbelieved == 0) silent_ms_ = since_ms;
    return std::max(std::clamp(since_ms, 1.0, 5.0), silent_ms_);
  }

 private:
  double silent_ms_ = 0;  ///< From the last reading that was believed to the one after it.
};

}  // namespace hapticd
