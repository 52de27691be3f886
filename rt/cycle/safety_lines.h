/** @file
 * What lines beside the devices tell the servos (emergency stop, dead-man switch, panel buttons), and what the servos
 * tell them: that they live, and that amplifiers may be on. One word each; nobody waits.
 */
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "rt/base/contract.h"

namespace hapticd {

/** Outlives every servo. One thread writes the lines (the panel), each servo its own sign. */
class SafetyLines {
 public:
  /** A panel that has not looked for so long is no panel: stop. It looks every 10 ms. */
  static constexpr std::int64_t kDeaf_ns = 100'000'000;
  static constexpr std::size_t kServos = 16;

  /** What a servo shows of itself. */
  struct Sign {
    std::atomic<bool> used{false};         ///< Control thread.
    std::atomic<bool> enabled{false};      ///< Some device's amplifier may be on.
    std::atomic<std::uint64_t> cycles{0};  ///< Since it has it; 0: it has not begun.
  };

  // Written by the panel.
  std::atomic<bool> stop{false};  ///< The emergency stop is open.
  std::atomic<bool> deadman_open{false};
  std::atomic<std::uint32_t> buttons{0};       ///< Pressed.
  std::atomic<std::uint32_t> button_count{0};  ///< Set before any servo runs.
  std::atomic<std::int64_t> looked_ns{0};      ///< When it last saw its lines; 0: there is none.

  std::array<Sign, kServos> servos;

  [[nodiscard]] bool stopAt(std::int64_t now_ns) const HD_RT {
    const std::int64_t looked = looked_ns.load(std::memory_order_acquire);  // A10, pairs with R10 in Panel::publish()
    return stop.load(std::memory_order_acquire) || (looked != 0 && now_ns - looked > kDeaf_ns);
  }

  /** A sign for one more servo, null when all are taken. Control thread. */
  [[nodiscard]] Sign* take() {
    for (Sign& sign : servos) {
      if (sign.used.load(std::memory_order_relaxed)) continue;
      sign.enabled.store(false, std::memory_order_relaxed);
      sign.cycles.store(0, std::memory_order_relaxed);
      sign.used.store(true, std::memory_order_release);
      return &sign;
    }
    return nullptr;
  }
  static void giveBack(Sign* sign) {
    if (sign == nullptr) return;
    sign->enabled.store(false, std::memory_order_relaxed);
    sign->used.store(false, std::memory_order_release);
  }
};

}  // namespace hapticd
