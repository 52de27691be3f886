#include "tools/haptic-bench/grasp/goals.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/haptic-bench/metric/quantile.h"

namespace haptic_bench::grasp {
namespace {

constexpr double kFell = 0.1, kFell_n = 0.2;  // Unsteady fingers press by as much more or less.
constexpr double kYields = 0.02;

/** The mean margin of the cubes that `of` picks. */
template <class Of>
double margin(const std::vector<Cube>& cubes, const Of& of) {
  double sum = 0;
  int count = 0;
  for (const Cube& cube : cubes) {
    if (!of(cube)) continue;
    sum += cube.margin();
    ++count;
  }
  return sum / count;
}

double error(const std::vector<Alignment>& all, bool coupled) {
  std::vector<double> off;
  for (const Alignment& one : all) {
    if (one.coupled != coupled) continue;
    for (const Attempt& attempt : one.attempts) off.push_back(std::abs(attempt.off));
  }
  return middleOf(off);
}

}  // namespace

std::vector<Goal> judge(const std::vector<Cube>& cubes) {
  const Correlations r = correlate(cubes);
  const auto falls = [](const Cube& cube) {
    return std::abs(cube.mean().fell - cube.slips) <= std::max(kFell * cube.slips, kFell_n);
  };
  const auto weighs = [&](double mass) { return margin(cubes, [&](const Cube& c) { return c.mass == mass; }); };
  const auto stiff = [&](double k) { return margin(cubes, [&](const Cube& c) { return c.stiffness == k; }); };
  return {{fmt::format("cubes fall within {:g} % or {:g} N of m g / (2 mu_s)", 100 * kFell, kFell_n),
           std::all_of(cubes.begin(), cubes.end(), falls)},
          {"grip falls with friction, and rises with mass and stiffness (table 2.2)",
           r.friction < 0 && r.mass > 0 && r.stiffness > 0},
          {"the heavier, the smaller the margin (figure 2.6)", weighs(0.1) > weighs(0.2) && weighs(0.2) > weighs(0.4)},
          {"the softer, the smaller the margin (figure 2.7)", stiff(500) < stiff(1000) && stiff(1000) < stiff(2000)}};
}

std::vector<Goal> judge(const std::vector<Release>& releases) {
  const auto all = [&](const auto& holds) { return std::all_of(releases.begin(), releases.end(), holds); };
  return {{fmt::format("bars yield within {:g} % of the closed form", 100 * kYields),
           all([](const Release& r) { return std::abs(r.yields / r.closed - 1) <= kYields; })},
          {"uncoupled, they slide unturned where L < L_0, and turn without sliding beyond", all([](const Release& r) {
             if (r.coupled || r.lever == r.arm) return true;
             return r.lever < r.arm ? r.turned_5 < 0.05 : r.slid_10 < 1e-4;
           })},
          {"coupled, they slide the less on the way the longer the lever", all([&](const Release& r) {
             return all([&](const Release& longer) {
               return !r.coupled || !longer.coupled || longer.arm != r.arm || longer.lever <= r.lever ||
                      !std::isfinite(r.slid_10) || longer.slid_10 < r.slid_10;
             });
           })}};
}

std::vector<Goal> judge(const std::vector<Alignment>& alignments) {
  return {
      {"coupled, blocks are aligned more closely (figure 2.25)", error(alignments, true) < error(alignments, false)},
      {"of 20 mm and longer none is lost", std::all_of(alignments.begin(), alignments.end(), [](const Alignment& one) {
         return one.lever < 0.02 || one.lost() == 0;
       })}};
}

}  // namespace haptic_bench::grasp
