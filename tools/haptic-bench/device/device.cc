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

#include "rt/base/standard_streams.h"
#include "tools/haptic-bench/bench.h"
#include "tools/haptic-bench/device/played_device.h"
#include "tools/haptic-bench/device/played_sdk.h"
#include "tools/haptic-bench/device/servo_thread.h"
#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/option.h"

namespace haptic_bench {
namespace {

using namespace hapticd;  // NOLINT(google-build-using-namespace)

constexpr std::int64_t kTick_ns = 1'000'000, kGrain_ns = 62'500;
constexpr std::int64_t kHalfWave = 25;  ///< Ticks of force, then as many without.
constexpr double kNewtons = 1;
constexpr std::int64_t kSettle_ns = 400'000'000;  ///< Until the grip is where its hand wants it.

struct DeviceOptions {
  double seconds = 1;
  std::string sdk = playedSdk();
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
  DeviceSample sample;
  onServoThread(std::llround(seconds * 1000), clock, [&](std::int64_t tick, std::int64_t now_ns) {
    device.read(now_ns, sample);
    device.write(now_ns, waveAt(tick));
  });
  const Threads out{device.link().round_trip.summary(), device.link().age.summary()};
  device.close();
  return out;
}

/** What one device came to. */
class DeviceTable {
 public:
  DeviceTable(std::string name, std::vector<Series>& to) : name_(std::move(name)), to_(to) {}
  void add(const std::string& what, const std::string& unit, double value) {
    const std::string name = name_ + ": " + what;
    const auto same = std::find_if(to_.begin(), to_.end(), [&](const Series& series) { return series.name == name; });
    (same != to_.end() ? *same : to_.emplace_back(Series{name, unit, {}})).rounds.push_back(value);
  }
  void add(const std::string& what, std::uint64_t ns) { add(what, "us", static_cast<double>(ns) * 1e-3); }
  void addTimes(const std::string& by, const Histogram::Summary& round_trip, const Histogram::Summary& age) {
    if (round_trip.count != 0) {  // Not every device answers what it is told.
      add(by + ", round trip p50", round_trip.p50_ns);
      add(by + ", round trip p99", round_trip.p99_ns);
      add(by + ", round trip max", round_trip.max_ns);
    }
    add(by + ", age p50", age.p50_ns);
    add(by + ", age p99", age.p99_ns);
  }

 private:
  std::string name_;
  std::vector<Series>& to_;
};

/** False if readings are few or wrong. */
bool judge(const PlayedCase& played, const Common& common, double seconds, std::vector<Series>& all,
           std::string& note) {
  DeviceTable table(played.name, all);
  const Protocol protocol = measure(played, seconds);  // All but the processor time is the same each time.
  table.add("readings", "Hz", protocol.rate_hz);
  table.add("age of a reading, median", kVirtualTimeUnit, part(protocol.age_us, 0.5));
  table.add("age of a reading, worst", kVirtualTimeUnit, part(protocol.age_us, 1));
  if (!protocol.delay_us.empty()) {  // Else it has no motors.
    table.add("command to motors, median", kVirtualTimeUnit, part(protocol.delay_us, 0.5));
    table.add("command to motors, worst", kVirtualTimeUnit, part(protocol.delay_us, 1));
  }
  table.add("wrong or late on the wire", "", static_cast<double>(protocol.complaints));
  table.add("driver", "us a tick", protocol.driver_us);
  for (int round = 1; round < common.rounds; ++round) {
    table.add("driver", "us a tick", measure(played, seconds).driver_us);
  }
  for (int round = 0; played.thread && round < common.rounds; ++round) {
    const Threads threads = runThreads(played, seconds, note);
    table.addTimes("threads", threads.round_trip, threads.age);
  }
  return protocol.rate_hz >= played.least_hz && protocol.complaints == 0 && played.motors == !protocol.delay_us.empty();
}

/** False if nothing came back. */
bool judgeHelper(const std::string& scheme, const Common& common, const DeviceOptions& options,
                 std::vector<Series>& all) {
  DeviceTable table(scheme, all);
  bool good = true;
  for (int round = 0; round < common.rounds; ++round) {
    const HelperFigures figures = runHelper(scheme, options.sdk, options.seconds);
    table.add("hapticd-vendor", "us a tick", figures.helper_us);
    table.add("servo, read and write", "us a tick", figures.servo_us);
    table.addTimes("process", figures.round_trip, figures.age);
    good = good && figures.round_trip.count != 0 && figures.helper_us > 0;
  }
  return good;
}

/** Throws Failure if the library is none that can be played. */
void tryPlayedSdk(const std::string& sdk) {
  ManualClock clock;
  openOrThrow(playDhd(sdk, clock)->device());
}

int run(const Common& common, const DeviceOptions& options) {
  if (!options.sdk.empty()) tryPlayedSdk(options.sdk);  // Before the other devices' measurements, not after.
  std::vector<Series> all;
  std::string note;
  bool good = true;
  for (const PlayedCase& played : playedCases()) good = judge(played, common, options.seconds, all, note) && good;
  if (options.sdk.empty()) {
    hapticd::tellError(
        "haptic-bench: dhd and openhaptics left out: there is no played SDK beside this program (--sdk)\n");
  } else {
    const PlayedCase dhd{
        .name = "dhd", .make = [&](Clock& clock, bool) { return playDhd(options.sdk, clock); }, .thread = false};
    good = judge(dhd, common, options.seconds, all, note) && good;
    for (const char* scheme : {"dhd", "openhaptics"}) good = judgeHelper(scheme, common, options, all) && good;
  }
  if (!note.empty()) hapticd::tellError(fmt::format("haptic-bench: not real-time: {}\n", note));
  print(common, "device", all, fmt::format("parts of {} s", options.seconds));
  if (!good) hapticd::tellError("haptic-bench device: too few readings a second, or errors on a good wire\n");
  return good ? 0 : 1;
}

}  // namespace

void addDevice(CLI::App& app, Run& chosen) {
  auto options = std::make_shared<DeviceOptions>();
  CLI::App* device =
      app.add_subcommand("device",
                         "Each driver against its played device: delays of the protocol, processor time,\n"
                         "and what threads add (exit 1 if readings are few or wrong)");
  bounded(device, "--seconds", options->seconds, "Length of each part of a round [s]", 0.1, 600.0);
  device->add_option("--sdk", options->sdk, "Library that plays Force Dimension's and OpenHaptics' SDK");
  whenNamed(device, chosen, [options](const Common& common) { return run(common, *options); });
}

}  // namespace haptic_bench
