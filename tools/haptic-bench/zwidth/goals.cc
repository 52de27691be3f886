// What is promised of the closed loop, judged over a sweep.
#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "tools/haptic-bench/zwidth/search.h"
#include "tools/haptic-bench/zwidth/sweep.h"

namespace haptic_bench::zwidth {
namespace {

constexpr double kWithin = 0.05;

/** A goal that a ratio is at least so much. */
class AtLeast {
 public:
  AtLeast(std::string name, double asked) : goal_{std::move(name), 0, 0, 0, asked} {}
  void take(double ratio) {
    if (goal_.rows == 0 || ratio < goal_.worst) goal_.worst = ratio;
    ++goal_.rows;
    if (!(ratio >= goal_.asked)) ++goal_.missed;
  }
  [[nodiscard]] const Goal& goal() const { return goal_; }

 private:
  Goal goal_;
};

/** Best wall of one curve over the damping. */
struct Curve {
  double off = 0, on = 0;
  double best_damping = 0;  ///< Of `off`.
};

auto keyOf(const Row& r) { return std::tuple(r.change.rate_hz, r.change.delay, r.step, r.friction); }

}  // namespace

std::vector<Goal> judge(const std::vector<Row>& rows) {
  std::map<decltype(keyOf(rows.front())), Curve> curves;
  for (const Row& row : rows) {
    Curve& curve = curves[keyOf(row)];
    if (row.off > curve.off) curve.best_damping = row.damping;
    curve.off = std::max(curve.off, row.off);
    curve.on = std::max(curve.on, row.on);
  }
  AtLeast linear("ideal encoder: off within 5 % of the eigenvalue limit", 1 - kWithin);
  AtLeast real("as the device is: off over 95 % of the limit at the estimator's slowest", 1 - kWithin);
  AtLeast passive("off over Colgate and Schenkel", 1);
  AtLeast twice("on over off, where off is at most half the best", 2);
  AtLeast best("best on over best off", 1 - 2 * kPrecision);
  AtLeast shown("stiffness displayed at the limit, within 5 %", 1 - kWithin);
  for (const Row& row : rows) {
    const Curve& curve = curves[keyOf(row)];
    if (row.step <= kIdealStep && row.friction == 0 && row.eigenvalue > 0) {
      linear.take(std::min(row.off / row.eigenvalue, row.eigenvalue / std::max(row.off, 1.0)));
    }
    if (row.step > kIdealStep && row.slowest > 0) real.take(row.off / row.slowest);
    if (row.colgate_delayed > 0) passive.take(row.off / row.colgate_delayed);
    if (row.damping <= curve.best_damping && 2 * row.off <= curve.off && row.off > 0) twice.take(row.on / row.off);
    if (row.on > 0) shown.take(1 - std::abs(row.displayed - 1));
  }
  for (const auto& [key, curve] : curves) {
    if (curve.off > 0) best.take(curve.on / curve.off);
  }
  return {linear.goal(), real.goal(), passive.goal(), twice.goal(), best.goal(), shown.goal()};
}

}  // namespace haptic_bench::zwidth
