/** @file
 * What was made of an image, to files and to hapticctl load.
 */
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace hapticctl_import {

/**
 * A file that goes when it is no longer needed, also by Ctrl-C, SIGTERM and SIGHUP, unless they are ignored, whose
 * handlers it takes: kMost at a time.
 */
class TemporaryFile {
 public:
  static constexpr std::size_t kMost = 2;
  /** For another program to read. Throws ImportError. */
  TemporaryFile();
  /** With a name of its own for the XXXXXX in it, so many letters before its end; fd() is -1 if it cannot be made. */
  explicit TemporaryFile(std::string pattern, int letters_behind = 0);
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile();
  [[nodiscard]] const std::string& path() const { return path_; }
  /** To write to, and to close. */
  [[nodiscard]] int fd() const { return fd_; }
  /** From now on it is this file, which it replaces. 0, or what went wrong. */
  [[nodiscard]] int becomes(const std::string& path);

 private:
  std::string path_;
  int fd_ = -1;
  std::size_t slot_ = kMost;  ///< Where handlers find its name.
  std::array<void (*)(int), 3> before_{};
};

/**
 * A file of which all is written before it takes its place: of several none takes its own where one does not fit. Only
 * a device, a pipe, a link to what is not there yet and a file in a folder that may not be written are written in their
 * place, by keep().
 */
class PreparedFile {
 public:
  /** Throws ImportError that says why. */
  PreparedFile(std::string path, std::string bytes);
  /** The same. */
  void keep();

 private:
  std::string path_, bytes_;
  std::optional<TemporaryFile> part_;  ///< None: it is written in its place.
};

/** Whether two names are those of one file, be it there or not. */
[[nodiscard]] bool areOneFile(const std::string& a, const std::string& b);
/** Throws ImportError that says why, if a file cannot be written there; makes none. To be asked before the long work.
 */
void requireWritable(const std::string& path);
/** Throws ImportError if the name's ending says another format than what will be in the file: `ending`, as ".ply". */
void requireEnding(const std::string& path, const std::string& ending);
/** As it goes. Throws ImportError that says why. */
void writeInPlace(const std::string& path, const std::string& bytes);
/** A PreparedFile alone: on ImportError, which says why, what was there before is there still. */
void writeFile(const std::string& path, const std::string& bytes);

/** Throws ImportError unless all that was printed is out, or the reader of standard output has gone. */
void requireSaid();

/**
 * Runs hapticctl, the one that called this program (HAPTICCTL), or beside it or on PATH, and gives its exit code. What
 * asks this program to end, but for SIGKILL, is handed on to it: it ends in its order. Throws ImportError if there is
 * none.
 */
int runHapticctl(const std::vector<std::string>& words);

}  // namespace hapticctl_import
