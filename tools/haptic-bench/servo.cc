/** @file
 * haptic-bench servo: a bare SCHED_FIFO loop that only sleeps (what cyclictest does) against the daemon's whole cycle
 * on a mesh, in turns: how much later does the daemon wake, and what share of a millisecond does it take.
 */
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <memory>
#include <numbers>
#include <thread>

#include "daemon/builder/build.h"
#include "daemon/device_group.h"
#include "drivers/registry.h"
#include "tools/haptic-bench/bench.h"
#include "tools/haptic-bench/sphere_upload.h"

namespace haptic_bench {
namespace {

using namespace hapticd;  // NOLINT(google-build-using-namespace)

constexpr int kPriority = 80;
constexpr double kRadius = 0.05;     // [m]
constexpr double kStiffness = 1000;  // [N/m]
constexpr double kNsPerUs = 1e3;
// Along the top of the sphere, half a millimetre deep, in contact for nine tenths of the way.
constexpr const char* kDevice =
    "sim://default?motion=stroke&from=-0.008,0,0.0495&to=0.008,0,0.0495&period=0.5&hand_stiffness=1000";

struct Options {
  double rate_hz = 1000;
  double seconds = 1.5;
  std::uint32_t triangles = 100'000;
};

/** One side's results, a value for each round. */
struct Side {
  Series p50, p99, p999, max;
  explicit Side(const std::string& name)
      : p50{name + " wake p50", "us", {}},
        p99{name + " wake p99", "us", {}},
        p999{name + " wake p99.9", "us", {}},
        max{name + " wake max", "us", {}} {}
  void add(const Histogram::Summary& s) {
    p50.rounds.push_back(static_cast<double>(s.p50_ns) / kNsPerUs);
    p99.rounds.push_back(static_cast<double>(s.p99_ns) / kNsPerUs);
    p999.rounds.push_back(static_cast<double>(s.p999_ns) / kNsPerUs);
    max.rounds.push_back(static_cast<double>(s.max_ns) / kNsPerUs);
  }
};

std::int64_t periodOf(const Options& options) { return static_cast<std::int64_t>(1e9 / options.rate_hz); }

/** Sleeps to absolute deadlines and does nothing else. */
Histogram::Summary bareRound(const Options& options, MonotonicClock& clock, std::string& note) {
  auto wake = std::make_unique<Histogram>();
  RtThread thread;
  auto started = thread.start("bare", 256 * 1024, [&] {
    if (auto rights = becomeRealtime(kPriority); !rights) note = toString(rights.error());
    const std::int64_t period_ns = periodOf(options);
    std::int64_t deadline_ns = (clock.now() / period_ns + 1) * period_ns;
    const std::int64_t end_ns = deadline_ns + static_cast<std::int64_t>(options.seconds * 1e9);
    while (deadline_ns < end_ns) {
      clock.sleepUntil(deadline_ns);
      const std::int64_t late_ns = clock.now() - deadline_ns;
      wake->record(late_ns);
      deadline_ns += (late_ns / period_ns + 1) * period_ns;
    }
  });
  if (!started) note = toString(started.error());
  thread.join();
  return wake->summary();
}

/** The daemon's real-time side with one simulated device and one mesh. */
class House {
 public:
  explicit House(MeshView& mesh) { meshes_.publish(0, &mesh); }

  bool start(const Options& options, MonotonicClock& clock, std::string& note) {
    auto device = makeDevice(kDevice);
    if (!device) return fail(device.error(), note);
    if (auto opened = (*device)->open(); !opened) return fail(opened.error(), note);
    GroupOptions group;
    group.servo_priority = kPriority;
    group.allow_no_rt = true;
    group.cycle.period_ns = periodOf(options);
    group.cycle.guard[0].limits = {.force = 8,
                                   .torque = 1,
                                   .force_slew = 1e5,
                                   .torque_slew = 1e3,
                                   .gripper_force = 1,
                                   .velocity = 5,
                                   .power = 50,
                                   .active_power = 20};
    group.cycle.guard[0].ramp_ns = 10'000'000;
    std::vector<std::unique_ptr<Device>> devices;
    devices.push_back(std::move(*device));
    auto made = DeviceGroup::start(group, std::move(devices), meshes_, clock);
    if (!made) return fail(made.error(), note);
    group_ = std::move(*made);
    if (!group_->realtime()) note = group_->schedulingNote();
    AddObject object{};
    object.object = makeObjectId(1, 1);
    object.flags = HD_OBJECT_ENABLED;
    object.shape.kind = static_cast<std::uint32_t>(ShapeKind::kMesh);
    object.material = {kStiffness, 1, 0.4, 0.3};
    object.q[0] = 1;
    return send(CommandKind::kAddObject, object) && send(CommandKind::kArm, DeviceRef{0});
  }

