#include "tools/haptic-bench/load/live.h"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <fstream>
#include <thread>

#include "tools/haptic-bench/beside_program.h"
#include "tools/haptic-bench/interrupt.h"
#include "tools/haptic-bench/load/built_surface.h"
#include "tools/haptic-bench/load/connect.h"
#include "tools/haptic-bench/load/judge.h"
#include "tools/haptic-bench/metric/quantile.h"

namespace haptic_bench {
namespace {

using SteadyClock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr double kLiveStiffness = 1000;  ///< [N/m]
// Over the top of the sphere and back at 0.1 m/s, pressing with about 1 N, and off it at both ends: an object that
// appears about a hand is not felt until the hand has left it.
constexpr const char* kHand =
    "sim://default?motion=stroke&from=-0.018,0.002,0.0478&to=0.018,0.002,0.0478&period=0.72&hand_stiffness=1000";
constexpr const char* kSettings = "[guard]\narm_ramp_ms = 100\nsmall_force_n = 5\n[quotas]\nsessions = 15\n";

/** What the client's process tells this one. */
struct Report {
  std::atomic<std::uint64_t> updates{0};
  std::atomic<std::uint64_t> first_us{0}, last_us{0}, longest_us{0};
};

std::uint64_t now_us() {
  return static_cast<std::uint64_t>(
      std::chrono::duration_cast<std::chrono::microseconds>(SteadyClock::now().time_since_epoch()).count());
}

void note(Report& report) {
  const std::uint64_t now = now_us();
  if (report.updates.fetch_add(1) == 0) {
    report.first_us = now;
  } else {
    report.longest_us = std::max(report.longest_us.load(), now - report.last_us.load());
  }
  report.last_us = now;
}

/** A program that keeps the mesh and sends what is near the hand, until it is ended. */
void runClient(const std::string& socket, const Model& model, Source source, double rate_hz, Report& report) {
  const haptic::SurfaceMesh mesh = clientMesh(model);
  haptic::Client client = connectTo(socket);
  haptic::Session session = check(client.openSession());
  const ClientTiming timing{1 / rate_hz, 0.002, kLiveStiffness};
  const auto period = std::chrono::duration_cast<SteadyClock::duration>(std::chrono::duration<double>(timing.period_s));
  for (auto next = SteadyClock::now();;
       std::this_thread::sleep_until(next = std::max(next + period, SteadyClock::now() - period))) {
    const auto sample = session.latest();
    if (!sample) continue;
    note(report);
    const Vec3 p(sample->p[0], sample->p[1], sample->p[2]);
    const Vec3 v(sample->v[0], sample->v[1], sample->v[2]);
    if (source == Source::kForce) {
      (void)session.push(fitForce(mesh, p, timing), {.latest = true});
    } else {
      (void)session.push(fitModel(source, mesh, p, v, timing), {.latest = true});
    }
  }
}

std::string programBeside() {
  const std::string beside = besideProgram({"../../daemon/hapticd", "../sbin/hapticd"});
  return beside.empty() ? "hapticd" : beside;
}

std::vector<std::string> command(const std::string& program, const std::string& folder) {
  std::ofstream(folder + "/hapticd.toml") << kSettings;
  return {program.empty() ? programBeside() : program,
          "--allow-no-rt",
          "--socket",
          folder + "/control.sock",
          "--admin-socket",
          folder + "/admin.sock",
          "--config",
          folder + "/hapticd.toml",
          "--device",
          kHand};
}

/** The object that the native scene renders. */
haptic::Object addMesh(haptic::Client& client, const Model& model) {
  auto mesh = check(client.scene().upload({model.vertices.data()->data(), 3 * model.vertices.size()},
                                          {model.triangles.data()->data(), 3 * model.triangles.size()}));
  haptic_object object = HAPTIC_OBJECT_INIT;
  object.name = "stroked";
  object.shape.kind = HAPTIC_SHAPE_MESH;
  object.shape.mesh = mesh->id;
  object.material = {kLiveStiffness, 0, 0, 0};
  return check(client.scene().create(object));
}

constexpr const char *kWho = "load", *kShown = "what was measured until then is shown";

/** Every sample of the servo for so long. */
std::vector<haptic_sample> watch(haptic::Session& session, double seconds) {
  std::vector<haptic_sample> all;
  std::vector<haptic_sample> room(1024);
  std::uint64_t lost = 0;
  (void)session.drain(room, lost);
  const auto end = SteadyClock::now() + std::chrono::duration<double>(seconds);
  while (SteadyClock::now() < end) {
    checkInterrupts(kWho, kShown);
    std::this_thread::sleep_for(milliseconds(50));
    auto read = session.drain(room, lost);
    if (read) all.insert(all.end(), read->begin(), read->end());
  }
  return all;
}

void judgePeriods(const std::vector<haptic_sample>& samples, LiveResult& result) {
  std::vector<double> periods;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    const auto ticks = static_cast<double>(samples[i].tick - samples[i - 1].tick);
    if (ticks > 1.5 && samples[i].missed == samples[i - 1].missed) continue;  // Lost by this reader, not by the servo.
    periods.push_back(static_cast<double>(samples[i].t_ns - samples[i - 1].t_ns) * 1e-3);
  }
  if (periods.empty()) throw Failure("load", "the servo gave no sample", "see the daemon's log");
  for (const double period : periods) result.period_mean_us += period / static_cast<double>(periods.size());
  std::sort(periods.begin(), periods.end());
  result.period_p99_us = nearestRank(periods, 0.99);
  result.period_max_us = periods.back();
  result.missed = samples.back().missed - samples.front().missed;
}

}  // namespace

