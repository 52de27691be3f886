/** @file
 * What the servo last had in force for each object, for the control thread to read: clients move objects through their
 * rings, so that nobody else knows where an object is.
 */
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <span>

#include "rt/scene/scene.h"

namespace hapticd {

/** One object as it stood at the end of a cycle. */
struct PosedObject {
  std::uint32_t object = 0;  ///< Id; 0: none has been there yet. One that is gone stays until the next is there.
  std::uint32_t flags = 0;   ///< hd_object_flag
  std::uint64_t tick = 0;    ///< Of that cycle.
  std::uint32_t control_applied = 0;  ///< ServoCounters::control_applied at that cycle.
  /** Of each part of the object, by clients of this servo's rings; wrap. */
  std::array<std::uint32_t, SceneObject::kParts> client_edits{};
  hd_material material{};
  double p_PO[3] = {}, q_PO[4] = {};            ///< In the parent.
  double v_PO[3] = {}, w_PO[3] = {};            ///< In the parent's frame.
  double p_WO[3] = {}, q_WO[4] = {1, 0, 0, 0};  ///< In the world.
};

/**
 * A seqlocked entry per scene slot. The servo writes kPerCycle objects a cycle in turn, so that of n objects none is
 * older than 2 n / kPerCycle cycles, nor than n / kPerCycle while none is removed. One writer, any number of readers,
 * neither waits.
 */
class PoseBoard {
 public:
  static constexpr std::uint32_t kPerCycle = 16;

  /** Servo, once a cycle. `control_applied` counts the control thread's commands in force in `scene`. */
  void publish(const Scene& scene, std::uint64_t tick, std::uint32_t control_applied) HD_RT {
    const std::span<const std::uint16_t> used = scene.used();
    const auto count = std::min(kPerCycle, static_cast<std::uint32_t>(used.size()));
    for (std::uint32_t i = 0; i < count; ++i) {
      if (next_ >= used.size()) next_ = 0;
      const std::uint16_t slot = used[next_++];
      const SceneObject& object = scene.slot(slot);
      PosedObject posed;
      posed.object = object.id;
      posed.flags = object.flags;
      posed.tick = tick;
      posed.control_applied = control_applied;
      posed.client_edits = object.client_edits;
      posed.material = object.material;
      store(object.X_PO.p, posed.p_PO);
      store(object.X_PO.q, posed.q_PO);
      store(object.V_PO.v, posed.v_PO);
      store(object.V_PO.w, posed.w_PO);
      store(object.X_WO.p, posed.p_WO);
      store(object.X_WO.q, posed.q_WO);
      write(slot, posed);
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
  using Words = std::array<std::uint64_t, sizeof(PosedObject) / sizeof(std::uint64_t)>;
  struct alignas(64) Entry {
    std::atomic<std::uint32_t> guard{0};
    std::array<std::atomic<std::uint64_t>, std::tuple_size_v<Words>> word{};
  };

  void write(std::uint32_t slot, const PosedObject& posed) HD_RT {
    Entry& entry = entries_[slot];
    Words words;
    std::memcpy(words.data(), &posed, sizeof posed);
    const std::uint32_t before = entry.guard.load(std::memory_order_relaxed);
    entry.guard.store(before + 1, std::memory_order_relaxed);
    // R1, pairs with A1: who sees a word of this write sees the odd guard. No fence: the thread sanitizer knows none.
    for (std::size_t i = 0; i < words.size(); ++i) entry.word[i].store(words[i], std::memory_order_release);
    entry.guard.store(before + 2, std::memory_order_release);  // R0, pairs with A0
  }

  std::array<Entry, kMaxObjects> entries_;
  std::uint32_t next_ = 0;
};

}  // namespace hapticd
