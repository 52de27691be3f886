/** @file
 * The live side of a terminal: signals that end a command cleanly, keys without Enter, a line that is rewritten in
 * place.
 */
#pragma once

#include <termios.h>

#include <array>
#include <chrono>
#include <csignal>
#include <cstddef>
#include <string>
#include <string_view>

namespace hapticctl {

/**
 * While it lives, SIGINT, SIGTERM and SIGHUP ask the command to end instead of killing it. Not SIGHUP where nohup has
 * it ignored; SIGINT also where a script's "&" has. One at a time; make it before anything is armed, so that no signal
 * falls between.
 */
class Interrupt {
 public:
  static constexpr std::size_t kCount = 3;  ///< Of its signals.
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  [[nodiscard]] static bool asked() noexcept;
  /** Sleeps, but wakes on a signal or (with `keys`) a key; returns the key, or 0. */
  char wait(std::chrono::milliseconds time, bool keys = false) const;

 private:
  std::array<struct sigaction, kCount> before_{};
};

/** Keys arrive at once and unechoed while it lives; does nothing where standard input is no terminal. */
class RawKeys {
 public:
  RawKeys();
  ~RawKeys();
  RawKeys(const RawKeys&) = delete;
  RawKeys& operator=(const RawKeys&) = delete;
  [[nodiscard]] bool active() const noexcept { return active_; }

 private:
  bool active_ = false;
  termios saved_{};
};

/** A line on standard error that replaces itself. Silent where standard error is no terminal. */
class LiveLine {
 public:
  LiveLine();
  ~LiveLine();  ///< Clears the line.
  LiveLine(const LiveLine&) = delete;
  LiveLine& operator=(const LiveLine&) = delete;
  void show(std::string_view text);
  void clear();

 private:
  bool active_ = false, shown_ = false;
};

/** "[#####.....]  50 %  stage", for a LiveLine. */
[[nodiscard]] std::string progressBar(double fraction, std::string_view stage);

[[nodiscard]] bool stdinIsTerminal();
[[nodiscard]] bool stdoutIsTerminal();
/** Columns and rows of standard output; 80 by 24 where unknown. */
struct TerminalSize {
  int columns, rows;
};
[[nodiscard]] TerminalSize terminalSize();

}  // namespace hapticctl
