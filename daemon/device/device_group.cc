#include "daemon/device/device_group.h"

#include <pthread.h>
#include <sched.h>

#include <algorithm>
#include <future>
#include <utility>

#include "daemon/device/patience.h"

namespace hapticd {
namespace {

constexpr std::size_t kStackBytes = 512 * 1024;
constexpr std::size_t kPrefaultBytes = 256 * 1024;

/** Keeps the calling thread on these processors; anywhere if there are none. */
Result<void> pinTo(const std::vector<std::uint32_t>& cpus) {
  if (cpus.empty()) return {};
  cpu_set_t set;
  CPU_ZERO(&set);
  std::string list;
  for (const std::uint32_t cpu : cpus) {
    if (cpu < CPU_SETSIZE) CPU_SET(cpu, &set);
    list += (list.empty() ? "" : ", ") + std::to_string(cpu);
  }
  if (pthread_setaffinity_np(pthread_self(), sizeof set, &set) == 0) return {};
  return Error{ErrorCode::kSystem, "cpus", "none of processors " + list + " can be used", "see /proc/cpuinfo"};
}

}  // namespace

DeviceGroup::DeviceGroup(const GroupOptions& options, std::vector<std::unique_ptr<Device>> devices,
                         const MeshTable& meshes, Clock& clock)
    : options_(options),
      devices_(std::move(devices)),
      clock_(clock),
      ingest_(std::make_unique<Ingest>(options.ingest)),
      collider_(std::make_unique<Collider>(options.volumes)) {
  options_.cycle.device_count = static_cast<std::uint32_t>(devices_.size());
  std::array<Device*, kMaxDevices> raw{};
  for (std::size_t i = 0; i < devices_.size(); ++i) {
    raw[i] = devices_[i].get();
    last_resort_.emplace_back(*raw[i]);
  }
  servo_ = std::make_unique<Servo>(options_.cycle, raw, meshes, clock_);
  servo_->ingest = ingest_.get();
  if (options_.lines != nullptr) {
    servo_->lines = options_.lines;
    servo_->sign = options_.lines->take();
  }
  servo_->collider = collider_.get();
}

Result<std::unique_ptr<DeviceGroup>> DeviceGroup::start(const GroupOptions& options,
                                                        std::vector<std::unique_ptr<Device>> devices,
                                                        const MeshTable& meshes, Clock& clock) {
  if (devices.empty() || devices.size() > kMaxDevices) {
    return Error{ErrorCode::kInvalidArgument, "device group", std::to_string(devices.size()) + " devices",
                 "a group holds 1 to " + std::to_string(kMaxDevices) + " devices"};
  }
  std::unique_ptr<DeviceGroup> group(new DeviceGroup(options, std::move(devices), meshes, clock));
  if (!options.threads) {
    group->servo_->begin();
    return group;
  }
  if (auto started = group->startThreads(); !started) return started.error();
  return group;
}

Result<void> DeviceGroup::startThreads() {
  // Each thread says how it was scheduled before it begins; the servo starts last, when its inlets are served.
  const auto run = [this](RtThread& thread, const char* name, int priority, auto loop) -> Result<void> {
    std::promise<Result<void>> scheduled;
    auto answer = scheduled.get_future();
    auto started = thread.start(name, kStackBytes, [this, priority, loop, &scheduled] {
      prefaultStack(kPrefaultBytes);
      disableDenormals();
      Result<void> rights = pinTo(options_.cpus);
      if (rights) rights = becomeRealtime(priority);
      const bool go = rights.ok() || (options_.allow_no_rt && rights.error().code == ErrorCode::kNoRealtime);
      scheduled.set_value(std::move(rights));
      if (go) loop();
    });
    if (!started) return started;
    Result<void> rights = answer.get();
    if (rights || rights.error().code != ErrorCode::kNoRealtime) return rights;
    note_ = toString(rights.error());
    return options_.allow_no_rt ? Result<void>() : rights;
  };

  auto ingest = run(ingest_thread_, "ingest", options_.ingest_priority, [this] {
    // The servo wakes at whole periods, ingest half a period later, so that neither wakes while the other works.
    const std::int64_t period_ns = options_.cycle.period_ns;
    while (!stop_others_.load(std::memory_order_relaxed)) {
      ingest_->step(clock_.now(), servo_->counters.tick.load(std::memory_order_relaxed));
      clock_.sleepUntil((clock_.now() + period_ns / 2) / period_ns * period_ns + period_ns / 2);
    }
  });
  if (!ingest) return ingest;
  // Below servo and ingest, which it must never delay, whatever priorities the configuration gives them.
  const int below = std::min(options_.servo_priority, options_.ingest_priority) - 1;
  const int collide_priority = std::clamp(below, 1, options_.collide_priority);
  auto collide = run(collide_thread_, "collide", collide_priority, [this] {
    // However long an answer takes, the thread then sleeps: at 60 % of the processor it is never throttled.
    while (!stop_others_.load(std::memory_order_relaxed)) {
      const std::int64_t began_ns = clock_.now();
      collider_->step(&clock_);
      const std::int64_t took_ns = clock_.now() - began_ns;
      clock_.sleepUntil(began_ns + std::max(Collider::kPeriodNs, took_ns * 5 / 3));
    }
  });
  if (!collide) return collide;
  auto servo = run(servo_thread_, "servo", options_.servo_priority, [this] {
    servo_->begin();
    while (!stop_.load(std::memory_order_relaxed)) {
      if (const std::uint64_t stand = hold_.load(std::memory_order_relaxed); stand != 0) standStill(stand);
      servo_->runOnce();
    }
    servo_->end();
    servo_ended_.store(true, std::memory_order_release);  // R6, pairs with A6
  });
  if (!servo) return servo;
  realtime_ = note_.empty();
  servo_->no_realtime.store(!realtime_, std::memory_order_relaxed);
  return {};
}

void DeviceGroup::standStill(std::uint64_t stand) HD_RT {
  held_.store(stand, std::memory_order_release);  // R3, pairs with A3: the servo's own is free to change
  // A4, pairs with R4: it goes on with what has been changed, whichever of the two it sees first.
  while (hold_.load(std::memory_order_acquire) == stand && !stop_.load(std::memory_order_acquire)) {
    clock_.sleepUntil(clock_.now() + options_.cycle.period_ns);
    // It lives: else the panel took all others' amplifiers off. With its own on it would hold a force: no beat then.
    SafetyLines::Sign* const sign = servo_->sign;
    if (sign == nullptr || sign->enabled.load(std::memory_order_relaxed)) continue;
    const bool begun = sign->cycles.load(std::memory_order_relaxed) != 0;
    if (begun) sign->cycles.fetch_add(1, std::memory_order_release);  // R9, pairs with A9
  }
  servo_->skipPassed();
}

Result<void> DeviceGroup::betweenCycles(const std::function<void(Servo&)>& work) {
  if (!options_.threads) {
    work(*servo_);
    return {};
  }
  const Error late{ErrorCode::kTimeout, "servo", "it did not come to a stand within 100 ms", "see hapticctl status"};
  // One that does not come back from a driver is not waited for by whoever asks: others are to be served.
  constexpr std::int64_t kGone_ns = 1'000'000'000;
  const std::int64_t last_ns = servo_->counters.last_cycle_ns.load(std::memory_order_relaxed);
  if (last_ns != 0 && clock_.now() - last_ns > kGone_ns) return late;
  // Nor is one that was found so before, as in its first cycle, and has ended none since.
  const std::uint64_t cycles = servo_->counters.cycles.load(std::memory_order_acquire);  // A7
  if (late_at_ == cycles + 1) return late;
  // Each has its number: a servo that came too late to the last one is not taken to stand in this.
  const std::uint64_t stand = ++stands_;
  hold_.store(stand, std::memory_order_release);            // R4
  struct LetGo {                                            // Also when `work` throws.
    ~LetGo() { hold.store(0, std::memory_order_release); }  // R4
    std::atomic<std::uint64_t>& hold;
  };
  const LetGo let_go{hold_};
  constexpr std::int64_t kLookNs = 200'000;
  for (int looks = 0; looks < 500; ++looks) {
    if (held_.load(std::memory_order_acquire) == stand) {  // A3
      work(*servo_);
      return {};
    }
    clock_.sleepUntil(clock_.now() + kLookNs);
  }
  late_at_ = cycles + 1;
  return late;
}

bool DeviceGroup::endThreads(std::int64_t patience_ns) {
  if (servo_thread_.running()) {
    Patience patience(clock_, patience_ns);
    stop_.store(true, std::memory_order_release);  // R4
    if (!patience.until([this] { return servoEnded(); })) {
      stop_.store(false, std::memory_order_relaxed);  // Should it end all the same, the next call joins it.
      for (auto& device : devices_) device->safe();
      return false;
    }
  }
  joinAll();
  return true;
}

void DeviceGroup::joinAll() noexcept {
  stop_.store(true, std::memory_order_release);  // R4
  servo_thread_.join();
  SafetyLines::giveBack(std::exchange(servo_->sign, nullptr));  // First: to join the others may outlast its beat.
  stop_others_.store(true, std::memory_order_relaxed);
  collide_thread_.join();
  ingest_thread_.join();
}

DeviceGroup::Leaving DeviceGroup::takeDevices() {
  joinAll();
  Leaving leaving;
  leaving.devices = std::move(devices_);
  leaving.last_resort = std::move(last_resort_);
  devices_.clear();
  return leaving;
}

DeviceGroup::~DeviceGroup() {
  joinAll();
  last_resort_.clear();
  for (auto& device : devices_) {
    device->safe();
    device->close();
  }
}

bool DeviceGroup::send(const Command& command) {
  if (!servo_->from_control.push(command)) return false;
  ++sent_;
  return true;
}

std::uint64_t DeviceGroup::takenByServo() const {
  // A2, pairs with R2 in Servo::count(). The counter wraps; at most 512 orders are under way.
  return widened(servo_->counters.control_applied.load(std::memory_order_acquire));
}

std::uint64_t DeviceGroup::taken() {
  std::uint64_t passed = takenByServo();
  // A5, pairs with R5 in Collider::step(): after the servo's count, so that a question older than it is seen.
  const std::uint64_t reading = collider_->reading();
  if (reading == Collider::kTaking) return taken_;
  if (reading != Collider::kIdle) passed = std::min(passed, widened(static_cast<std::uint32_t>(reading)));
  taken_ = std::max(taken_, passed);
  return taken_;
}

void DeviceGroup::step() {
  ingest_->step(clock_.now(), servo_->counters.tick.load(std::memory_order_relaxed));
  servo_->runOnce();
  collider_->step(nullptr);
}

}  // namespace hapticd
