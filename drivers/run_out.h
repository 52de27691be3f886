/** @file
 * What to do where the process or the machine has no more of something.
 */
#pragma once

#include <cerrno>

namespace hapticd {

/** Null for an errno that is no want. */
[[nodiscard]] inline const char* remedyForWant(int number) noexcept {
  switch (number) {
    case EMFILE:
      return "end clients, or raise LimitNOFILE= or ulimit -n";
    case ENFILE:
      return "end programs, or raise fs.file-max";
    case ENOMEM:
      return "end programs, or raise MemoryMax= or ulimit -v";
    default:
      return nullptr;
  }
}

}  // namespace hapticd
