/** @file
 * What the stores of meshes and textures share: things with an owner that stand in the entries of the servos' tables.
 */
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <new>
#include <utility>
#include <vector>

#include "daemon/scene/command_sink.h"
#include "daemon/scene/object.h"

namespace hapticd {

/** How errors speak of what stands on a shelf. */
struct ShelfWords {
  const char* one;       ///< "mesh"
  const char* many;      ///< "meshes"
  const char* shown_by;  ///< What counts as a use: "objects".
  const char* free_it;   ///< What to do while it is in use.
};

/** What an entry has besides its own. `Copy` is the memory as a servo reads it. */
template <class Info, class Copy>
struct ShelfEntry {
  Info info;  ///< With id, bytes, uses and owner.
  std::map<CommandSink*, Copy> copies;
  bool dropped = false;
  bool forsaken = false;                            ///< It goes with its last use.
  std::map<CommandSink*, std::uint64_t> waits_for;  ///< Ticket each servo has to pass before the memory goes.
};

/**
 * Entries found by id, counted by their uses, dropped by their owner, and freed once every servo has passed. `Entry`
 * derives from ShelfEntry. Control thread only.
 */
template <class Entry, std::uint32_t kMost>
class Shelf {
 public:
  explicit Shelf(const ShelfWords& words) : words_(words) {}

  static constexpr std::size_t kMostPerUser = kMost - kMost / 4;  ///< Others find room.

  /** kQuotaExceeded where that user may have no more. */
  [[nodiscard]] Result<void> room(const Client& by) const {
    const auto refuse = [&](std::string what) {
      return Error{ErrorCode::kQuotaExceeded, words_.one, std::move(what),
                   fmt::format("drop {} that no {} show", words_.many, words_.shown_by)};
    };
    if (firstFree() == kMost) return refuse(fmt::format("the daemon holds {} {}, its most", kMost, words_.many));
    const auto own = std::count_if(by_id_.begin(), by_id_.end(),
                                   [&](const auto& one) { return entries_[one.second]->info.owner.uid == by.uid; });
    if (static_cast<std::size_t>(own) < kMostPerUser) return {};
    return refuse(fmt::format("user {} has {} {}, the most allowed", by.uid, own, words_.many));
  }

  /**
   * Gives the thing an id and a free entry and has `publish(index, sink)` tell every servo; if one cannot be told,
   * `unpublish(index)` takes it back from all. The shelf must not be full.
   */
  template <class Publish, class Unpublish>
  [[nodiscard]] Result<std::uint64_t> put(std::unique_ptr<Entry> entry, Publish&& publish, Unpublish&& unpublish) {
    const std::uint32_t index = firstFree();
    entry->info.id = next_id_;
    entry->info.uses = 0;
    by_id_.emplace(next_id_, index);
    entries_[index] = std::move(entry);
    const auto takeBack = [&] {
      unpublish(index);
      by_id_.erase(next_id_);
      entries_[index].reset();  // no order names it yet
    };
    try {
      for (CommandSink* sink : sinks_) {
        if (auto r = publish(index, *sink); !r) {
          takeBack();
          return r.error();
        }
      }
    } catch (const std::bad_alloc&) {
      takeBack();
      throw;
    }
    return next_id_++;
  }

  /** The owner's user or administration, once nothing uses it. */
  [[nodiscard]] Result<void> drop(std::uint64_t id, const Client& by) {
    Entry* entry = find(id);
    if (entry == nullptr) {
      return Error{ErrorCode::kNotFound, words_.one, fmt::format("there is no {} {}", words_.one, id),
                   fmt::format("hapticctl get /{} lists them", words_.many)};
    }
    if (entry->info.owner.uid != by.uid && !by.administration) {
      return Error{ErrorCode::kPermissionDenied, words_.one,
                   fmt::format("{} {} belongs to user {}", words_.one, id, entry->info.owner.uid),
                   "use the administration socket"};
    }
    if (entry->info.uses != 0) {
      return Error{ErrorCode::kInvalidArgument, words_.one,
                   fmt::format("{} {} is shown by {} {}", words_.one, id, entry->info.uses, words_.shown_by),
                   words_.free_it};
    }
    // For want of memory it stays, or servos that are not waited for would read on in it.
    auto waits_for = entry->waits_for;
    for (CommandSink* sink : sinks_) waits_for[sink] = sink->posted();
    entry->waits_for.swap(waits_for);
    entry->dropped = true;
    by_id_.erase(id);
    return {};
  }

