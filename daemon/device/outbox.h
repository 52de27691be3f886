/** @file
 * Orders that wait for a servo.
 */
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <list>
#include <span>

#include "rt/command.h"

namespace hapticd {

/**
 * First in, first out, with room for kSpare ahead of need: what must be said is said where there is no memory, too.
 * Whoever gives orders may have as many waiting as there are places left: one alone half of them, and however many
 * fill it, there is as much left for the next as for each of them.
 */
class Outbox {
 public:
  static constexpr std::size_t kSpare = 256;
  static constexpr std::size_t kPlaces = 8192;     ///< Beyond them nobody's edits are taken.
  static constexpr std::size_t kMostGivers = 512;  ///< Told apart; whoever comes beyond them shares that of kOthers,
  static constexpr std::uint64_t kOthers = std::uint64_t{1} << 63;  ///< but of numbers from here on each has its own:
  static constexpr std::size_t kMostOwn = 32;                       ///< so many.

  struct Waiting {
    Command order;
    std::uint64_t whose = 0;  ///< 0: the daemon's own, which have no share and are always taken.
  };

  Outbox() : spare_(kSpare) {}

  /** Whether one more is within that share; 0: within the places. */
  [[nodiscard]] bool hasRoomFor(std::uint64_t whose) const noexcept {
    return orders_.size() + of(shareOf(whose)) < kPlaces;
  }
  /** So many of theirs wait; of 0 none are counted. */
  [[nodiscard]] std::size_t of(std::uint64_t whose) const noexcept {
    const auto all = std::span(shares_).first(givers_);
    const auto it = std::ranges::find(all, whose, &Share::whose);
    return it == all.end() ? 0 : it->waiting;
  }
  /** Throws std::bad_alloc, and then changes nothing, only where kSpare have been pushed without memory. */
  void push(const Command& order, std::uint64_t whose = 0) {
    if (spare_.empty()) {
      orders_.emplace_back();
    } else {
      orders_.splice(orders_.end(), spare_, spare_.begin());
    }
    orders_.back() = {order, count(shareOf(whose)) ? shareOf(whose) : 0};
  }
  void pop() noexcept {
    forget(orders_.front().whose);
    if (spare_.size() < kSpare) {
      spare_.splice(spare_.end(), orders_, orders_.begin());
    } else {
      orders_.pop_front();
    }
  }
  [[nodiscard]] const Command& front() const { return orders_.front().order; }
  [[nodiscard]] std::size_t size() const { return orders_.size(); }
  [[nodiscard]] bool empty() const { return orders_.empty(); }
  /** Orders that wait may be replaced. */
  [[nodiscard]] auto begin() { return orders_.begin(); }
  [[nodiscard]] auto end() { return orders_.end(); }

 private:
  struct Share {
    std::uint64_t whose = 0;
    std::size_t waiting = 0;
  };

  [[nodiscard]] std::uint64_t shareOf(std::uint64_t whose) const noexcept {
    return whose == 0 || whose >= kOthers || givers_ < kMostGivers || of(whose) != 0 ? whose : kOthers;
  }
  bool count(std::uint64_t whose) noexcept {
    if (whose == 0) return false;
    const auto all = std::span(shares_).first(givers_);
    const auto it = std::ranges::find(all, whose, &Share::whose);
    if (it != all.end()) {
      ++it->waiting;
      return true;
    }
    if (givers_ == shares_.size()) return false;
    shares_[givers_++] = {whose, 1};
    return true;
  }
  void forget(std::uint64_t whose) noexcept {
    if (whose == 0) return;
    const auto it = std::ranges::find(shares_, whose, &Share::whose);
    if (--it->waiting == 0) *it = shares_[--givers_];
  }

  std::list<Waiting> orders_, spare_;
  std::array<Share, kMostGivers + kMostOwn> shares_{};
  std::size_t givers_ = 0;
};

}  // namespace hapticd