LiveDaemon::LiveDaemon(const std::string& program)
    : socket_(folder_.path() + "/control.sock"),
      process_(command(program, folder_.path()), folder_.path() + "/hapticd.log") {
  for (int i = 0; i < 500; ++i) {
    checkInterrupts(kWho, kShown);
    if (haptic::Client::connect({.socket = socket_, .name = "haptic-bench"})) return;
    if (!process_.running()) break;
    std::this_thread::sleep_for(milliseconds(20));
  }
  std::string log;
  std::getline(std::ifstream(folder_.path() + "/hapticd.log"), log, '\0');
  while (!log.empty() && log.back() == '\n') log.pop_back();
  throw Failure("hapticd", "did not start: " + log, "name it with --daemon");
}

LiveResult runLive(const LiveDaemon& daemon, const Model& model, Source source, double rate_hz, Level level,
                   double seconds) {
  void* shared = mmap(nullptr, sizeof(Report), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (shared == MAP_FAILED) throw Failure("load", "no shared memory", "");
  auto* report = new (shared) Report;

  // All processes first: this one gets its library's thread with the connection.
  std::vector<Child> children = startLoad(level, daemon.socket(), daemon.folder());
  if (source != Source::kNative) {
    children.emplace_back([&] { runClient(daemon.socket(), model, source, rate_hz, *report); });
  }
  LiveResult result;
  std::vector<haptic_sample> samples;
  {
    haptic::Client client = connectTo(daemon.socket());
    haptic::Session session = check(client.openSession());
    std::vector<haptic::Object> object;
    if (source == Source::kNative) object.push_back(addMesh(client, model));
    check(session.arm());
    std::this_thread::sleep_for(milliseconds(400));  // The ramp, and a client's start.
    samples = watch(session, seconds);
    for (Child& child : children) {
      if (child.running()) continue;
      throw Failure(std::string("load, ") + nameOf(level), "a program of it ended before the measurement did",
                    "if it said why, that stands above");
    }
    check(session.disarm());
  }
  children.clear();
  std::this_thread::sleep_for(milliseconds(100));  // The daemon lets go of what they had.
  judgePeriods(samples, result);
  const ForceError off = judgeForces(samples, BuiltSurface(model), source, kLiveStiffness);
  result.force_rms = off.rms;
  result.mean_force = off.mean;
  if (const auto gaps = static_cast<double>(report->updates.load()) - 1; gaps > 0) {
    result.client_period_mean_us = static_cast<double>(report->last_us - report->first_us) / gaps;
    result.client_period_max_us = static_cast<double>(report->longest_us);
  }
  munmap(shared, sizeof(Report));
  return result;
}

}  // namespace haptic_bench
