/** @file
 * Everything that enters one cycle. The same sequence of CycleInputs gives the same forces, bit for bit on one build.
 */
#pragma once

#include <array>
#include <cstdint>

#include "rt/command.h"
#include "rt/device.h"

namespace hapticd {

inline constexpr std::uint32_t kControlCommandsPerCycle = 16;
inline constexpr std::uint32_t kIngestCommandsPerCycle = 48;
inline constexpr std::uint32_t kCollideCommandsPerCycle = 8;
inline constexpr std::uint32_t kMaxCommandsPerCycle =
    kControlCommandsPerCycle + kIngestCommandsPerCycle + kCollideCommandsPerCycle;

struct CycleInput {
  std::uint64_t tick = 0;    ///< Counts periods, missed ones included.
  std::int64_t now_ns = 0;   ///< Nominal start of the period: deadlines are multiples of it.
  std::uint32_t missed = 0;  ///< Periods skipped just before this one.
  bool stop_line = false;    ///< Emergency stop open.
  bool deadman_open = false;
  std::array<DeviceSample, kMaxDevices> device;
  std::uint32_t command_count = 0;
  std::array<Command, kMaxCommandsPerCycle> command;
};

}  // namespace hapticd
