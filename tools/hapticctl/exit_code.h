/** @file
 * How hapticctl ends. Documented in hapticctl(1) and at the foot of --help; scripts rely on the numbers.
 */
#pragma once

namespace hapticctl {

enum ExitCode : int {
  kExitOk = 0,
  kExitRefused = 1,       ///< The daemon refused, or a check of doctor is red.
  kExitUsage = 2,         ///< The command line is wrong.
  kExitNoDaemon = 3,      ///< No daemon answers on the socket.
  kExitDisconnected = 4,  ///< The daemon went away while it was needed.
  kExitFile = 5,          ///< A file cannot be read, or holds nothing usable.
};

}  // namespace hapticctl
