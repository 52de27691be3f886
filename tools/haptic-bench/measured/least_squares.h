/** @file
 * Few unknowns from many equations.
 */
#pragma once

#include <Eigen/Core>

namespace haptic_bench {

inline constexpr int kMaxUnknowns = 6;
using Unknowns = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxUnknowns, 1>;
using NormalMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxUnknowns, kMaxUnknowns>;

/** Of the solutions the shortest, how many of the unknowns the equations determine, and the pseudo-inverse. */
struct LeastSquares {
  Unknowns x;
  int rank = 0;
  NormalMatrix inverse;
};

/**
 * Solves normal * x = right, for sums of A' A and A' b: by the eigenvectors of `normal`, without those whose eigenvalue
 * (a squared singular value of A) is at most `least` of the largest.
 */
[[nodiscard]] LeastSquares leastSquares(const NormalMatrix& normal, const Unknowns& right, double least);

}  // namespace haptic_bench