  /** A connection has gone: what it made goes with its last use. */
  void dropUnusedOf(std::uint64_t connection) {
    std::vector<std::uint64_t> ids;
    for (const auto& [id, index] : by_id_) {
      if (entries_[index]->info.owner.connection == connection) ids.push_back(id);
    }
    for (const std::uint64_t id : ids) {
      Entry& entry = *find(id);
      entry.info.owner.connection = 0;
      entry.forsaken = true;
      dropForsaken(entry);
    }
  }

  void use(std::uint64_t id) {
    if (Entry* entry = find(id)) ++entry->info.uses;
  }
  void release(std::uint64_t id) noexcept {
    Entry* entry = find(id);
    if (entry == nullptr) return;
    auto& info = entry->info;
    if (info.uses > 0) --info.uses;
    entry->forsaken = entry->forsaken || info.owner.connection == 0;
    dropForsaken(*entry);
  }

  /** Publishes everything to a new sink; nothing is left of it if that fails. */
  template <class Publish>
  [[nodiscard]] Result<void> attach(CommandSink& sink, Publish&& publish) {
    for (std::uint32_t i = 0; i < kMost; ++i) {
      if (entries_[i] == nullptr || entries_[i]->dropped) continue;
      if (auto r = publish(i, sink); !r) {
        detach(sink);
        return r;
      }
    }
    sinks_.push_back(&sink);
    return {};
  }
  void detach(CommandSink& sink) {
    sinks_.erase(std::remove(sinks_.begin(), sinks_.end(), &sink), sinks_.end());
    for (auto& entry : entries_) {
      if (entry == nullptr) continue;
      entry->copies.erase(&sink);
      entry->waits_for.erase(&sink);
    }
  }

  /** Gives back what every servo has passed. */
  template <class Unpublish, class GiveBack>
  void reclaim(Unpublish&& unpublish, GiveBack&& give_back) {
    for (std::uint32_t i = 0; i < kMost; ++i) {
      Entry* entry = entries_[i].get();
      if (entry != nullptr && !entry->dropped) dropForsaken(*entry);
      if (entry == nullptr || !entry->dropped) continue;
      const bool all = std::all_of(entry->waits_for.begin(), entry->waits_for.end(),
                                   [](const auto& wait) { return wait.first->passed(wait.second); });
      if (!all) continue;
      unpublish(i);
      give_back(std::exchange(entries_[i], nullptr));
    }
  }

  /** Null: there is none, or it is dropped. */
  [[nodiscard]] Entry* find(std::uint64_t id) const {
    const auto it = by_id_.find(id);
    return it == by_id_.end() ? nullptr : entries_[it->second].get();
  }
  /** Entry of the tables; kMost: there is none. */
  [[nodiscard]] std::uint32_t indexOf(std::uint64_t id) const {
    const auto it = by_id_.find(id);
    return it == by_id_.end() ? kMost : it->second;
  }
  /** By id, without what is dropped. */
  [[nodiscard]] auto list() const {
    std::vector<decltype(&std::as_const(entries_[0]->info))> all;
    for (const auto& [id, index] : by_id_) all.push_back(&entries_[index]->info);
    return all;
  }
  /** By entry, dropped or not; null: free. */
  [[nodiscard]] const auto& entries() const { return entries_; }
  [[nodiscard]] const std::vector<CommandSink*>& sinks() const { return sinks_; }

  /** Of all copies [bytes]. */
  [[nodiscard]] std::uint64_t lockedBytes() const {
    std::uint64_t sum = 0;
    for (const auto& entry : entries_) {
      if (entry != nullptr) sum += entry->info.bytes * entry->copies.size();
    }
    return sum;
  }

 private:
  /** Without memory reclaim() does. */
  void dropForsaken(Entry& entry) noexcept {
    if (!entry.forsaken || entry.info.uses != 0) return;
    try {
      (void)drop(entry.info.id, entry.info.owner);
    } catch (const std::bad_alloc&) {  // Later.
    }
  }
  [[nodiscard]] std::uint32_t firstFree() const {
    return static_cast<std::uint32_t>(std::find(entries_.begin(), entries_.end(), nullptr) - entries_.begin());
  }

  ShelfWords words_;
  std::vector<CommandSink*> sinks_;
  std::array<std::unique_ptr<Entry>, kMost> entries_;
  std::map<std::uint64_t, std::uint32_t> by_id_;
  std::uint64_t next_id_ = 1;
};

}  // namespace hapticd
