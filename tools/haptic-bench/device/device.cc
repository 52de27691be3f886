/** @file
 * haptic-bench device: each driver against its played device. In virtual time what the protocol itself costs in delay,
 * and the processor time of the driver; in real time what threads and hand-over add to it on this machine.
 */
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

#include "rt/cycle/realtime.h"
#include "tools/haptic-bench/bench.h"
#include "tools/haptic-bench/device/played_device.h"
#include "tools/haptic-bench/failure.h"

namespace haptic_bench {
namespace {

using namespace hapticd;

constexpr std::int64_t kTick_ns = 1'000'000, kGrain_ns = 62'500;
constexpr std::int64_t kHalfWave = 25;  ///< Ticks of force, then as many without.
constexpr double kNewtons = 1;
constexpr std::int64_t kSettle_ns = 400'000'000;  ///< Until the grip is where its hand wants it.

struct Options {
  double seconds = 1;
};

double part(std::vector<double> values, double quantile) {
  if (values.empty()) return std::nan("");
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(quantile * static_cast<double>(values.size() - 1))];
}

void openOrThrow(IoDevice& device) {
  if (auto opening = device.open(); !opening) throw Failure(opening.error());
}

DeviceCommand waveAt(std::int64_t tick) {
  DeviceCommand command;
  command.enabled = tick / kHalfWave % 2 != 0;
  if (command.enabled) command.force.x() = kNewtons;
  return command;
}

/** What the protocol gives, whatever the machine. */
struct Protocol {
  double rate_hz = 0;
  std::vector<double> age_us, delay_us;  ///< Of a reading at the servo; from a command to the motors.
  std::uint64_t complaints = 0;
  double driver_us = 0;  ///< Processor time of the driver for each tick.
};

/** A servo at 1 kHz in virtual time; `phase_ns` sets its ticks off from the device's. */
void measure(const PlayedCase& played, std::int64_t phase_ns, std::int64_t count, Protocol& to) {
  ManualClock clock;
  const auto rig = played.make(clock, false);
  IoDevice& device = rig->device();
  openOrThrow(device);
  device.pump((clock.now() + kSettle_ns) / kTick_ns * kTick_ns + phase_ns);
  const LinkCounters& counters = device.link().counters;
  const std::uint64_t before = counters.lost + counters.dropped_bytes + counters.rejected + counters.stale_commands;
  rig->cost.inside_ns = 0;
  std::int64_t fresh = 0, commanded_ns = -1, real_ns = 0;
  DeviceSample sample;
  for (std::int64_t tick = 0; tick < count; ++tick) {
    const std::int64_t now_ns = clock.now();
    device.read(now_ns, sample);
    if (sample.fresh) {
      ++fresh;
      to.age_us.push_back(static_cast<double>(now_ns - sample.t_ns) * 1e-3);
    }
    const DeviceCommand command = waveAt(tick);
    device.write(now_ns, command);
    if (tick % kHalfWave == 0 && tick >= kHalfWave) commanded_ns = now_ns;
    for (std::int64_t at_ns = now_ns + kGrain_ns; at_ns <= now_ns + kTick_ns; at_ns += kGrain_ns) {
      const auto from = std::chrono::steady_clock::now();
      device.pump(at_ns);
      real_ns += std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now() - from).count();
      const bool pushes = rig->force().norm() > 0.5 * kNewtons;
      if (played.motors && commanded_ns >= 0 && pushes == command.enabled) {
        to.delay_us.push_back(static_cast<double>(clock.now() - commanded_ns) * 1e-3);
        commanded_ns = -1;
      }
    }
  }
  to.complaints += counters.lost + counters.dropped_bytes + counters.rejected + counters.stale_commands - before;
  to.rate_hz += static_cast<double>(fresh) / static_cast<double>(count) * 1000;
  to.driver_us += static_cast<double>(real_ns - rig->cost.inside_ns) * 1e-3 / static_cast<double>(count);
}

Protocol measure(const PlayedCase& played, double seconds) {
  constexpr std::int64_t kPhases = kTick_ns / kGrain_ns;
  Protocol all;
  const auto count = std::max<std::int64_t>(4 * kHalfWave, std::llround(seconds * 1000 / kPhases));
  for (std::int64_t phase = 0; phase < kPhases; ++phase) measure(played, phase * kGrain_ns, count, all);
  all.rate_hz /= kPhases;
  all.driver_us /= kPhases;
  return all;
}

