/** @file
 * haptic-bench servo: a bare SCHED_FIFO loop that only sleeps (what cyclictest does) against the daemon's whole cycle
 * on a mesh, in turns: how much later does the daemon wake, and what share of a millisecond does it take.
 */
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>

#include "rt/base/standard_streams.h"
#include "rt/cycle/realtime.h"
#include "tools/haptic-bench/bench.h"
#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/load/servo_sides.h"
#include "tools/haptic-bench/load/stroke.h"
#include "tools/haptic-bench/model/built_mesh.h"
#include "tools/haptic-bench/option.h"

namespace haptic_bench {
namespace {

constexpr double kSphereRadius = 0.05;  // [m]
constexpr double kNsPerUs = 1e3;

struct ServoOptions {
  double rate_hz = 1000;
  double seconds = 1.5;
  std::uint32_t triangles = 100'000;
  bool one_cpu = false;
};

/** One side's slices. */
struct Side {
  std::string name;
  std::vector<Wakes> slices;

  /** A quantile of each slice, for the spread between them. */
  [[nodiscard]] Series each(const std::string& quantity, double part) const {
    Series series{name + " " + quantity, "us", {}};
    for (const Wakes& slice : slices) series.rounds.push_back(pooledQuantile({slice}, part) / kNsPerUs);
    return series;
  }
  [[nodiscard]] Series pooled(const std::string& quantity, double part) const {
    return {fmt::format("{} {}{}", name, quantity, kPooled), "us", {pooledQuantile(slices, part) / kNsPerUs}};
  }
};

int run(const Common& common, const ServoOptions& options) {
  hapticd::SnapshotMemory memory = buildMesh(tessellate({kSphereRadius}, options.triangles));
  hapticd::MonotonicClock clock;
  Note note;
  if (auto locked = hapticd::lockMemory(); !locked) note = toString(locked.error());
  hapticd::CpuLatencyHold awake;
  (void)awake.hold();  // For both sides; a virtual machine has no such file.

  Side bare{"bare loop", {}}, daemon{"daemon", {}};
  Series cycle50{"cycle p50", "us", {}}, cycle99{"cycle p99", "us", {}}, share{"cycle p50 / 1 ms", "%", {}};
  Series render50{"render p50", "us", {}}, missed{"missed periods", "", {}},
      touched{"in contact in this round", "", {}};
  const auto cpus = static_cast<std::uint32_t>(std::max(1L, sysconf(_SC_NPROCESSORS_ONLN)));
  for (int round = 0; round < common.rounds; ++round) {
    // Each processor in turn, and on each the two sides in either order: neither inherits the other's luck.
    const Slice slice{options.rate_hz, options.seconds,
                      options.one_cpu ? 0 : static_cast<std::uint32_t>(round) / 2 % cpus};
    for (const bool bares : {round % 2 == 0, round % 2 != 0}) {
      if (bares) {
        bare.slices.push_back(runBare(slice, clock, note));
        continue;
      }
      House house(slice, memory.view, clock, note);
      daemon.slices.push_back(house.run());
      const hapticd::Servo& servo = house.servo();
      const hapticd::Histogram::Summary cycle = servo.histograms.cycle.summary();
      cycle50.rounds.push_back(static_cast<double>(cycle.p50_ns) / kNsPerUs);
      cycle99.rounds.push_back(static_cast<double>(cycle.p99_ns) / kNsPerUs);
      share.rounds.push_back(static_cast<double>(cycle.p50_ns) / 1e4);
      render50.rounds.push_back(static_cast<double>(servo.histograms.render.summary().p50_ns) / kNsPerUs);
      missed.rounds.push_back(static_cast<double>(servo.counters.missed.load()));
      touched.rounds.push_back(servo.counters.contacts.load() > 0 ? 1.0 : 0.0);
    }
  }
  if (!note.empty()) hapticd::tellError(fmt::format("haptic-bench: not real-time: {}\n", note));

  std::vector<Series> all;
  for (const Side* side : {&bare, &daemon}) {
    all.push_back(side->each("wake p50", 0.5));
    all.push_back(side->each("wake p99", 0.99));
    all.push_back(side->each("wake max", 1));
    all.push_back(side->pooled("wake p99", 0.99));
    all.push_back(side->pooled("wake p99.9", 0.999));
  }
  for (const auto& [quantity, part] : {std::pair{"wake p99", 0.99}, std::pair{"wake p99.9", 0.999}}) {
    const Interval ratio = pooledRatio(daemon.slices, bare.slices, part, 1);
    for (const auto& [of, value] :
         {std::pair{kPooled, ratio.value}, {kPooledLow, ratio.low}, {kPooledHigh, ratio.high}})
      all.push_back({fmt::format("{}, daemon / bare{}", quantity, of), "", {value}});
  }
  all.insert(all.end(), {render50, cycle50, cycle99, share, missed, touched});
  print(common, "servo", all,
        fmt::format("{} Hz, {} triangles, slices of {} s{}", options.rate_hz, options.triangles, options.seconds,
                    options.one_cpu ? ", one processor" : ""));
  if (std::find(touched.rounds.begin(), touched.rounds.end(), 0.0) == touched.rounds.end()) return 0;
  hapticd::tellError("haptic-bench servo: a round without contact; the cost of its cycle is worth nothing\n");
  return 1;
}

}  // namespace

void addServo(CLI::App& app, Run& chosen) {
  auto options = std::make_shared<ServoOptions>();
  CLI::App* servo = app.add_subcommand(
      "servo",
      "Wake-up of a bare real-time loop against the daemon's cycle on a mesh, and what the cycle costs\n"
      "(exit 1 if a round touches nothing)");
  bounded(servo, "--rate", options->rate_hz, "Servo rate [Hz]", 100.0, 4000.0);
  bounded(servo, "--seconds", options->seconds, "Length of each side of a round [s]", 0.1, 600.0);
  bounded(servo, "--triangles", options->triangles, "Triangles of the sphere that is stroked", 100, 8'000'000);
  servo->add_flag("--one-cpu", options->one_cpu, "Both sides on the first processor, not on each in turn");
  whenNamed(servo, chosen, [options](const Common& common) { return run(common, *options); });
}

}  // namespace haptic_bench
