/** @file
 * Logging: to the journal with priorities when systemd reads our standard error, else to standard error, with colours
 * on a terminal. Never from the real-time threads: they send events that the control thread words (RateLimit). Who
 * does not read standard error loses lines and holds nobody up.
 */
#pragma once

#include <fmt/core.h>

#include <cstdint>
#include <string>
#include <string_view>

#include "rt/base/error.h"

namespace hapticd::log {

enum class Level { kTrace, kDebug, kInfo, kWarn, kError, kOff };

/** "trace", "debug", "info", "warn", "error", "off". kInvalidArgument lists them. */
[[nodiscard]] Result<Level> parseLevel(std::string_view text);
[[nodiscard]] std::string_view toString(Level level);

/** Picks the sink. Call once, at start; before it, messages go plainly to standard error at kInfo. */
void start(Level level);
void setLevel(Level level);
[[nodiscard]] bool enabled(Level level) noexcept;

/**
 * True if $JOURNAL_STREAM, "device:inode", names the file behind `fd`: systemd connected it to the journal
 * (systemd.exec(5)).
 */
[[nodiscard]] bool isJournalStream(std::string_view journal_stream, int fd);

/** Control characters as \xNN: a client's name cannot forge a line or drive a terminal. */
[[nodiscard]] std::string printable(std::string_view text);

void write(Level level, std::string_view message);

template <class... Args>
void debug(fmt::format_string<Args...> format, Args&&... args) {
  if (enabled(Level::kDebug)) write(Level::kDebug, fmt::format(format, std::forward<Args>(args)...));
}
template <class... Args>
void info(fmt::format_string<Args...> format, Args&&... args) {
  if (enabled(Level::kInfo)) write(Level::kInfo, fmt::format(format, std::forward<Args>(args)...));
}
template <class... Args>
void warn(fmt::format_string<Args...> format, Args&&... args) {
  if (enabled(Level::kWarn)) write(Level::kWarn, fmt::format(format, std::forward<Args>(args)...));
}
template <class... Args>
void error(fmt::format_string<Args...> format, Args&&... args) {
  if (enabled(Level::kError)) write(Level::kError, fmt::format(format, std::forward<Args>(args)...));
}

/**
 * Lets `burst` messages pass in each interval and counts the rest (after PipeWire's spa_ratelimit). The count belongs
 * into the next message that passes: "... (12 suppressed)".
 */
class RateLimit {
 public:
  RateLimit(std::int64_t interval_ns, std::uint32_t burst) noexcept : interval_ns_(interval_ns), burst_(burst) {}

  /** True if a message may be written at this time; `suppressed` is then what was held back since the last one. */
  [[nodiscard]] bool allow(std::int64_t now_ns, std::uint64_t& suppressed) noexcept;

 private:
  std::int64_t interval_ns_;
  std::uint32_t burst_;
  std::int64_t begin_ns_ = 0;
  std::uint32_t passed_ = 0;
  std::uint64_t suppressed_ = 0;
  bool started_ = false;
};

/** "" for 0, else " (n suppressed)". */
[[nodiscard]] std::string suppressedNote(std::uint64_t suppressed);

}  // namespace hapticd::log
