/** @file
 * The collide thread's work: takes the servo's newest question, answers it with contacts of each held tool and
 * free body.
 *
 * Between it and the servo lie a wait-free newest-value buffer there and a ring back; the ring's commands enter the
 * cycle through CycleInput, so a recording holds them and a replay needs no collide thread.
 */
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>

#include "rt/base/clock.h"
#include "rt/base/histogram.h"
#include "rt/body/contact_model.h"
#include "rt/collide/request.h"
#include "rt/ring/newest.h"
#include "rt/ring/spsc.h"

namespace hapticd {

class SceneContacts;
class VolumeTable;

/** Counters of the collide thread; read by anybody. */
struct ColliderCounters {
  std::atomic<std::uint64_t> queries{0};    ///< Answers, one for each held tool or free body of a question.
  std::atomic<std::uint64_t> exhausted{0};  ///< Of them, those whose budget ended the search.
  std::atomic<std::uint64_t> unsent{0};     ///< Of them, those that the servo had no room for.
  std::atomic<std::uint32_t> last_work{0};
  /** Handed over with the last answer; as CollideRequest::held. */
  std::array<std::atomic<std::uint32_t>, kMaxDevices + kMaxBodies> contacts{};
  Histogram duration;  ///< Of a question with all its tools; empty without a clock.
};

class Collider {
 public:
  static constexpr std::int64_t kPeriodNs = 2'000'000;  ///< Between two questions, at least.
  static constexpr std::int64_t kBudgetNs =
      1'200'000;                                    ///< Of it; the rest the thread sleeps (more than 30 % of 10 ms).
  static constexpr std::uint32_t kUnits = 400'000;  ///< Nodes and triangles a question; some 10 ns each.

  explicit Collider(const VolumeTable* volumes = nullptr);
  ~Collider();

  /** One question, if there is one. `clock` null: bound by work units alone, so that tests repeat. */
  void step(Clock* clock) HD_RT;

  /** Orders that memory named by it may still be read for, as CollideRequest::orders; kIdle when it reads none. */
  static constexpr std::uint64_t kIdle = ~std::uint64_t{0};
  static constexpr std::uint64_t kTaking = kIdle - 1;  ///< It is just taking one: wait.
  [[nodiscard]] std::uint64_t reading() const HD_RT { return reading_.load(std::memory_order_acquire); }

  Newest<CollideRequest> questions;  ///< The servo puts.
  SpscRing<Command, 32> answers;     ///< The servo pops.
  ColliderCounters counters;

 private:
  CollideRequest question_;
  std::array<std::unique_ptr<SceneContacts>, kMaxDevices + kMaxBodies> contacts_;  ///< As CollideRequest::held.
  std::array<ContactModel, kMaxDevices + kMaxBodies> answer_;                      ///< The last of each.
  std::atomic<std::uint64_t> reading_{kIdle};
};

}  // namespace hapticd
