/** @file
 * The six levels of load of figure 5.11, for today: what else the machine does while a hand feels.
 */
#pragma once

#include <array>
#include <string>
#include <vector>

#include "tools/haptic-bench/load/child.h"

namespace haptic_bench {

enum class Level { kIdle, kGraphics, kUploads, kClients, kDisk, kBusy };
inline constexpr std::array<Level, 6> kLevels{Level::kIdle,    Level::kGraphics, Level::kUploads,
                                              Level::kClients, Level::kDisk,     Level::kBusy};

[[nodiscard]] const char* nameOf(Level level);

/** `folder`, or /var/tmp where that one lies in memory: what is written there never reaches a disk. */
[[nodiscard]] std::string folderOnDisk(const std::string& folder);

/**
 * Starts the processes of a level. They load the daemon on `socket`, write to a file in `folder`, and go on until the
 * handles go; one that cannot says so on the standard error and ends.
 *
 * graphics  reads the hand's state at 60 Hz and fills pixels for three quarters of each frame
 * uploads   uploads meshes of 64 k triangles, one after the other, and drops them
 * clients   four programs that read the state and push at 1 kHz
 * disk      writes 4 MB at a time and waits until they are on the disk
 * busy      a loop on each processor
 */
[[nodiscard]] std::vector<Child> startLoad(Level level, const std::string& socket, const std::string& folder);

}  // namespace haptic_bench
