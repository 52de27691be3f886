/** @file
 * A serial line over a tty of the kernel.
 */
#pragma once

#include <string>

#include "drivers/link/lent.h"
#include "drivers/serial/transport.h"

namespace hapticd {

/**
 * Raw bytes, no echo, no flow control; the line's speed does not matter to boards on USB. Locks the node against other
 * programs (flock and TIOCEXCL), drops what was said before the open.
 */
class TtyTransport final : public SerialTransport {
 public:
  explicit TtyTransport(std::string path) : path_(std::move(path)) {}
  ~TtyTransport() override { close(); }
  TtyTransport(const TtyTransport&) = delete;
  TtyTransport& operator=(const TtyTransport&) = delete;

  [[nodiscard]] Result<void> open() override;
  void close() noexcept override;
  [[nodiscard]] std::int64_t now() const noexcept override;
  [[nodiscard]] bool read(std::span<std::uint8_t> buffer, std::size_t& size, std::int64_t until_ns) noexcept override;
  [[nodiscard]] bool write(std::span<const std::uint8_t> bytes) noexcept override;
  void lastWords(std::span<const std::uint8_t> bytes) noexcept override;

 private:
  std::string path_;
  Lent<int, -1> fd_;  ///< For lastWords().
};

}  // namespace hapticd
