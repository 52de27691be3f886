/** @file
 * The panel: emergency stop, dead-man switch, home button, amplifier enable, heartbeat and status light on GPIO lines.
 *
 * Inputs are latched into the SafetyLines that every servo reads at the start of its cycle: from an edge to zero force
 * it takes the debounce time and the rest of one period. Outputs show what the servos say of themselves.
 */
#pragma once

#include <atomic>
#include <memory>
#include <vector>

#include "daemon/config/config.h"
#include "drivers/gpio/lines.h"
#include "drivers/gpio/safety_contact.h"
#include "rt/base/clock.h"
#include "rt/cycle/realtime.h"
#include "rt/cycle/safety_lines.h"

namespace hapticd {

/** The lines of a configuration as they are to be taken. */
[[nodiscard]] std::vector<LineRequest> lineRequests(const std::vector<LineConfig>& config);

class Panel {
 public:
  /** Outputs are set so often; the heartbeat changes with each. */
  static constexpr std::int64_t kLook_ns = 10'000'000;

  /** `lines` are those of lineRequests(config). Looks at them once, so that servos start with what is. */
  Panel(const std::vector<LineConfig>& config, std::unique_ptr<Lines> lines, SafetyLines& safety, std::int64_t now_ns);
  /** Stops the thread; outputs go inactive, the stop counts as open. */
  ~Panel();

  /** Its own thread at SCHED_FIFO `priority`. kNoRealtime unless `allow_no_rt`. */
  [[nodiscard]] Result<void> start(int priority, bool allow_no_rt, Clock& clock);
  /** One round without the thread: edges that have come, a look at the levels, outputs where they are due. */
  void step(std::int64_t now_ns, const LineEdge* edges, int count) noexcept;
  /** How long the thread may wait for edges now. */
  [[nodiscard]] std::int64_t patience(std::int64_t now_ns) const noexcept;
  /** A line could not be read or set any more: the stop is open for good. Any thread. */
  [[nodiscard]] bool lost() const noexcept { return lost_.load(std::memory_order_acquire); }

 private:
  enum class Role : std::uint8_t { kStop, kDeadman, kHome, kEnable, kHeartbeat, kLed };
  struct Line {
    Role role;
    SafetyContact contact;
    bool shown = false;  ///< Last value of an output.
  };

  void lose() noexcept;
  void see(std::size_t line, bool active, std::int64_t now_ns) noexcept;
  void publish(std::int64_t now_ns) noexcept;
  void show(std::int64_t now_ns) noexcept;
  void set(std::size_t line, bool active) noexcept;

  std::unique_ptr<Lines> lines_;
  SafetyLines& safety_;
  std::vector<Line> line_;
  std::array<std::uint64_t, SafetyLines::kServos> seen_cycles_{};
  std::int64_t next_show_ns_ = 0;
  std::uint32_t shows_ = 0;
  std::atomic<bool> lost_{false}, end_{false};
  RtThread thread_;
};

}  // namespace hapticd
