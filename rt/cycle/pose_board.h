/** @file
 * What the servo last had in force for each object, for the control thread to read: clients move objects through their
 * rings, so that nobody else knows where an object is.
 */
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "rt/scene/scene.h"

namespace hapticd {

/** One object as it stood at the end of a cycle; of a free slot only id, tick and control_applied mean anything. */
struct PosedObject {
  std::uint32_t object = 0;           ///< Id; 0: the slot was free.
  std::uint32_t flags = 0;            ///< hd_object_flag
  std::uint64_t tick = 0;             ///< Of that cycle.
  std::uint32_t control_applied = 0;  ///< ServoCounters::control_applied at that cycle.
  std::uint32_t client_edits = 0;     ///< Of the object, by clients of this servo's rings; wraps.
  hd_material material{};
  double p_PO[3] = {}, q_PO[4] = {};            ///< In the parent.
  double v_PO[3] = {}, w_PO[3] = {};            ///< In the parent's frame.
  double p_WO[3] = {}, q_WO[4] = {1, 0, 0, 0};  ///< In the world.
};

/**
 * A seqlocked entry per scene slot. The servo writes kPerCycle slots a cycle in turn, so that an entry is at most
 * kMaxObjects / kPerCycle cycles old. One writer, any number of readers, neither waits.
 */
class PoseBoard {
 public:
  static constexpr std::uint32_t kPerCycle = 16;
  static_assert(kMaxObjects % kPerCycle == 0);

  /** Servo, once a cycle. `control_applied` counts the control thread's commands in force in `scene`. */
  void publish(const Scene& scene, std::uint64_t tick, std::uint32_t control_applied) HD_RT {
    for (std::uint32_t i = 0; i < kPerCycle; ++i) {
      const SceneObject& object = scene.slot(next_);
      PosedObject posed;
      posed.object = object.id;
      posed.tick = tick;
      posed.control_applied = control_applied;
      if (object.id == 0) {
        write<kHead>(next_, posed);
      } else {
        posed.flags = object.flags;
        posed.client_edits = object.client_edits;
        posed.material = object.material;
        store(object.X_PO.p, posed.p_PO);
        store(object.X_PO.q, posed.q_PO);
        store(object.V_PO.v, posed.v_PO);
        store(object.V_PO.w, posed.w_PO);
        store(object.X_WO.p, posed.p_WO);
        store(object.X_WO.q, posed.q_WO);
        write<kAll>(next_, posed);
      }
      next_ = (next_ + 1) % kMaxObjects;
    }
  }

  /** Any thread. False when the writer was there twice in a row. */
  [[nodiscard]] bool read(std::uint32_t slot, PosedObject& out) const noexcept {
    const Entry& entry = entries_[slot];
    for (int attempt = 0; attempt < 2; ++attempt) {
      const std::uint32_t before = entry.guard.load(std::memory_order_acquire);  // A0, pairs with R0: the words stand
      if (before & 1u) continue;
      Words words;
      for (std::size_t i = 0; i < words.size(); ++i) words[i] = entry.word[i].load(std::memory_order_acquire);  // A1
      if (entry.guard.load(std::memory_order_relaxed) != before) continue;
      std::memcpy(static_cast<void*>(&out), words.data(), sizeof out);
      return true;
    }
    return false;
  }

 private:
  static_assert(sizeof(PosedObject) % sizeof(std::uint64_t) == 0 && std::is_trivially_copyable_v<PosedObject>);
  static constexpr std::size_t kAll = sizeof(PosedObject) / sizeof(std::uint64_t);
  static constexpr std::size_t kHead = offsetof(PosedObject, material) / sizeof(std::uint64_t);
  using Words = std::array<std::uint64_t, kAll>;
  struct alignas(64) Entry {
    std::atomic<std::uint32_t> guard{0};
    std::array<std::atomic<std::uint64_t>, kAll> word{};
  };

  /** The first words; those behind stay as they were. */
  template <std::size_t kCount>
  void write(std::uint32_t slot, const PosedObject& posed) HD_RT {
    Entry& entry = entries_[slot];
    std::array<std::uint64_t, kCount> words;
    std::memcpy(words.data(), &posed, sizeof words);
    const std::uint32_t before = entry.guard.load(std::memory_order_relaxed);
    entry.guard.store(before + 1, std::memory_order_relaxed);
    // R1, pairs with A1: who sees a word of this write sees the odd guard. No fence: the thread sanitizer knows none.
    for (std::size_t i = 0; i < kCount; ++i) entry.word[i].store(words[i], std::memory_order_release);
    entry.guard.store(before + 2, std::memory_order_release);  // R0, pairs with A0
  }

  std::array<Entry, kMaxObjects> entries_;
  std::uint32_t next_ = 0;
};

}  // namespace hapticd
