/** @file
 * A real hapticd on sockets of its own, in a directory of its own, gone when the test is: also when the test crashes.
 * However long a busy machine holds its servo up, that is no fault.
 */
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

#include "tests/support/process/temporary_directory.h"

namespace hapticd::test {

struct DaemonOptions {
  std::string program;                 ///< Path of hapticd; empty: $HAPTICD_PROGRAM.
  std::string device = "sim://";       ///< Empty: what the configuration says.
  std::string config;                  ///< Text of a configuration file without [servo]; empty: built-in defaults.
  std::vector<std::string> arguments;  ///< More, after ours.
};

/** Starts in the constructor; ask running(). One thread. */
class DaemonFixture {
 public:
  explicit DaemonFixture(DaemonOptions options = {});
  ~DaemonFixture();
  DaemonFixture(const DaemonFixture&) = delete;
  DaemonFixture& operator=(const DaemonFixture&) = delete;

  /** True once it has said that it is ready and until it ends. */
  [[nodiscard]] bool running();
  /** Starts it again on the same paths, after kill() or terminate(). True when ready. */
  bool start();
  /** SIGKILL, and waits. */
  void kill();
  /** SIGTERM, and waits; SIGKILL after a minute. Gives the exit code, -1 when a signal ended it. */
  int terminate();
  /** The same. Gives what was wrong with its end, a sanitizer's word too; "" if nothing was. */
  [[nodiscard]] std::string stop();

  [[nodiscard]] pid_t pid() const { return pid_; }
  [[nodiscard]] std::string socket() const { return directory_.path() + "/control.sock"; }
  [[nodiscard]] std::string adminSocket() const { return directory_.path() + "/admin.sock"; }
  [[nodiscard]] const std::string& directory() const { return directory_.path(); }
  /** What it has written so far: what to show when a test fails. */
  [[nodiscard]] std::string log() const;

 private:
  void spawn(int notify);
  bool reap(bool wait);

  DaemonOptions options_;
  TemporaryDirectory directory_;
  pid_t pid_ = -1;
  int status_ = 0;
  std::size_t said_ = 0;  ///< Of its log, before it was started last.
  bool ready_ = false;
};

}  // namespace hapticd::test
