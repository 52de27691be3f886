/** @file
 * Faults of a played device, by its own clock.
 */
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "rt/base/error.h"

namespace haptic_emu {

enum class FaultKind : std::uint8_t {
  kSilence,      ///< Takes what comes and answers nothing.
  kGarbage,      ///< Random bytes among what it says.
  kTruncation,   ///< Answers lack their end.
  kWrongEcho,    ///< What it repeats is not what it was told.
  kEncoderJump,  ///< An encoder far from where it was: a place that cannot be.
  kUnplug,       ///< Not on the bus; its power is gone too.
};
inline constexpr std::string_view kFaultNames[] = {"silence",    "garbage",      "truncation",
                                                   "wrong-echo", "encoder-jump", "unplug"};

struct Fault {
  FaultKind kind = FaultKind::kSilence;
  std::int64_t from_ns = 0, to_ns = 0;
};

/** "silence@0.5+0.1": from 0.5 s on, for 0.1 s; without "+" for good. */
[[nodiscard]] hapticd::Result<Fault> parseFault(std::string_view text);

/** What goes wrong and when. */
class FaultPlan {
 public:
  void add(const Fault& fault) { faults_.push_back(fault); }
  void clear() { faults_.clear(); }
  [[nodiscard]] bool active(FaultKind kind, std::int64_t t_ns) const {
    for (const Fault& fault : faults_) {
      if (fault.kind == kind && t_ns >= fault.from_ns && t_ns < fault.to_ns) return true;
    }
    return false;
  }

 private:
  std::vector<Fault> faults_;
};

/** Numbers that look random and repeat: a linear congruence (Knuth, MMIX). */
class Noise {
 public:
  explicit Noise(std::uint64_t seed) : state_(seed) {}
  [[nodiscard]] std::uint8_t byte() {
    state_ = state_ * 6364136223846793005u + 1442695040888963407u;
    return static_cast<std::uint8_t>(state_ >> 56);
  }

 private:
  std::uint64_t state_;
};

}  // namespace haptic_emu