  /** Lets the start-up pass, then measures. */
  void run(const Options& options) {
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    ServoHistograms& h = group_->servo().histograms;
    for (Histogram* each : {&h.wake, &h.read, &h.render, &h.guard, &h.write, &h.cycle}) each->requestReset();
    std::this_thread::sleep_for(std::chrono::duration<double>(options.seconds));
  }
  [[nodiscard]] Servo& servo() { return group_->servo(); }

 private:
  static bool fail(const Error& error, std::string& note) {
    note = toString(error);
    return false;
  }
  template <class T>
  bool send(CommandKind kind, const T& payload) {
    Command command;
    command.kind = kind;
    command.as<T>() = payload;
    return group_->send(command);
  }

  MeshTable meshes_;
  std::unique_ptr<DeviceGroup> group_;
};

int run(const Common& common, const Options& options) {
  const std::vector<std::byte> upload = sphereUpload(options.triangles, kRadius);
  BuildMonitor monitor;
  auto built = buildSnapshot(upload, monitor);
  if (!built) {
    fmt::print(stderr, "haptic-bench: {}\n", toString(built.error()));
    return 1;
  }
  auto mapped = built->memfd.map(Memfd::Access::kRead);
  auto mesh = mapped ? validateSnapshot(mapped->bytes()) : Result<MeshView>(mapped.error());
  if (!mesh) {
    fmt::print(stderr, "haptic-bench: {}\n", toString(mesh.error()));
    return 1;
  }

  MonotonicClock clock;
  std::string note;
  Side bare("bare loop"), daemon("daemon");
  Series cycle50{"cycle p50", "us", {}}, cycle99{"cycle p99", "us", {}}, share{"cycle p50 / 1 ms", "%", {}};
  Series render50{"render p50", "us", {}}, missed{"missed periods", "", {}},
      touched{"in contact in this round", "", {}};
  for (int round = 0; round < common.rounds; ++round) {
    bare.add(bareRound(options, clock, note));
    House house(*mesh);
    if (!house.start(options, clock, note)) {
      fmt::print(stderr, "haptic-bench: {}\n", note);
      return 1;
    }
    house.run(options);
    Servo& servo = house.servo();
    daemon.add(servo.histograms.wake.summary());
    const Histogram::Summary cycle = servo.histograms.cycle.summary();
    cycle50.rounds.push_back(static_cast<double>(cycle.p50_ns) / kNsPerUs);
    cycle99.rounds.push_back(static_cast<double>(cycle.p99_ns) / kNsPerUs);
    share.rounds.push_back(static_cast<double>(cycle.p50_ns) / 1e4);
    render50.rounds.push_back(static_cast<double>(servo.histograms.render.summary().p50_ns) / kNsPerUs);
    missed.rounds.push_back(static_cast<double>(servo.counters.missed.load()));
    touched.rounds.push_back(servo.counters.contacts.load() > 0 ? 1.0 : 0.0);
  }
  if (!note.empty()) fmt::print(stderr, "haptic-bench: not real-time: {}\n", note);
  print(
      common, "servo",
      {bare.p50, bare.p99, bare.p999, bare.max, daemon.p50, daemon.p99, daemon.p999, daemon.max,
       ratio("wake p99.9, daemon / bare", daemon.p999, bare.p999), render50, cycle50, cycle99, share, missed, touched});
  if (std::find(touched.rounds.begin(), touched.rounds.end(), 0.0) == touched.rounds.end()) return 0;
  fmt::print(stderr, "haptic-bench servo: a round without contact; the cost of its cycle is worth nothing\n");
  return 1;
}

}  // namespace

void addServo(CLI::App& app, Run& chosen) {
  auto options = std::make_shared<Options>();
  CLI::App* servo = app.add_subcommand(
      "servo",
      "Wake-up of a bare real-time loop against the daemon's cycle on a mesh, and what the cycle costs\n"
      "(exit 1 if a round touches nothing)");
  servo->add_option("--rate", options->rate_hz, "Servo rate [Hz]")->capture_default_str()->check(CLI::Range(100, 4000));
  servo->add_option("--seconds", options->seconds, "Length of each side of a round [s]")
      ->capture_default_str()
      ->check(CLI::Range(0.1, 600.0));
  servo->add_option("--triangles", options->triangles, "Of the sphere that is stroked")
      ->capture_default_str()
      ->check(CLI::Range(100, 8'000'000));
  servo->callback([&chosen, options] { chosen = [options](const Common& common) { return run(common, *options); }; });
}

}  // namespace haptic_bench
