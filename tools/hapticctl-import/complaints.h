/** @file
 * What libraries write to the standard error stream while they read.
 */
#pragma once

#include <string>

namespace hapticctl_import {

/** From now on it is kept from the terminal; until destruction. For programs of one thread. */
class Complaints {
 public:
  Complaints();
  Complaints(const Complaints&) = delete;
  Complaints& operator=(const Complaints&) = delete;
  ~Complaints();
  /** The first line of what was written, at most 200 printable characters; empty: nothing. */
  [[nodiscard]] std::string first() const;
  /** Whether a phrase stands in the first 64 kB of it. */
  [[nodiscard]] bool hold(const std::string& phrase) const;

 private:
  [[nodiscard]] std::string text(std::size_t most) const;

  int file_ = -1, terminal_ = -1;
};

}  // namespace hapticctl_import
