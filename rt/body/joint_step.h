/** @file
 * One tick of tools and free bodies that push each other: all touches solved together by projected Gauss-Seidel
 * (constraint_row.h), with leaps where that is slow (joint_leap.h), action equal to reaction, and the books of tool.h
 * kept for each island, a group of bodies that touches join: it may not hold more energy than before plus what hands,
 * weights, moving obstacles and its reserve gave. What is first given up for that is leaving overlaps, as much of it as
 * that takes: all is solved again without, and a mean of both taken. Where even that is too much all velocities are
 * scaled down.
 *
 * Servo-safe; one thread; memory is taken when it is made. begin(), add what takes part, solve(), read.
 */
#pragma once

#include <array>
#include <cstdint>

#include "rt/body/constraint_row.h"
#include "rt/body/free_body.h"
#include "rt/body/joint_leap.h"
#include "rt/body/tool.h"
#include "rt/command.h"

namespace hapticd {

class JointStep {
 public:
  static constexpr std::uint32_t kMaxMovers = JointLeap::kMovers;
  static constexpr std::uint32_t kMaxJointTouches = JointLeap::kTouches;
  static constexpr std::uint32_t kMaxSweeps = 50;
  static constexpr std::uint32_t kMaxRelaxations = 1400;  ///< Sweeps times touches: twice what a tool alone may take.
  static constexpr std::uint32_t kFirstLeap = 5;          ///< Sweeps before bodies on bodies are solved at once ...
  static constexpr std::uint32_t kNextLeap = 3;           ///< ... and from then on, where they have not converged.
  static constexpr std::uint8_t kFixed = 0xff;            ///< In place of B: nothing moves it.

  void begin(double dt, const Vec3& gravity) HD_RT;
  /** Its number. `out` and the tool stay the caller's until solve() has returned. */
  std::uint8_t add(Tool& tool, const Pose& device, ToolStep& out) HD_RT;
  std::uint8_t add(FreeBody& body) HD_RT;
  /** The body with that number has been given another motion since it was added. */
  void moved(std::uint8_t mover) HD_RT { mover_[mover].V = mover_[mover].body->freeTwist(gravity_, dt_); }
  /**
   * Between movers a and b, or a and what moves as told; r_b counts from b's centre of mass. What is moved as told
   * beside how b moves, a part of it by its motor, has that speed in `moving`, and a and b get opposite impulses.
   * False: no room.
   */
  bool add(Touch touch, std::uint8_t a, std::uint8_t b) HD_RT;
  void solve() HD_RT;

  [[nodiscard]] std::uint32_t movers() const HD_RT { return movers_; }
  [[nodiscard]] std::uint32_t room() const HD_RT { return kMaxJointTouches - touches_; }  ///< For touches.
  /** After solve(): the same number for all that touches join. Below movers(). */
  [[nodiscard]] std::uint8_t island(std::uint8_t mover) const HD_RT { return mover_[mover].island; }
  [[nodiscard]] std::uint32_t rounds() const HD_RT { return rounds_; }
  [[nodiscard]] std::uint32_t work() const HD_RT { return work_; }        ///< Relaxations, or what leaps cost instead.
  [[nodiscard]] std::uint32_t dropped() const HD_RT { return dropped_; }  ///< Touches for which there was no room.
  [[nodiscard]] double residual() const HD_RT { return residual_; }       ///< [m/s]

 private:
  struct Mover {
    Tool* tool = nullptr;
    FreeBody* body = nullptr;
    ToolStep* out = nullptr;
    Tool::Kick kick;
    Mobility mobility;
    Twist V;
    double brought = 0;  ///< What its tool has more since the hand moved, the reserve's too, but by its weight [J].
    std::uint8_t island = 0;
    bool waits = false;  ///< Its island does not settle before all is solved without leaving overlaps.
  };
  struct Solution {
    std::array<Twist, kMaxMovers> V;
    std::array<Vec3, kMaxJointTouches> lambda;
  };
  struct Pair {
    std::uint8_t a, b;
  };
  struct Remembered {
    std::uint64_t key = 0;
    Vec3 impulse = Vec3::Zero();
  };
  // Touches that others imply (joint_thin.cc).
  void leaveOutImplied() HD_RT;
  [[nodiscard]] bool isOfSameFaces(std::uint32_t i, std::uint32_t j) const HD_RT;
  void startRows() HD_RT;
  void sweep() HD_RT;
  void leap(bool first) HD_RT;
  void findIslands() HD_RT;
  // What may be kept of a solution (joint_books.cc).
  void settleIslands() HD_RT;
  void solveWithoutRecovery() HD_RT;
  void mixIn(std::uint8_t island) HD_RT;
  [[nodiscard]] bool settle(std::uint8_t island, bool may_wait) HD_RT;
  [[nodiscard]] double reserveOf(std::uint8_t island) const HD_RT;
  [[nodiscard]] double givenTo(std::uint8_t island) const HD_RT;
  [[nodiscard]] double gained(std::uint8_t island, double share) HD_RT;
  [[nodiscard]] bool leavesOverlap(std::uint8_t island) const HD_RT;
  void tell() HD_RT;
  [[nodiscard]] const Mobility& mobilityOf(std::uint8_t mover) const HD_RT {
    return mover == kFixed ? fixed_ : mover_[mover].mobility;
  }
  [[nodiscard]] bool joins(std::uint32_t touch, std::uint8_t island) const HD_RT {
    return mover_[pair_[touch].a].island == island;
  }
  [[nodiscard]] Twist& twistOf(std::uint8_t mover) HD_RT { return mover == kFixed ? still_ : mover_[mover].V; }

  double dt_ = 0;
  Vec3 gravity_ = Vec3::Zero();
  std::array<Mover, kMaxMovers> mover_;
  std::array<Tool::Move, kMaxMovers> moved_;
  std::array<Touch, kMaxJointTouches> touch_;
  std::array<Pair, kMaxJointTouches> pair_{};
  std::array<ConstraintRow, kMaxJointTouches> row_;
  std::array<Vec3, kMaxJointTouches> lambda_;
  std::array<Remembered, kMaxJointTouches> memory_;
  std::uint32_t movers_ = 0, touches_ = 0, remembered_ = 0, rounds_ = 0, work_ = 0, dropped_ = 0;
  bool joined_ = false;  ///< Some touch is between two movers.
  double residual_ = 0;
  JointLeap leap_;
  Solution whole_, without_;  ///< With recovery from overlaps and without.
  Mobility fixed_;
  Twist still_;
};

}  // namespace hapticd
