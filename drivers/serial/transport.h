/** @file
 * A serial line as drivers see it: over a tty (tty_transport.h), or played in the same process by a model.
 */
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "rt/base/error.h"

namespace hapticd {

/** One line. One thread at a time calls all of it, but for lastWords(). */
class SerialTransport {
 public:
  virtual ~SerialTransport() = default;

  /** kNotFound, kPermissionDenied, kDeviceBusy (another program has locked the line), kSystem. */
  [[nodiscard]] virtual Result<void> open() = 0;
  /** Idempotent. */
  virtual void close() noexcept = 0;

  /** CLOCK_MONOTONIC, or the model's time [ns]. */
  [[nodiscard]] virtual std::int64_t now() const noexcept = 0;
  /** Whatever bytes wait, or come until `until_ns`, at least one; `size` of them. False: the line is gone. */
  [[nodiscard]] virtual bool read(std::span<std::uint8_t> buffer, std::size_t& size,
                                  std::int64_t until_ns) noexcept = 0;
  /** All of it, or none that can be told. Waits for room, at most 10 ms. False: the line is gone or does not move. */
  [[nodiscard]] virtual bool write(std::span<const std::uint8_t> bytes) noexcept = 0;
  /** write() from any thread and from a signal handler; nothing when closed. */
  virtual void lastWords(std::span<const std::uint8_t> bytes) noexcept = 0;
};

}  // namespace hapticd
