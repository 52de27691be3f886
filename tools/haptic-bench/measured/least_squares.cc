#include "tools/haptic-bench/measured/least_squares.h"

#include <Eigen/Eigenvalues>

namespace haptic_bench {

LeastSquares leastSquares(const NormalMatrix& normal, const Unknowns& right, double least) {
  const Eigen::Index count = right.size();
  LeastSquares solved{Unknowns::Zero(count), 0, NormalMatrix::Zero(count, count)};
  const Eigen::SelfAdjointEigenSolver<NormalMatrix> modes(normal);
  for (Eigen::Index i = 0; i < count; ++i) {
    const double value = modes.eigenvalues()[i];
    if (!(value > least * modes.eigenvalues()[count - 1])) continue;
    const Unknowns mode = modes.eigenvectors().col(i);
    solved.x += mode * (mode.dot(right) / value);
    solved.inverse += mode * (mode / value).transpose();
    ++solved.rank;
  }
  return solved;
}

}  // namespace haptic_bench
