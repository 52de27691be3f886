#include "tools/haptic-bench/zwidth/sweep.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <set>
#include <tuple>
#include <utility>

#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/option.h"
#include "tools/haptic-bench/zwidth/eigenvalue.h"
#include "tools/haptic-bench/zwidth/search.h"
#include "tools/haptic-bench/zwidth/theory.h"

namespace haptic_bench::zwidth {
namespace {

double pushFor(double max_force) { return std::min(4.0, 0.6 * max_force); }

Loop loopOf(const Options& options, const Change& change) {
  Loop loop = makeLoop(options.uri, change);
  const double most = loop.device.info.max_force;
  loop.push = options.push ? *options.push : pushFor(most);
  loop.force_slew = options.force_slew;
  if (!(loop.push < most)) {
    throw Failure(fmt::format("zwidth, --push {}", loop.push),
                  fmt::format("{} holds no hand that presses so, having {} N", options.uri, most),
                  fmt::format("--push below {}", most));
  }
  return loop;
}

/** The three devices, each once: the URI of one without friction, or with an ideal encoder, makes two the same. */
std::vector<Change> devicesOf(const Options& options, double rate_hz, std::uint32_t delay) {
  std::vector<Change> asked{{rate_hz, delay, kIdealStep, 0}};
  if (!options.quick) asked.push_back({rate_hz, delay, -1, 0});
  asked.push_back({rate_hz, delay, -1, -1});
  std::vector<Change> devices;
  std::set<std::pair<double, double>> seen;
  for (const Change& change : asked) {
    const hapticd::SimParameters device = loopOf(options, change).device.parameters;
    if (seen.emplace(device.resolution, device.coulomb).second) devices.push_back(change);
  }
  return devices;
}

}  // namespace

double usualPush(const std::string& uri) { return pushFor(makeLoop(uri, {}).device.info.max_force); }

std::vector<Row> plan(const Options& options) {
  std::vector<Row> rows;
  for (const double rate : distinct(options.rates_hz)) {
    for (const std::uint32_t delay : distinct(options.delays)) {
      const std::vector<Change> devices = devicesOf(options, rate, delay);
      for (const double damping : distinct(options.dampings)) {
        double eigenvalue = -1, slowest = 0;  // The same for all three.
        for (const Change& change : devices) {
          const Loop loop = loopOf(options, change);
          const hapticd::SimParameters& device = loop.device.parameters;
          if (eigenvalue < 0) {
            eigenvalue = eigenvalueLimit(loop, damping);
            slowest = slowestLimit(loop, damping);
          }
          Row row;
          row.change = change;
          row.step = device.resolution;
          row.friction = device.coulomb;
          row.damping = damping;
          row.colgate = colgate(device.viscous, damping, 1 / rate);
          row.colgate_delayed = colgateDelayed(device.viscous, damping, 1 / rate, delay);
          row.friction_limit = frictionLimit(device.coulomb, device.resolution);
          row.eigenvalue = eigenvalue;
          row.slowest = slowest;
          rows.push_back(row);
        }
      }
    }
  }
  std::stable_sort(rows.begin(), rows.end(), [](const Row& a, const Row& b) {
    const auto key = [](const Row& r) { return std::tuple(r.change.rate_hz, r.change.delay, r.friction, r.step); };
    return key(a) < key(b);
  });
  return rows;
}

void measure(const Options& options, Row& row) {
  Loop loop = loopOf(options, row.change);
  row.off = largestStable(loop, row.damping, row.slowest > 0 ? row.slowest : row.eigenvalue).stiffness;
  const auto buzz = [&] {
    if (!(row.off > 0)) return std::numeric_limits<double>::quiet_NaN();  // Damping alone is no wall.
    return tap(loop, {kBuzzAt * row.off, row.damping}).buzz;
  };
  row.buzz_off = buzz();
  loop.passivity = true;
  const Limit on = largestStable(loop, row.damping, row.off > 0 ? row.off : row.eigenvalue);
  row.on = on.stiffness;
  row.displayed = on.stiffness > 0 ? on.at.displayed / on.stiffness : 0;
  row.buzz_on = buzz();
}

}  // namespace haptic_bench::zwidth
