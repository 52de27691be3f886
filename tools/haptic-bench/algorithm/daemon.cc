// The running daemon, judged from outside as any client may: it builds the mesh and renders it, with ingest, guard and
// device. The device stands still (a simulated one with more dry friction than force) and the mesh is moved past it: at
// the end of a step the hand stands at the trajectory's point relative to the mesh. A step takes as long as the daemon
// needs to take the pose and publish the next sample: a few of its periods.
#include <chrono>
#include <optional>
#include <span>
#include <string>

#include "tools/haptic-bench/algorithm/algorithms.h"
#include "tools/haptic-bench/algorithm/native.h"
#include "tools/haptic-bench/algorithm/opened_device.h"
#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/interrupt.h"
#include "tools/haptic-bench/spec.h"

namespace haptic_bench {
namespace {

using std::chrono::steady_clock;

constexpr const char* kHeld = "sim://default?motion=hold&coulomb=20&max_force=200&resolution=0&serial=haptic-bench";

/** Ctrl-C ends the run in order; after a kill the daemon closes what was opened for this run alone. */
void checkDaemonInterrupted() { checkInterrupts("daemon", "its device has been closed"); }

class Daemon {
 public:
  explicit Daemon(const haptic_algorithm_problem& problem) : client_(connect(problem)) {
    if (device_.empty()) device_ = opened_.emplace(client_, kHeld).uri();
    auto mesh =
        must(client_.scene().upload(std::span(&problem.vertices[0][0], std::size_t{problem.vertex_count} * 3),
                                    std::span(&problem.triangles[0][0], std::size_t{problem.triangle_count} * 3)));
    session_.emplace(must(client_.openSession(device_, "haptic-bench")));
    mesh_ = mesh->id;
    haptic_object object = HAPTIC_OBJECT_INIT;
    object.name = "haptic-bench";
    object.pose.p[0] = kAway;
    object.shape.kind = HAPTIC_SHAPE_MESH;
    object.shape.mesh = mesh->id;
    object.material = {problem.stiffness, problem.damping, problem.friction_static, problem.friction_dynamic};
    object_.emplace(must(client_.scene().create(object)));
    must(session_->arm());
    checkDaemonInterrupted();
  }

  ~Daemon() {
    object_.reset();
    (void)client_.scene().dropMesh(mesh_);
  }
  Daemon(const Daemon&) = delete;
  Daemon& operator=(const Daemon&) = delete;

  void start(const Vec3& hip) {
    // A jump out of reach and one to the start: both teleports, which sweep nothing. The ramp runs out in between,
    // where nothing is felt: it would wait for a force to become small.
    haptic_algorithm_contact contact{};
    moveTo(Vec3(-kAway, 0, 0), contact);
    awaitFullForce();
    moveTo(hip, contact);
  }

  void step(const Vec3& hip, const Vec3&, double, haptic_algorithm_contact& contact) { moveTo(hip, contact); }

  [[nodiscard]] std::size_t bytes() const { return 0; }

 private:
  static constexpr double kAway = 5;  // [m]
  /** With its ramp: how long that is no daemon tells; the configuration's longest is 60 s, of ticks that ran. */
  static constexpr std::chrono::seconds kRampPatience = std::chrono::seconds(120);

  haptic::Client connect(const haptic_algorithm_problem& problem) {
    Spec options(std::string("daemon:") + problem.options);
    haptic::ConnectOptions how;
    how.socket = options.word("socket", "");
    how.name = "haptic-bench";
    device_ = options.word("device", "");
    options.finish();
    refuseBall(problem);
    if (problem.damping > 0) {
      throw Failure("--damping", "the daemon is moved at its own pace, not as fast as the trajectory goes",
                    "leave it out");
    }
    return must(haptic::Client::connect(how));
  }

  [[nodiscard]] haptic_sample sample() const { return latestSample(*session_, "daemon"); }

  void awaitFullForce() {
    const steady_clock::time_point end = steady_clock::now() + kRampPatience;
    for (bool was_armed = was_armed_;;) {
      checkDaemonInterrupted();
      const std::uint32_t flags = sample().flags;
      const bool armed = (flags & HAPTIC_SAMPLE_ARMED) != 0;
      was_armed_ = was_armed_ || armed;
      if (armed && (flags & HAPTIC_SAMPLE_RAMPING) == 0) return;
      if (was_armed && !armed) throw Failure("daemon", "its device has been disarmed", "hapticctl status");
      if (steady_clock::now() > end)
        throw Failure("daemon", "its full force has not come for 120 s, twice the longest ramp", "hapticctl status");
      was_armed = armed;
      pauseBriefly();
    }
  }

  void moveTo(const Vec3& hip, haptic_algorithm_contact& contact) {
    checkDaemonInterrupted();
    const haptic_sample before = sample();
    haptic_object_pose pose{};
    pose.object = object_->id();
    pose.q[0] = 1;
    for (int i = 0; i < 3; ++i) pose.p[i] = before.p[i] - hip[i];
    const std::uint64_t seq = must(session_->push(pose));
    const steady_clock::time_point end = steady_clock::now() + kPatience;
    haptic_acks acks{};
    haptic_sample after{};
    while (acks.applied_seq < seq || after.tick < acks.applied_tick) {
      if (steady_clock::now() > end) throw Failure("daemon", "it has not taken a pose for 2 s", "hapticctl status");
      pauseBriefly();
      if (const haptic::Result<haptic_acks> a = session_->acks()) acks = *a;
      after = sample();
    }
    const Vec3 at(pose.p[0], pose.p[1], pose.p[2]);
    answer(contact, hapticd::vec3(after.force), hapticd::vec3(after.proxy) - at,
           (after.flags & HAPTIC_SAMPLE_CONTACT) != 0);
  }

  const Interrupts interrupts_;  // First: until the device is closed.
  std::string device_;
  bool was_armed_ = false;  ///< Since the session began.
  haptic::Client client_;
  std::optional<OpenedDevice> opened_;  // Before the session, which has to go first.
  std::uint64_t mesh_ = 0;
  std::optional<haptic::Session> session_;
  std::optional<haptic::Object> object_;
};

}  // namespace

const haptic_algorithm kDaemon = [] {
  haptic_algorithm table =
      nativeAlgorithm<Daemon>("daemon", "the running daemon, in real time; daemon:socket=PATH,device=URI");
  table.memory_bytes = nullptr;
  return table;
}();

}  // namespace haptic_bench
