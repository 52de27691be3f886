/** @file
 * A device that holds memory while it is open, as one with a recorded motion.
 */
#pragma once

#include <atomic>
#include <cstddef>
#include <memory>
#include <string>
#include <utility>

#include "drivers/link/holds_memory.h"
#include "tests/session/still_device.h"

namespace hapticd::test {

class HoldingDevice final : public StillDevice, public HoldsMemory {
 public:
  HoldingDevice(std::string uri, std::size_t bytes, std::shared_ptr<std::atomic<int>> open)
      : StillDevice("holding", std::move(uri)), bytes_(bytes), open_(std::move(open)) {}
  Result<void> open() override {
    ++*open_;
    return {};
  }
  void giveUp() noexcept override {}
  void close() noexcept override { --*open_; }
  [[nodiscard]] std::size_t heldBytes() const noexcept override { return bytes_; }

 private:
  std::size_t bytes_;
  std::shared_ptr<std::atomic<int>> open_;
};

}  // namespace hapticd::test
