/** @file
 * Logging: to the journal with priorities when systemd reads our standard error, else to standard error, with colours
 * on a terminal. Never from the real-time threads: they send events that the control thread words (RateLimit). Who
 * does not read standard error loses lines and holds nobody up.
 */
#pragma once

#include <fmt/core.h>

#include <cstdint>
#include <new>
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

/** Control characters as \xNN: a client's name cannot forge a line or drive a terminal. "" for want of memory. */
[[nodiscard]] std::string printable(std::string_view text) noexcept;

void write(Level level, std::string_view message);

/** A line for which there is no memory is lost, or a name in it: whoever logs is in the middle of something that must
 * not end there. */
template <class... Args>
void writeIf(Level level, fmt::format_string<Args...> format, Args&&... args) noexcept {
  if (!enabled(level)) return;
  try {
    write(level, fmt::format(format, std::forward<Args>(args)...));
  } catch (const std::bad_alloc&) {  // That is what is meant.
  }
}

template <class... Args>
void debug(fmt::format_string<Args...> format, Args&&... args) noexcept {
  writeIf(Level::kDebug, format, std::forward<Args>(args)...);
}
template <class... Args>
void info(fmt::format_string<Args...> format, Args&&... args) noexcept {
  writeIf(Level::kInfo, format, std::forward<Args>(args)...);
}
template <class... Args>
void warn(fmt::format_string<Args...> format, Args&&... args) noexcept {
  writeIf(Level::kWarn, format, std::forward<Args>(args)...);
}
template <class... Args>
void error(fmt::format_string<Args...> format, Args&&... args) noexcept {
  writeIf(Level::kError, format, std::forward<Args>(args)...);
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

/** "" for 0, else " (n suppressed)"; "" for want of memory. */
[[nodiscard]] std::string suppressedNote(std::uint64_t suppressed) noexcept;

}  // namespace hapticd::log
