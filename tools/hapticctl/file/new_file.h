/** @file
 * A file that a command fills for its user as time goes on.
 */
#pragma once

#include <cstdint>
#include <string>

namespace hapticctl {

/**
 * It goes again if nothing comes to stand in it; one that was there and is to be replaced keeps what it holds until the
 * first byte is written. Throws Failure if it is there already and not to be replaced.
 */
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
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }

 private:
  std::string path_;
  int fd_ = -1;
  bool file_ = false;    ///< No device and no pipe, which were there before and stay.
  bool before_ = false;  ///< It holds what it held before.
  std::uint64_t bytes_ = 0;
};

/** The file cannot be made; `error` is errno. */
[[noreturn]] void failMaking(const std::string& file, int error);
/** The file could not be written whole; `error` is errno. */
[[noreturn]] void failWriting(const std::string& file, int error);

}  // namespace hapticctl
