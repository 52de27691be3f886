/** @file
 * Processes of a benchmark: they end with their handle, and with the benchmark however that ends.
 */
#pragma once

#include <sys/types.h>

#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace haptic_bench {

/** A process. Start it while this program has one thread only. */
class Child {
 public:
  /** Runs `body` in a fork of this program. */
  explicit Child(const std::function<void()>& body);
  /** Runs a program; its output goes to the file `log`. */
  Child(std::vector<std::string> command, const std::string& log);
  Child(Child&& other) noexcept : pid_(std::exchange(other.pid_, -1)) {}
  Child& operator=(Child&&) = delete;
  ~Child() { stop(); }

  [[nodiscard]] bool running();
  /** SIGTERM, after five seconds SIGKILL, and waits. */
  void stop();

 private:
  pid_t pid_ = -1;
};

/** A directory for sockets and files, gone with its handle. */
class ScratchDirectory {
 public:
  ScratchDirectory();
  ScratchDirectory(const ScratchDirectory&) = delete;
  ScratchDirectory& operator=(const ScratchDirectory&) = delete;
  ~ScratchDirectory();
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

}  // namespace haptic_bench
