/** @file
 * All touches of a step solved at once, as they press and stick now: what brings projected Gauss-Seidel on where it
 * crawls. In a sweep a light body hands on no more of a heavy one's load than its share of both masses: a box on one of
 * a thousandth needs thousands of sweeps, and a few such leaps.
 *
 * With what the touches' velocities lack, b, and a softness e, kSoft of each row's own answer, the change d of the
 * impulses is a step of the proximal point method (Rockafellar 1976), once who presses and who sticks is settled:
 *
 *     J W J' d + e d = b.   With W = L L', G = J L, y = G' d:   (1 + G' e^-1 G) y = G' e^-1 b,   d = e^-1 (b - G y)
 *
 * Six unknowns a body however many touches, and those that are redundant share the load. Then the impulses are made
 * what they may be: none pulls, friction stays in its disc, what slides does so with its share. What was guessed wrong
 * about pressing and sticking the sweeps between two leaps put right. Touches that contradict each other are torn apart
 * by 1 / e: a hundredth of this softness threw boxes about.
 */
#pragma once

#include <array>
#include <span>

#include "rt/body/constraint_row.h"
#include "rt/command.h"

namespace hapticd {

/** Servo-safe; one thread. Movers and touches are set once a step; then solve() may be asked repeatedly. */
class JointLeap {
 public:
  static constexpr std::uint32_t kMovers = kMaxDevices + kMaxBodies;
  static constexpr std::uint32_t kTouches = 96;
  static constexpr double kSoft = 1e-2;

  void setMover(std::uint32_t mover, const Mobility& mobility) HD_RT;
  /** `b`: kMovers and above: nothing moves it. */
  void setTouch(std::uint32_t i, const Touch& touch, const ConstraintRow& row, std::uint8_t a, std::uint8_t b) HD_RT;
  /** Changes the impulses. `lacks`: what each touch's velocity lacks, in its row's axes [m/s]. */
  void solve(std::uint32_t movers, std::span<const Touch> touch, std::span<const ConstraintRow> row,
             std::span<const Vec3> lacks, std::span<Vec3> lambda) HD_RT;
  /** What solve() costs at most, in relaxations. */
  [[nodiscard]] static std::uint32_t costOf(std::uint32_t movers, std::uint32_t touches) HD_RT {
    return 3 * touches + movers * (movers + 1) * (movers + 2) / 6;
  }

 private:
  using Vec6 = Eigen::Matrix<double, 6, 1>;
  using Mat6 = Eigen::Matrix<double, 6, 6>;
  using Mat63 = Eigen::Matrix<double, 6, 3>;
  enum class Does : std::uint8_t { kNothing, kSlides, kSticks };
  struct Side {
    Mat63 of_a, of_b;  ///< G's rows: by the touch's axis.
    std::uint8_t a = 0, b = 0;
    Does does = Does::kNothing;
  };
  /** How many of a touch's axes are solved for. */
  [[nodiscard]] static int axesOf(Does does) HD_RT { return does == Does::kSticks ? 3 : does == Does::kSlides ? 1 : 0; }
  [[nodiscard]] static Vec3 softnessOf(const ConstraintRow& row) HD_RT {
    return {kSoft * row.K(0, 0) + row.give, kSoft * row.K(1, 1), kSoft * row.K(2, 2)};
  }
  void gather(std::uint32_t movers, std::span<const ConstraintRow> row, std::span<const Vec3> lacks) HD_RT;
  void factorAndSolve(std::uint32_t movers) HD_RT;

  std::array<Mat6, kMovers> root_;  ///< L of each mover.
  std::array<Side, kTouches> side_;
  std::array<std::array<Mat6, kMovers>, kMovers>
      block_;  ///< Of the matrix, then of its Cholesky factor: [row][column].
  std::array<std::array<bool, kMovers>, kMovers> full_{};  ///< Which are not zero.
  std::array<Vec6, kMovers> y_;
};

}  // namespace hapticd
