/** @file
 * Where haptic-bench finds what belongs to it: in a build, in an installation, wherever either has been moved to.
 */
#pragma once

#include <initializer_list>
#include <string>

namespace haptic_bench {

/** Of these paths, each from the program's own folder, the first that is there; "" if none is. */
[[nodiscard]] std::string besideProgram(std::initializer_list<const char*> paths);

/** A file of tools/haptic-bench ("report/report.py"), in a build or installed. Throws Failure if it is not there. */
[[nodiscard]] std::string ownFile(const std::string& name);

}  // namespace haptic_bench
