#include "tools/haptic-bench/load/servo_sides.h"

#include <pthread.h>
#include <sched.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "drivers/registry.h"
#include "rt/cycle/realtime.h"
#include "tools/haptic-bench/desktop_guard.h"
#include "tools/haptic-bench/failure.h"

namespace haptic_bench {
namespace {

using namespace hapticd;  // NOLINT(google-build-using-namespace)

constexpr int kPriority = 80;
constexpr double kSphereStiffness = 1000;           // [N/m]
constexpr std::size_t kStackBytes = 512 * 1024;     // As DeviceGroup's.
constexpr std::size_t kPrefaultBytes = 256 * 1024;  // As DeviceGroup's.
constexpr std::chrono::milliseconds kArming{200};
// Along the top of the sphere, half a millimetre deep, in contact for nine tenths of the way.
constexpr const char* kDevice =
    "sim://default?motion=stroke&from=-0.008,0,0.0495&to=0.008,0,0.0495&period=0.5&hand_stiffness=1000";

std::int64_t periodOf(const Slice& slice) { return static_cast<std::int64_t>(1e9 / slice.rate_hz); }

std::size_t roomOf(const Slice& slice) { return static_cast<std::size_t>(slice.rate_hz * slice.seconds * 2) + 1000; }

}  // namespace

Wakes runBare(const Slice& slice, Clock& clock, Note& note) {
  Wakes wakes;
  wakes.reserve(roomOf(slice));
  RtThread thread;
  orFail(thread.start("bare", kStackBytes, [&] {
    prefaultStack(kPrefaultBytes);
    disableDenormals();
    cpu_set_t set;
    CPU_ZERO(&set);
    CPU_SET(slice.cpu, &set);
    pthread_setaffinity_np(pthread_self(), sizeof set, &set);
    if (auto rights = becomeRealtime(kPriority); !rights) note = toString(rights.error());
    const std::int64_t period_ns = periodOf(slice);
    std::int64_t deadline_ns = (clock.now() / period_ns + 1) * period_ns;
    const std::int64_t from_ns = deadline_ns + std::chrono::nanoseconds(kArming).count();
    const std::int64_t end_ns = from_ns + static_cast<std::int64_t>(slice.seconds * 1e9);
    while (deadline_ns < end_ns) {
      clock.sleepUntil(deadline_ns);
      const std::int64_t late_ns = clock.now() - deadline_ns;
      if (deadline_ns >= from_ns) wakes.push_back(late_ns);
      deadline_ns += (late_ns / period_ns + 1) * period_ns;
    }
  }));
  thread.join();
  return wakes;
}

/**
 * Notes when the servo woke: it reads its device first, with the deadline as the time. Late by more than a period it
 * has moved the deadline on; what counts is the one it slept to.
 */
class House::Watched final : public Device {
 public:
  Watched(std::unique_ptr<Device> device, Clock& clock, std::int64_t period_ns, std::size_t room)
      : device_(std::move(device)), clock_(clock), period_ns_(period_ns), wakes_(room) {}

  [[nodiscard]] const DeviceInfo& info() const noexcept override { return device_->info(); }
  [[nodiscard]] Result<void> open() override { return device_->open(); }
  void close() noexcept override { device_->close(); }
  void read(std::int64_t now_ns, DeviceSample& sample) HD_RT override {
    const std::size_t at = count_.load(std::memory_order_relaxed);
    if (on_.load(std::memory_order_relaxed) && at < wakes_.size()) {
      wakes_[at] = clock_.now() - (before_ns_ + period_ns_);
      count_.store(at + 1, std::memory_order_release);
    }
    before_ns_ = now_ns;
    device_->read(now_ns, sample);
  }
  void write(std::int64_t now_ns, const DeviceCommand& command) HD_RT override { device_->write(now_ns, command); }
  void safe() noexcept override { device_->safe(); }

  void watch(bool on) { on_.store(on, std::memory_order_relaxed); }
  [[nodiscard]] Wakes taken() const {
    const std::size_t count = count_.load(std::memory_order_acquire);
    return {wakes_.begin(), wakes_.begin() + static_cast<std::ptrdiff_t>(count)};
  }

 private:
  std::unique_ptr<Device> device_;
  Clock& clock_;
  std::int64_t period_ns_;
  std::int64_t before_ns_ = 0;  ///< The last deadline.
  Wakes wakes_;
  std::atomic<std::size_t> count_{0};
  std::atomic<bool> on_{false};
};

House::House(const Slice& slice, MeshView& mesh, Clock& clock, Note& note) : slice_(slice) {
  meshes_.publish(0, &mesh);
  auto watched = std::make_unique<Watched>(orFail(makeDevice(kDevice)), clock, periodOf(slice), roomOf(slice));
  watched_ = watched.get();
  orFail(watched->open());
  GroupOptions group;
  group.servo_priority = kPriority;
  group.allow_no_rt = true;
  group.cpus = {slice.cpu};
  group.cycle.period_ns = periodOf(slice);
  group.cycle.guard[0] = desktopGuard();
  std::vector<std::unique_ptr<Device>> devices;
  devices.push_back(std::move(watched));
  group_ = orFail(DeviceGroup::start(group, std::move(devices), meshes_, clock));
  if (!group_->realtime()) note = group_->schedulingNote();
  const auto send = [&](CommandKind kind, const auto& payload) {
    if (!group_->send(makeCommand(kind, payload))) throw Failure("servo", "takes no orders", "");
  };
  AddObject object{};
  object.object = makeObjectId(1, 1);
  object.flags = HD_OBJECT_ENABLED;
  object.shape.kind = static_cast<std::uint32_t>(ShapeKind::kMesh);
  object.material.stiffness = kSphereStiffness;
  object.material.damping = 1;
  object.material.friction_static = 0.4;
  object.material.friction_dynamic = 0.3;
  object.q[0] = 1;
  send(CommandKind::kAddObject, object);
  send(CommandKind::kArm, DeviceRef{0});
  std::this_thread::sleep_for(kArming);
}

House::~House() = default;

Wakes House::run() {
  ServoHistograms& h = group_->servo().histograms;
  for (Histogram* each : {&h.wake, &h.read, &h.render, &h.guard, &h.write, &h.cycle}) each->requestReset();
  watched_->watch(true);
  std::this_thread::sleep_for(std::chrono::duration<double>(slice_.seconds));
  watched_->watch(false);
  return watched_->taken();
}

Servo& House::servo() { return group_->servo(); }

}  // namespace haptic_bench