/** The device's own thread and a servo's, on this machine's clock. */
struct Threads {
  Histogram::Summary round_trip, age;
};
Threads runThreads(const PlayedCase& played, double seconds, std::string& note) {
  FromNow clock;
  const auto rig = played.make(clock, true);
  IoDevice& device = rig->device();
  openOrThrow(device);
  if (!device.schedulingNote().empty()) note = device.schedulingNote();
  RtThread servo;
  const auto started = servo.start("servo", 256 * 1024, [&] {
    (void)becomeRealtime(80);
    DeviceSample sample;
    std::int64_t deadline_ns = (clock.now() / kTick_ns + 1) * kTick_ns;
    for (std::int64_t tick = 0; tick < std::llround(seconds * 1000); ++tick, deadline_ns += kTick_ns) {
      clock.sleepUntil(deadline_ns);
      const std::int64_t now_ns = clock.now();
      device.read(now_ns, sample);
      device.write(now_ns, waveAt(tick));
    }
  });
  if (!started) throw Failure(started.error());
  servo.join();
  const Threads out{device.link().round_trip.summary(), device.link().age.summary()};
  device.close();
  return out;
}

int run(const Common& common, const Options& options) {
  std::vector<Series> all;
  std::string note;
  bool good = true;
  for (const PlayedCase& played : playedCases()) {
    Series driver{played.name + ": driver", "us a tick", {}},
        trip50{played.name + ": threads, round trip p50", "us", {}};
    Series trip99{played.name + ": threads, round trip p99", "us", {}},
        trip100{played.name + ": threads, round trip max", "us", {}};
    Series age50{played.name + ": threads, age p50", "us", {}}, age99{played.name + ": threads, age p99", "us", {}};
    Protocol protocol;
    for (int round = 0; round < common.rounds; ++round) {
      protocol = measure(played, options.seconds);  // All but the processor time is the same each time.
      driver.rounds.push_back(protocol.driver_us);
      const Threads threads = runThreads(played, options.seconds, note);
      if (threads.round_trip.count != 0) {  // Not every device answers what it is told.
        trip50.rounds.push_back(static_cast<double>(threads.round_trip.p50_ns) * 1e-3);
        trip99.rounds.push_back(static_cast<double>(threads.round_trip.p99_ns) * 1e-3);
        trip100.rounds.push_back(static_cast<double>(threads.round_trip.max_ns) * 1e-3);
      }
      age50.rounds.push_back(static_cast<double>(threads.age.p50_ns) * 1e-3);
      age99.rounds.push_back(static_cast<double>(threads.age.p99_ns) * 1e-3);
    }
    const auto one = [&](const char* what, const char* unit, double value) {
      all.push_back({played.name + ": " + what, unit, {value}});
    };
    one("readings", "Hz", protocol.rate_hz);
    one("age of a reading, median", "us", part(protocol.age_us, 0.5));
    one("age of a reading, worst", "us", part(protocol.age_us, 1));
    if (!protocol.delay_us.empty()) {  // Else it has no motors.
      one("command to motors, median", "us", part(protocol.delay_us, 0.5));
      one("command to motors, worst", "us", part(protocol.delay_us, 1));
    }
    one("wrong or late on the wire", "", static_cast<double>(protocol.complaints));
    all.push_back(driver);
    if (!trip50.rounds.empty()) all.insert(all.end(), {trip50, trip99, trip100});
    all.insert(all.end(), {age50, age99});
    good = good && protocol.rate_hz >= played.least_hz && protocol.complaints == 0;
  }
  if (!note.empty()) fmt::print(stderr, "haptic-bench: not real-time: {}\n", note);
  print(common, "device", all);
  if (!good) fmt::print(stderr, "haptic-bench device: too few readings a second, or errors on a good wire\n");
  return good ? 0 : 1;
}

}  // namespace

void addDevice(CLI::App& app, Run& chosen) {
  auto options = std::make_shared<Options>();
  CLI::App* device =
      app.add_subcommand("device",
                         "Each driver against its played device: delays of the protocol, processor time,\n"
                         "and what threads add (exit 1 if readings are few or wrong)");
  device->add_option("--seconds", options->seconds, "Length of each part of a round [s]")
      ->capture_default_str()
      ->check(CLI::Range(0.1, 600.0));
  device->callback([&chosen, options] { chosen = [options](const Common& common) { return run(common, *options); }; });
}

}  // namespace haptic_bench
