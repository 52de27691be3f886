/** @file
 * A result that appears whole or not at all.
 */
#pragma once

#include <csignal>
#include <string>

namespace haptic_bench {

/**
 * Stands for a file while it is being written under another name beside it: what was there before stays until keep(),
 * and its rights for longer; a link stays one. What is no regular file (/dev/stdout) is written itself.
 */
class WholeFile {
 public:
  /** Throws Failure at once where nothing can be written, not when the results are there. */
  explicit WholeFile(std::string path);
  WholeFile(const WholeFile&) = delete;
  WholeFile& operator=(const WholeFile&) = delete;
  /** Leaves nothing of what was not kept; nor does Ctrl-C, SIGTERM or SIGHUP. */
  ~WholeFile();

  /** Where to write. */
  [[nodiscard]] const std::string& part() const { return part_; }
  /** Gives it its name, once it is written and closed. Throws Failure. */
  void keep();

 private:
  std::string path_, part_;
  struct sigaction before_[3] = {};  ///< What else the signals would do.
};

/** Throws Failure where `output` is the file `input`, which would be lost. */
void refuseToReplace(const std::string& input, const std::string& output);

}  // namespace haptic_bench
