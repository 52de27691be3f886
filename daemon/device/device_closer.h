/** @file
 * Closes devices aside from the control thread: a driver that never returns from close(), as with a transfer that the
 * kernel never ends, must not hold up everybody else's device.
 */
#pragma once

#include <atomic>
#include <cstdint>
#include <list>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "daemon/device/device_group.h"

namespace hapticd {

/** Control thread only. */
class DeviceCloser {
 public:
  DeviceCloser() = default;
  DeviceCloser(const DeviceCloser&) = delete;
  DeviceCloser& operator=(const DeviceCloser&) = delete;
  /** Waits for all, however long. */
  ~DeviceCloser();

  /**
   * safe() for each at once, then close() one after the other, on a thread, for which it has so much Patience.
   * Those that are not closed by then stay here, held for the last resort: their URIs, of which the first is what holds
   * up the others.
   */
  std::vector<std::string> close(DeviceGroup::Leaving leaving, std::int64_t patience_ns);
  /** Forgets what has closed meanwhile; their URIs. */
  std::vector<std::string> poll();
  /** Whether that device is here. */
  [[nodiscard]] bool has(std::string_view uri) const;
  /** Groups that are here. */
  [[nodiscard]] std::size_t size() const { return closing_.size(); }
  /** Devices that are here. */
  [[nodiscard]] std::vector<std::string> names() const;

 private:
  struct Closing {
    DeviceGroup::Leaving group;
    std::vector<std::string> uris;  ///< The thread alone may ask the devices.
    std::atomic<std::size_t> closed{0};
    std::thread thread;
  };
  std::list<Closing> closing_;
};

}  // namespace hapticd
