/** @file
 * A file that a command makes for its user.
 */
#pragma once

#include <cstdint>
#include <string>

namespace hapticctl {

/** It goes again if nothing comes to stand in it. Throws Failure if it is there already and not to be replaced. */
class NewFile {
 public:
  NewFile(const std::string& path, bool replace);
  ~NewFile();
  NewFile(const NewFile&) = delete;
  NewFile& operator=(const NewFile&) = delete;

  /** 0, or errno. */
  [[nodiscard]] int write(const char* data, std::size_t size);
  /** On the disk; 0, or errno. */
  [[nodiscard]] int sync() const;
  /** What is in it is not to stay. */
  void drop() { bytes_ = 0; }
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }

 private:
  std::string path_;
  int fd_ = -1;
  std::uint64_t bytes_ = 0;
};

}  // namespace hapticctl
