/** @file
 * GPIO lines as the panel needs them: inputs with their edges, outputs. Over libgpiod, or a test's own.
 */
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "rt/base/error.h"

namespace hapticd {

enum class LineBias : std::uint8_t { kAsIs, kPullUp, kPullDown, kNone };

/** One line by chip and name. */
struct LineRequest {
  std::string chip;  ///< Name, label or path of a chip; empty: whichever has a line of that name.
  std::string name;
  bool output = false;  ///< Outputs begin inactive.
  bool active_low = false;
  LineBias bias = LineBias::kAsIs;
};

/** A change of an input, in its logical sense. */
struct LineEdge {
  std::size_t line = 0;  ///< Index of the request.
  bool active = false;
};

/** Lines that are held while this lives; then they float, so that what they enable needs a pull resistor of its own.
 * One thread. */
class Lines {
 public:
  static constexpr int kLost = -1;

  virtual ~Lines() = default;
  /** Waits at most `timeout_ns` for edges of inputs; how many there are in `edges`, or kLost. */
  [[nodiscard]] virtual int wait(std::int64_t timeout_ns, LineEdge* edges, int most) noexcept = 0;
  /** 1 active, 0 not, or kLost. */
  [[nodiscard]] virtual int get(std::size_t line) noexcept = 0;
  /** False when the line is lost. */
  [[nodiscard]] virtual bool set(std::size_t line, bool active) noexcept = 0;
};

/** Whether they are there; takes none. Of chips that the caller may not open nothing is said. */
[[nodiscard]] Result<void> findLines(const std::vector<LineRequest>& requests);

/**
 * Takes the lines. kNotFound names the chip or line that is not there, kPermissionDenied and kDeviceBusy the line that
 * cannot be had.
 */
[[nodiscard]] Result<std::unique_ptr<Lines>> openLines(const std::vector<LineRequest>& requests);

}  // namespace hapticd
