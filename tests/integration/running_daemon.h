/** @file
 * A whole daemon on sockets of its own: Core, servo threads, event loop, in one thread of the test program.
 */
#pragma once

#include <future>
#include <string>
#include <thread>

#include "daemon/config/config.h"
#include "tests/support/process/temporary_directory.h"

namespace hapticd {
class Core;
}

namespace hapticd::test {

class RunningDaemon {
 public:
  /** Runs without real-time scheduling unless the configuration says otherwise. */
  explicit RunningDaemon(Config config = simulated());
  ~RunningDaemon();
  RunningDaemon(const RunningDaemon&) = delete;
  RunningDaemon& operator=(const RunningDaemon&) = delete;

  /** One simulated device, no rights needed. */
  static Config simulated();

  [[nodiscard]] std::string control() const { return directory_.path() + "/control.sock"; }
  [[nodiscard]] std::string admin() const { return directory_.path() + "/admin.sock"; }
  [[nodiscard]] const std::string& directory() const { return directory_.path(); }

 private:
  void run(const Config& config, std::promise<void>& ready);

  TemporaryDirectory directory_;
  int stop_[2] = {-1, -1};
  std::thread thread_;
};

}  // namespace hapticd::test
