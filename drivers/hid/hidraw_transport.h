/** @file
 * A HID device through hidapi over the kernel's hidraw.
 */
#pragma once

#include "drivers/hid/enumerate.h"
#include "drivers/hid/transport.h"
#include "drivers/link/lent.h"

struct hid_device_;

namespace hapticd {

/** What one of all that were found is known by once it is open. */
[[nodiscard]] HidPlugged pluggedAmong(const std::vector<HidFound>& all, const HidFound& one);

/**
 * hidapi reads, writes and gets features; a second descriptor of the same node holds the lock that keeps other daemons
 * away, and carries lastWords(), for hidapi allocates when a write fails. Looks for the device anew in each open(), so
 * that one that was plugged into another socket is found again by its serial number. Never another
 * than the first that it had open.
 */
class HidrawTransport final : public HidTransport {
 public:
  explicit HidrawTransport(HidWanted wanted) : wanted_(std::move(wanted)) {}
  ~HidrawTransport() override { close(); }
  HidrawTransport(const HidrawTransport&) = delete;
  HidrawTransport& operator=(const HidrawTransport&) = delete;

  [[nodiscard]] Result<void> open() override;
  void close() noexcept override;
  [[nodiscard]] const std::vector<std::uint8_t>& descriptor() const noexcept override { return descriptor_; }
  [[nodiscard]] HidPlugged plugged() const override { return plugged_; }
  [[nodiscard]] std::int64_t now() const noexcept override;
  [[nodiscard]] HidResult read(std::span<std::uint8_t> buffer, std::size_t& size,
                               std::int64_t until_ns) noexcept override;
  [[nodiscard]] HidResult write(std::span<const std::uint8_t> report) noexcept override;
  [[nodiscard]] HidResult setFeature(std::span<const std::uint8_t> report) noexcept override;
  [[nodiscard]] HidResult getFeature(std::span<std::uint8_t> buffer, std::size_t& size) noexcept override;
  void lastWords(std::span<const std::uint8_t> report) noexcept override;

 private:
  [[nodiscard]] HidResult failure() const noexcept;

  HidWanted wanted_;
  hid_device_* device_ = nullptr;
  Lent<int, -1> node_;  ///< For lastWords().
  std::vector<std::uint8_t> descriptor_;
  HidPlugged plugged_;
};

}  // namespace hapticd
