/** @file
 * The one exception of hapticctl: why a command ends early. main() prints it and exits with its code.
 */
#pragma once

#include <string>

#include "tools/hapticctl/exit_code.h"

namespace hapticctl {

/** A reason to stop, said the way the daemon says its own: where, what, remedy. */
struct Failure {
  ExitCode exit = kExitRefused;
  std::string where;      ///< File, option, path or device at fault; may be empty.
  std::string what;       ///< What is wrong with it.
  std::string remedy;     ///< What to do about it; may be empty.
  std::string code = "";  ///< Name in proto/errors.h when the daemon or the library refused.
};

/** The option `where` has a value that cannot be. */
[[noreturn]] void failUsage(std::string where, std::string what, std::string remedy = {});

}  // namespace hapticctl
