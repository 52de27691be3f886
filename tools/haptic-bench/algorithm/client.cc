// Whoever renders as a client of the running daemon, judged by what the hand gets: the trajectory is the way of a
// simulated hand, and the force that the device is sent is the answer. The grip is stiffer than any surface and asks
// for as much more as the force has bent it, until the hand is where the trajectory has it.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <optional>
#include <string>
#include <thread>

#include "rt/base/standard_streams.h"
#include "tools/haptic-bench/algorithm/algorithms.h"
#include "tools/haptic-bench/algorithm/native.h"
#include "tools/haptic-bench/algorithm/opened_device.h"
#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/interrupt.h"
#include "tools/haptic-bench/spec.h"

namespace haptic_bench {
namespace {

using std::chrono::steady_clock;

/** A light hand with the stiffest grip there is, critically damped: it is where it wants to be 4 ms later. */
constexpr double kGrip = 10000;  // [N/m]
constexpr const char* kLedHand =
    "sim://default?motion=live&mass=0.005&hand_mass=0&hand_stiffness=10000&hand_damping=14&viscous=0&coulomb=0&delay=0&"
    "resolution=0&max_force=200&lower=-2,-2,-2&upper=2,2,2&serial=haptic-bench-client";
constexpr const char* kName = "haptic-bench-client";  // Its serial number.
constexpr double kThere = 1e-6;                       // [m]: a millinewton on a surface of 1000 N/m.
constexpr std::chrono::milliseconds kHandSettles{
    30};  // For a step; what is not there by then pushes and pulls by itself.

void checkClientInterrupted() { checkInterrupts("client", "its device has been closed"); }

class ClientOfDaemon {
 public:
  explicit ClientOfDaemon(const haptic_algorithm_problem& problem) {
    Spec options(std::string("client:") + problem.options);
    how_.socket = options.word("socket", "");
    how_.name = "haptic-bench";
    wait_s_ = options.number("wait", 30, 0, 3600);
    options.finish();
    refuseBall(problem);
    (void)must(haptic::Client::connect(how_));
  }
  ~ClientOfDaemon() {
    if (late_ == 0) return;
    hapticd::tellError(fmt::format(
        "client: {} of {} steps took longer than the trajectory's (a lower rate is felt as it goes)\n", late_, steps_));
  }
  ClientOfDaemon(const ClientOfDaemon&) = delete;
  ClientOfDaemon& operator=(const ClientOfDaemon&) = delete;

  void start(const Vec3& hip) {
    interrupts_.emplace();
    client_.emplace(must(haptic::Client::connect(how_)));
    device_.emplace(*client_, kLedHand, true);
    session_.emplace(must(client_->openSession(device_->uri(), "haptic-bench")));
    of_group_ = sample().device;
    there_ = hapticd::vec3(sample().p);
    constexpr double kWalking = 0.3;  // [m/s]
    goTo(hip, (hip - there_).norm() / kWalking);
    (void)settleAt(hip);
    hapticd::tellError(
        fmt::format("haptic-bench: client: waits {} s for a program that arms the device {}\n", wait_s_, kName));
    const steady_clock::time_point end = steady_clock::now() + std::chrono::duration_cast<steady_clock::duration>(
                                                                   std::chrono::duration<double>(wait_s_));
    while (!ready(sample())) {
      checkClientInterrupted();
      if (steady_clock::now() > end) {
        throw Failure("client", fmt::format("nobody has armed the device {} within {} s", kName, wait_s_),
                      "a program that opens a session on it and arms it; client:wait=60");
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    next_ = steady_clock::now();
  }

  void step(const Vec3& hip, const Vec3&, double dt_s, haptic_algorithm_contact& contact) {
    ++steps_;
    goTo(hip, dt_s);
    const haptic_sample s = settleAt(hip);
    if (!ready(s)) throw Failure("client", "its device is not armed any more", "hapticctl events says why");
    answer(contact, hapticd::vec3(s.force), hapticd::vec3(s.proxy),
           s.force[0] != 0 || s.force[1] != 0 || s.force[2] != 0);
    next_ += std::chrono::duration_cast<steady_clock::duration>(std::chrono::duration<double>(dt_s));
    if (const steady_clock::time_point now = steady_clock::now(); now > next_) {
      ++late_;
      next_ = now;
    }
    std::this_thread::sleep_until(next_);
  }

  [[nodiscard]] std::size_t bytes() const { return 0; }

 private:
  static bool ready(const haptic_sample& s) {
    return (s.flags & (HAPTIC_SAMPLE_ARMED | HAPTIC_SAMPLE_RAMPING | HAPTIC_SAMPLE_FAULT)) == HAPTIC_SAMPLE_ARMED;
  }

  [[nodiscard]] haptic_sample sample() const { return latestSample(*session_, "client"); }

  void want(const Vec3& p) {
    haptic_intent intent{};
    intent.device = of_group_;
    hapticd::store(p, intent.p);
    intent.q[0] = 1;
    const haptic::Result<std::uint64_t> pushed = session_->push(intent, {.latest = true});
    if (!pushed && pushed.code() != HAPTIC_WOULD_BLOCK)
      throw Failure(pushed.error().message());  // The next one says it.
  }

  /** Straight on from where it was, with `kArriving` left of the time. */
  void goTo(const Vec3& hip, double dt_s) {
    constexpr double kArriving = 8e-3, kStep = 1e-3;  // [s]
    const int steps = std::max(1, static_cast<int>((dt_s - kArriving) / kStep));
    const Vec3 from = there_;
    const steady_clock::time_point begin = steady_clock::now();
    for (int i = 1; i <= steps; ++i) {
      checkClientInterrupted();
      want(from + (hip - from) * (static_cast<double>(i) / steps) + bent_);
      if (i < steps) std::this_thread::sleep_until(begin + i * std::chrono::milliseconds(1));
    }
    there_ = hip;
  }

  /** The hand's last sample, taken there or after kHandSettles. */
  haptic_sample settleAt(const Vec3& hip) {
    const steady_clock::time_point end = steady_clock::now() + kHandSettles;
    haptic_sample s = sample();
    for (int still = 0; steady_clock::now() < end;) {
      const std::uint64_t tick = s.tick;
      while ((s = sample()).tick == tick && steady_clock::now() < end) pauseBriefly();
      still = (hip - hapticd::vec3(s.p)).norm() < kThere ? still + 1 : 0;
      if (still == 2) break;
      bent_ = -hapticd::vec3(s.force) / kGrip;
      want(hip + bent_);
    }
    return s;
  }

  haptic::ConnectOptions how_;
  double wait_s_ = 0;
  std::optional<Interrupts> interrupts_;  // First of these: until the device is closed.
  std::optional<haptic::Client> client_;
  std::optional<OpenedDevice> device_;  // Before the session, which has to go first.
  std::optional<haptic::Session> session_;
  std::uint32_t of_group_ = 0;
  Vec3 there_ = Vec3::Zero();  ///< Where the trajectory has had it last [m].
  Vec3 bent_ = Vec3::Zero();   ///< How far beyond the trajectory the grip must reach against the force [m].
  steady_clock::time_point next_;
  std::size_t steps_ = 0, late_ = 0;
};

}  // namespace

const haptic_algorithm kClient = [] {
  haptic_algorithm table = nativeAlgorithm<ClientOfDaemon>(
      "client", "a program of yours as a client of the running daemon, in real time; client:socket=PATH,wait=30");
  table.memory_bytes = nullptr;
  return table;
}();

}  // namespace haptic_bench
