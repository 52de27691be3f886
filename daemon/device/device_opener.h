/** @file
 * Opens devices aside from the control thread, each on a thread of its own.
 */
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "rt/device.h"

namespace hapticd {

/** Control thread only. */
class DeviceOpener {
 public:
  /** Open, or why not. */
  using Opened = Result<std::unique_ptr<Device>>;
  using Done = std::function<void(Opened)>;

  DeviceOpener() = default;
  DeviceOpener(const DeviceOpener&) = delete;
  DeviceOpener& operator=(const DeviceOpener&) = delete;
  /** Gives up what is under way, waits for it, however long, and closes what opened all the same. */
  ~DeviceOpener();

  struct Stopped {
    std::vector<std::unique_ptr<Device>> open;  ///< What opened all the same: to be closed.
    std::vector<std::string> stuck;             ///< URIs of those that stay here: their open() has not returned.
  };
  /** Gives up what is under way, for all of which it has so much Patience; `done` is not called. */
  [[nodiscard]] Stopped stop(std::int64_t patience_ns);

  /** Calls device->open() on a thread of its own; `done` is called by poll() when it has returned. */
  void start(std::unique_ptr<Device> device, Done done);
  void poll();
  [[nodiscard]] std::size_t size() const { return running_.size(); }

 private:
  struct Running {
    std::unique_ptr<Device> device;
    std::string uri;  ///< The thread alone may ask the device.
    Done done;
    Result<void> result;
    std::atomic<bool> finished{false};
    std::thread thread;
  };
  void giveUp();
  std::list<Running> running_;
};

}  // namespace hapticd
