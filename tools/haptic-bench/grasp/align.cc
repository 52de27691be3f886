#include "tools/haptic-bench/grasp/align.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "tools/haptic-bench/grasp/release.h"
#include "tools/haptic-bench/metric/quantile.h"

namespace haptic_bench::grasp {
namespace {

constexpr double kOneDegree = std::numbers::pi / 180;
constexpr double kTwist = 0.1;              // Of a finger, as the daemon's are [N m/rad].
constexpr double kOpens = 0.2;              // Part of its depth by which a finger opens in a second [1/s],
constexpr double kCloses = 0.02;            // and how fast it closes [m/s].
constexpr double kTurns = 40 * kOneDegree;  // As fast as it is to turn [rad/s].
constexpr double kFirm = 2;                 // Closed so many times as far as where it began to turn.
constexpr double kLost_m = 0.03, kLongest_s = 60, kStays_s = 1;

/** What the person sees: the angle as it was, and where it will be by now. */
class Sight {
 public:
  explicit Sight(double angle) { seen_.fill(angle); }
  void see(double angle) {
    seen_[at_] = angle;
    at_ = (at_ + 1) % seen_.size();
  }
  [[nodiscard]] double rate() const {
    return (seen_[(at_ + kWindow) % seen_.size()] - seen_[at_]) / (kWindow * kPeriod_s);
  }
  [[nodiscard]] double expected() const { return seen_[at_] + rate() * kReaction_s; }

 private:
  static constexpr std::size_t kWindow = 50;
  std::array<double, static_cast<std::size_t>(kReaction_s / kPeriod_s)> seen_;
  std::size_t at_ = 0;
};

void attempt(const Alignment& out, const Hand& hand, Attempt& one) {
  const Block bar = barOf(one.mass, out.lever);
  Rig rig(bar, hand, fingerOf(out.coupled, kSandpaperArm, kTwist));
  rig.grasp(1.5 * yieldsAt(bar, out.coupled, kSandpaperArm, 0) + 1);
  Sight sight(rig.turned());
  const double began = rig.time();
  const auto gone = [&] { return !rig.held() || rig.slid() > kLost_m; };
  double yielded = 0;  // How deep the fingers were then [m].
  while (!gone() && std::abs(sight.expected()) < out.wanted && rig.time() - began < kLongest_s) {
    sight.see(rig.turned());
    if (yielded == 0 && std::abs(sight.rate()) > kTurns / 4) yielded = rig.wanted();
    const bool fast = std::abs(sight.rate()) > kTurns;
    rig.want(fast ? rig.wanted() + kCloses / 10 * kPeriod_s : rig.wanted() * (1 - kOpens * kPeriod_s));
    rig.tick();
  }
  const double firm = kFirm * std::max(yielded, rig.wanted());
  for (double rest = 0; !gone() && rest < kStays_s; rest += kPeriod_s) {
    rig.want(std::min(firm, rig.wanted() + kCloses * kPeriod_s));
    rig.tick();
  }
  one.lost = gone();
  one.off = one.lost ? -out.wanted : std::abs(rig.turned()) - out.wanted;
  one.slid = one.lost ? kLost_m : rig.slid();
}

}  // namespace

double Alignment::error() const {
  std::vector<double> all;
  for (const Attempt& one : attempts) all.push_back(std::abs(one.off));
  return middleOf(all);
}

double Alignment::slid() const {
  std::vector<double> all;
  for (const Attempt& one : attempts) all.push_back(one.slid);
  return middleOf(all);
}

int Alignment::lost() const {
  return static_cast<int>(std::count_if(attempts.begin(), attempts.end(), [](const Attempt& one) { return one.lost; }));
}

std::vector<Alignment> alignments(int persons, double unsteady) {
  std::vector<Alignment> out;
  for (const double lever : {0.005, 0.01, 0.02, 0.04}) {
    for (const double wanted : {30 * kOneDegree, 60 * kOneDegree}) {
      for (const bool coupled : {true, false}) {
        Alignment& one = out.emplace_back(Alignment{coupled, lever, wanted});
        for (const double mass : {0.05, 0.1, 0.2}) {
          for (int person = 1; person <= persons; ++person) {
            Hand hand;
            hand.unsteady = unsteady;
            hand.seed = static_cast<std::uint64_t>(person);
            attempt(one, hand, one.attempts.emplace_back(Attempt{mass, person}));
          }
        }
      }
    }
  }
  return out;
}

}  // namespace haptic_bench::grasp
