/** @file
 * How long somebody is waited for who may never come.
 */
#pragma once

#include <cstdint>

#include "rt/base/clock.h"

namespace hapticd {

/**
 * So much time, but also so many looks: where the whole machine has stood still, as a virtual one does now and then,
 * whoever is waited for had none of that time either.
 */
class Patience {
 public:
  static constexpr int kLooks = 100;
  static constexpr std::int64_t kLook_ns = 200'000;

  Patience(Clock& clock, std::int64_t most_ns) : clock_(clock), end_ns_(clock.now() + most_ns) {}

  /** Looks again and again until `done()`. False: it was not, and the next call looks once. */
  template <class Done>
  [[nodiscard]] bool until(Done&& done) {
    while (!done()) {
      const std::int64_t now_ns = clock_.now();
      if (looks_ >= kLooks && now_ns >= end_ns_) return false;
      ++looks_;
      clock_.sleepUntil(now_ns + kLook_ns);
    }
    return true;
  }

 private:
  Clock& clock_;
  std::int64_t end_ns_;
  int looks_ = 0;
};

}  // namespace hapticd
