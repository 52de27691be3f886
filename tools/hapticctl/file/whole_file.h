/** @file
 * A file that a command makes for its user, there whole or not at all.
 */
#pragma once

#include <cstdint>
#include <string>

namespace hapticctl {

/**
 * What is written stands beside it until keep(): without that nothing is left, and one that was there before is as it
 * was. A device or a pipe is written itself. Throws Failure if the file is there already and not to be replaced.
 */
class WholeFile {
 public:
  WholeFile(const std::string& path, bool replace);
  ~WholeFile();
  WholeFile(const WholeFile&) = delete;
  WholeFile& operator=(const WholeFile&) = delete;

  /** 0, or errno; gives up, with some error, at a signal that asks the command to end. */
  [[nodiscard]] int write(const char* data, std::size_t size);
  /** On the disk and in its place; 0, or errno: EEXIST if another came there meanwhile that is not to be replaced. */
  [[nodiscard]] int keep();
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }

 private:
  std::string path_, part_;  ///< No part: written itself.
  bool replace_;
  int fd_ = -1;
  std::uint64_t bytes_ = 0;
};

}  // namespace hapticctl
