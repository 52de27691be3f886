/** @file
 * The command line of hapticd.
 */
#pragma once

#include <optional>
#include <string>

#include "daemon/config/config.h"

namespace hapticd {

/** What hapticd ends with; systemd and scripts read it. */
enum ExitCode : int {
  kExitOk = 0,
  kExitUsage = 1,
  kExitConfig = 2,      ///< The configuration is wrong or missing.
  kExitNoRealtime = 3,  ///< Real-time rights are missing.
  kExitDevice = 4,      ///< A configured device could not be opened.
  kExitSocket = 5,      ///< Another daemon serves the socket, or it cannot be made.
  kExitFailure = 6,     ///< Anything else.
};

struct Options {
  LoadedConfig loaded;         ///< With the command line's changes in it.
  bool devices_named = false;  ///< On the command line.
  bool check_config = false;
  bool print_config = false;
};

/** Prints what was asked for. How to end: not everybody who redirects looks at the disk. */
[[nodiscard]] int answer(const std::string& text);

/** Reads the command line and the configuration it names. On a refusal or --help, `exit_code` says how to end. */
[[nodiscard]] std::optional<Options> readOptions(int argc, char** argv, int& exit_code);

/** Whether there is the group that the control socket is for; else also where the file names it. */
[[nodiscard]] Result<void> checkGroup(const LoadedConfig& loaded);

}  // namespace hapticd
