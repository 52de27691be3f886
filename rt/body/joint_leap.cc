#include "rt/body/joint_leap.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace hapticd {

void JointLeap::setMover(std::uint32_t mover, const Mobility& mobility) HD_RT {
  Mat6 W;
  W << mobility.vp, mobility.vl, mobility.vl.transpose(), mobility.wl;
  root_[mover] = W.llt().matrixL();
}

void JointLeap::setTouch(std::uint32_t i, const Touch& touch, const ConstraintRow& row, std::uint8_t a,
                         std::uint8_t b) HD_RT {
  Side& side = side_[i];
  side.a = a;
  side.b = b;
  Mat63 J;
  J << row.axes, crossMatrix(touch.r_a) * row.axes;
  side.of_a = root_[a].transpose() * J;
  if (b >= kMovers) return;
  J << -row.axes, -crossMatrix(touch.r_b) * row.axes;
  side.of_b = root_[b].transpose() * J;
}

void JointLeap::gather(std::uint32_t movers, std::span<const ConstraintRow> row, std::span<const Vec3> lacks) HD_RT {
  for (std::uint32_t k = 0; k < movers; ++k) {
    block_[k][k].setIdentity();
    std::fill_n(full_[k].begin(), k, false);
    y_[k].setZero();
  }
  for (std::size_t i = 0; i < row.size(); ++i) {
    const Side& side = side_[i];
    const Vec3 soft = softnessOf(row[i]);
    const std::uint32_t low = std::max(side.a, side.b), high = std::min(side.a, side.b);
    for (int x = 0; x < axesOf(side.does); ++x) {
      const Vec6 a = side.of_a.col(x) / soft[x];
      block_[side.a][side.a].noalias() += a * side.of_a.col(x).transpose();
      y_[side.a] += a * lacks[i][x];
      if (side.b >= kMovers) continue;
      const Vec6 b = side.of_b.col(x) / soft[x];
      block_[side.b][side.b].noalias() += b * side.of_b.col(x).transpose();
      y_[side.b] += b * lacks[i][x];
      Mat6& across = block_[low][high];
      if (!full_[low][high]) across.setZero();
      full_[low][high] = true;
      if (low == side.a) {
        across.noalias() += a * side.of_b.col(x).transpose();
      } else {
        across.noalias() += b * side.of_a.col(x).transpose();
      }
    }
  }
}

/** Cholesky's factor by blocks, of those that are not zero: bodies that do not touch cost nothing. Then y. */
void JointLeap::factorAndSolve(std::uint32_t movers) HD_RT {
  for (std::uint32_t j = 0; j < movers; ++j) {
    Mat6& diagonal = block_[j][j];
    for (std::uint32_t k = 0; k < j; ++k) {
      if (!full_[j][k]) continue;
      diagonal.noalias() -= block_[j][k] * block_[j][k].transpose();
      y_[j].noalias() -= block_[j][k] * y_[k];
    }
    diagonal = Mat6(diagonal.llt().matrixL());
    diagonal.triangularView<Eigen::Lower>().solveInPlace(y_[j]);
    for (std::uint32_t i = j + 1; i < movers; ++i) {
      Mat6& below = block_[i][j];
      for (std::uint32_t k = 0; k < j; ++k) {
        if (!full_[i][k] || !full_[j][k]) continue;
        if (!full_[i][j]) below.setZero();
        full_[i][j] = true;
        below.noalias() -= block_[i][k] * block_[j][k].transpose();
      }
      if (full_[i][j]) diagonal.triangularView<Eigen::Lower>().transpose().solveInPlace<Eigen::OnTheRight>(below);
    }
  }
  for (std::uint32_t j = movers; j-- > 0;) {
    for (std::uint32_t i = j + 1; i < movers; ++i) {
      if (full_[i][j]) y_[j].noalias() -= block_[i][j].transpose() * y_[i];
    }
    block_[j][j].triangularView<Eigen::Lower>().transpose().solveInPlace(y_[j]);
  }
}

void JointLeap::solve(std::uint32_t movers, std::span<const Touch> touch, std::span<const ConstraintRow> row,
                      std::span<const Vec3> lacks, std::span<Vec3> lambda) HD_RT {
  for (std::size_t i = 0; i < touch.size(); ++i) {
    const double limit = touch[i].friction * lambda[i][0];
    const bool presses = lambda[i][0] > 0 || lacks[i][0] > 0;
    const bool sticks = std::hypot(lambda[i][1], lambda[i][2]) < (1 - 1e-9) * limit;
    side_[i].does = !presses || !(row[i].K(0, 0) > 0) ? Does::kNothing : sticks ? Does::kSticks : Does::kSlides;
  }
  gather(movers, row, lacks);
  factorAndSolve(movers);
  for (std::size_t i = 0; i < touch.size(); ++i) {
    const Side& side = side_[i];
    if (side.does == Does::kNothing) continue;
    const Vec3 soft = softnessOf(row[i]);
    Vec3 next = lambda[i];
    for (int x = 0; x < axesOf(side.does); ++x) {
      double gained = side.of_a.col(x).dot(y_[side.a]);
      if (side.b < kMovers) gained += side.of_b.col(x).dot(y_[side.b]);
      next[x] += (lacks[i][x] - gained) / soft[x];
    }
    if (!isFinite(next)) continue;  // Something is free in no direction across: sweeps know what to do.
    next[0] = std::max(0.0, next[0]);
    if (side.does == Does::kSlides && lambda[i][0] > 0) next.tail<2>() *= next[0] / lambda[i][0];
    const double across = std::hypot(next[1], next[2]);
    const double limit = touch[i].friction * next[0];
    if (across > limit) next.tail<2>() *= limit / across;
    lambda[i] = next;
  }
}

}  // namespace hapticd
