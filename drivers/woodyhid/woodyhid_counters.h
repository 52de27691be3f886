/** @file
 * Whether the counters of a board may still be what an earlier session has set them to.
 */
#pragma once

#include <atomic>
#include <list>
#include <memory>
#include <mutex>
#include <string>

#include "drivers/hid/transport.h"

namespace hapticd {

/** One board from when it was plugged in until it is unplugged. */
struct WoodyPlugged {
  std::string device, plugging;
  std::atomic<bool> lost{false};  ///< Its counters mean nothing until it is calibrated.
};

/**
 * The boards that this process has opened, longer than it has them open: the user's word for counters of an earlier
 * session is good for one that got its power before. Any thread.
 */
class WoodyCounters {
 public:
  /**
   * Of what is plugged in: the same as long as it is, and lost from the start where its like was seen before, but for
   * what is there beside it.
   */
  [[nodiscard]] std::shared_ptr<WoodyPlugged> of(const HidPlugged& plugged);

 private:
  static constexpr std::size_t kMostOfOne = 16;  ///< One with a bad contact comes and goes for ever.

  std::mutex mutex_;
  std::list<std::shared_ptr<WoodyPlugged>> seen_;
};

}  // namespace hapticd
