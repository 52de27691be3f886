/** @file
 * The sweep of haptic-bench zwidth: one row for each rate, delay, encoder step, friction and damping.
 */
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tools/haptic-bench/zwidth/loop.h"

namespace haptic_bench::zwidth {

struct Options {
  std::string uri = "sim://default";
  std::vector<double> rates_hz{1000, 2000, 4000};
  std::vector<std::uint32_t> delays{0, 1, 2, 3};             ///< [ticks]
  std::vector<double> dampings{0, 1, 2, 5, 10, 20, 40, 80};  ///< Of the wall [N s/m].
  std::optional<double> push;                                ///< Else usualPush() [N].
  double force_slew = 1e6;                                   ///< [N/s]
  bool quick = false;  ///< The ideal encoder without friction and the device as it is, not what lies between.
};

/** Steps of an encoder called ideal [m]: far below what anything else resolves. */
inline constexpr double kIdealStep = 1e-9;
/** Buzz is compared at this part of the stiffness that is stable without the controller. */
inline constexpr double kBuzzAt = 0.9;

/** With which the hand presses where nobody says: 4 N, or three fifths of what a weaker device has [N]. */
[[nodiscard]] double usualPush(const std::string& uri);

/** Stiffnesses in N/m. */
struct Row {
  Change change;
  double step = 0, friction = 0;  ///< As it was [m], [N].
  double damping = 0;             ///< Of the wall [N s/m].
  double colgate = 0, colgate_delayed = 0, friction_limit = 0;
  double eigenvalue = 0, slowest = 0;
  double off = 0, on = 0;            ///< Largest stable, without and with the controller.
  double displayed = 0;              ///< With the controller at `on`, over `on`.
  double buzz_off = 0, buzz_on = 0;  ///< At kBuzzAt of `off` [N^2]; nan where that is 0.
};

/** The configurations in order of rate, delay, device; theory only. Throws Failure for a bad URI. */
[[nodiscard]] std::vector<Row> plan(const Options& options);
/** Fills in what is measured. */
void measure(const Options& options, Row& row);

/** One promise over all rows. */
struct Goal {
  std::string name;
  int rows = 0;  ///< That it speaks of.
  int missed = 0;
  double worst = 0;  ///< The ratio furthest on the wrong side of what is promised.
  double asked = 0;  ///< The ratio promised.
};
/** What docs/stability.md promises, over rows that are measured. */
[[nodiscard]] std::vector<Goal> judge(const std::vector<Row>& rows);

}  // namespace haptic_bench::zwidth
