#include "tools/haptic-bench/grasp/cubes.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tools/haptic-bench/failure.h"

namespace haptic_bench::grasp {
namespace {

constexpr double kMost = 12;      // Of a finger [N].
constexpr double kLoosens = 0.3;  // Part of its depth by which a finger opens in a second [1/s].
constexpr double kSlides = 5e-4;  // So far, and it is no hold [m].
constexpr double kSeen = 2e-3;    // So far, and it is seen to fall ...
constexpr double kHold_s = 10;
constexpr double kTighter = 2.5e-4;  // The least step of a finger [m].

Block blockOf(const Cube& cube) {
  // Of the thesis: mu_d goes with mu_s.
  const double dynamic = cube.friction < 0.6 ? 0.3 : cube.friction < 1 ? 0.6 : 1.1;
  Block block;
  block.mass = cube.mass;
  block.material = {cube.stiffness, 1, cube.friction, dynamic};
  return block;
}

/** What nobody drops [N]. */
double firm(const Block& block) { return 1.5 * block.slips() + 1; }

/** Where the person thinks that it fell [m], and the force with which it did [N]. */
struct Fall {
  double depth = 0, force = 0;
};
Fall letFall(const Block& block, const Hand& hand) {
  Rig rig(block, hand);
  rig.grasp(firm(block));
  Fall fall{0, rig.grip()};
  while (rig.slid() < kSeen && rig.held()) {
    if (rig.slid() < kSlides / 5) fall.force = rig.grip();
    rig.want(rig.wanted() * (1 - kLoosens * kPeriod_s));
    rig.tick();
  }
  fall.depth = rig.wanted() * (1 - kLoosens * kReaction_s);
  return fall;
}

/** The mean force over ten seconds at that depth; 0 where it slid. */
double hold(const Block& block, const Hand& hand, double depth) {
  Rig rig(block, hand);
  if (depth > rig.depthFor(kMost)) throw Failure("grasp", "a cube is not held by 12 N", "a steadier hand: --unsteady");
  rig.grasp(firm(block));
  while (rig.wanted() > depth) {
    rig.want(std::max(depth, rig.wanted() * (1 - kLoosens * kPeriod_s)));
    rig.tick();
    if (rig.slid() > kSlides) return 0;
  }
  const int ticks = static_cast<int>(kHold_s / kPeriod_s);
  double sum = 0;
  for (int i = 0; i < ticks; ++i) {
    rig.tick();
    if (rig.slid() > kSlides) return 0;
    sum += rig.grip();
  }
  return sum / ticks;
}

std::vector<double> ranks(const std::vector<double>& x) {
  std::vector<std::size_t> order(x.size());
  std::iota(order.begin(), order.end(), 0U);
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return x[a] < x[b]; });
  std::vector<double> out(x.size());
  for (std::size_t i = 0; i < order.size();) {
    std::size_t end = i;
    while (end < order.size() && x[order[end]] == x[order[i]]) ++end;
    for (std::size_t k = i; k < end; ++k) out[order[k]] = static_cast<double>(i + end - 1) / 2;
    i = end;
  }
  return out;
}

}  // namespace

double spearman(const std::vector<double>& x, const std::vector<double>& y) {
  const std::vector<double> a = ranks(x), b = ranks(y);
  const double middle = (static_cast<double>(x.size()) - 1) / 2;
  double ab = 0, aa = 0, bb = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    ab += (a[i] - middle) * (b[i] - middle);
    aa += (a[i] - middle) * (a[i] - middle);
    bb += (b[i] - middle) * (b[i] - middle);
  }
  return ab / std::sqrt(aa * bb);
}

Hold Cube::mean() const {
  Hold sum;
  for (const Hold& one : holds) {
    sum.fell += one.fell / static_cast<double>(holds.size());
    sum.held += one.held / static_cast<double>(holds.size());
  }
  return sum;
}

std::vector<Cube> holdCubes(int persons, int turns, double unsteady) {
  std::vector<Cube> cubes;
  std::uint64_t seed = 0;
  for (const double mass : {0.1, 0.2, 0.4}) {
    for (const double friction : {0.4, 0.8, 1.2}) {
      for (const double stiffness : {500.0, 1000.0, 2000.0}) {
        Cube& cube = cubes.emplace_back(Cube{mass, friction, stiffness});
        const Block block = blockOf(cube);
        cube.slips = block.slips();
        for (int i = 0; i < persons * turns; ++i) {
          Hand hand;
          hand.unsteady = unsteady;
          hand.seed = ++seed;
          const Fall fall = letFall(block, hand);
          Hold& one = cube.holds.emplace_back(Hold{fall.force, 0});
          for (double depth = fall.depth; one.held == 0; depth += kTighter) one.held = hold(block, hand, depth);
        }
      }
    }
  }
  return cubes;
}

Correlations correlate(const std::vector<Cube>& cubes) {
  std::vector<double> friction, mass, stiffness, grip;
  for (const Cube& cube : cubes) {
    for (const Hold& one : cube.holds) {
      friction.push_back(cube.friction);
      mass.push_back(cube.mass);
      stiffness.push_back(cube.stiffness);
      grip.push_back(one.held);
    }
  }
  return {spearman(friction, grip), spearman(mass, grip), spearman(stiffness, grip)};
}

}  // namespace haptic_bench::grasp
