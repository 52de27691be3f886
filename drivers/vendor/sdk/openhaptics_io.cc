#include "drivers/vendor/sdk/openhaptics_io.h"

#include <fmt/format.h>

#include <algorithm>

#include "drivers/link/shortened.h"

namespace hapticd {
namespace {

constexpr double kMetres = 1e-3;

/** The library's axes (right, up, toward the operator) and ours (toward the operator, right, up). */
Vec3 toWorld(const Vec3& v_H) { return {v_H.z(), v_H.x(), v_H.y()}; }
Vec3 toDevice(const Vec3& v_W) { return {v_W.y(), v_W.z(), v_W.x()}; }
Eigen::Matrix3d worldFromDevice() {
  Eigen::Matrix3d m;
  m << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  return m;
}

}  // namespace

/** While it stands a tick may use the link: leaveLink() waits for its end. */
class OpenHapticsIo::Inside {
 public:
  explicit Inside(OpenHapticsIo& io) noexcept : io_(io) {
    io_.inside_.store(true);  // D1: before link_ is read; pairs with D2 in leaveLink()
    link = io_.link_.load();
  }
  ~Inside() { io_.inside_.store(false, std::memory_order_release); }
  Inside(const Inside&) = delete;
  Inside& operator=(const Inside&) = delete;
  DeviceLink* link = nullptr;

 private:
  OpenHapticsIo& io_;
};

Result<void> OpenHapticsIo::open(const std::atomic<bool>&) {
  if (!sdk_) {
    auto loaded = HdSdk::load(setup_.parameters.sdk);
    if (!loaded) return loaded.error();
    sdk_ = *loaded;
  }
  device_ = sdk_->initDevice(setup_.device.empty() ? nullptr : setup_.device.c_str());
  const HdSdk::ErrorInfo error = sdk_->getError();
  if (device_ == HdSdk::kNoDevice || error.code / 0x100 == HdSdk::kDeviceErrors) {
    const char* const why = sdk_->getErrorString(error.code);
    if (device_ != HdSdk::kNoDevice) sdk_->disableDevice(device_);
    device_ = HdSdk::kNoDevice;
    return Error{ErrorCode::kDeviceGone, setup_.info.uri,
                 fmt::format("it does not open: {} (0x{:x})", why == nullptr ? "no reason given" : why, error.code),
                 "is it plugged in, and set up under this name with the maker's Touch Setup?"};
  }
  sdk_->disable(HdSdk::kForceOutput);
  if (!described_) describe();
  described_ = true;
  gone_ = asked_ = saturated_ = energised_ = false;
  wrote_ = kDeviceOk;
  ticks_ = 0;
  check_.forget();
  (void)errors();
  calibrate();
  ticked_ns_ = clock_.now();
  scheduled_ = sdk_->scheduleAsynchronous(
      [](void* self) -> unsigned int {
        static_cast<OpenHapticsIo*>(self)->tick();
        return HdSdk::kContinue;
      },
      this, HdSdk::kHighPriority);
  sdk_->startScheduler();
  if ((errors() & kDeviceGone) == 0) return {};
  return Error{ErrorCode::kDeviceGone, setup_.info.uri, "its scheduler does not start", "see the maker's diagnostic"};
}

void OpenHapticsIo::describe() {
  DeviceInfo& info = setup_.info;
  const auto text = [&](HdSdk::Enum what, std::string& out) {
    if (const char* const said = sdk_->getString(what); said != nullptr && *said != '\0') out = said;
  };
  text(HdSdk::kModel, info.model);
  text(HdSdk::kSerial, info.serial);
  text(HdSdk::kFirmware, info.firmware);
  const auto number = [&](HdSdk::Enum what, double unit, double& out) {
    double value = 0;
    sdk_->getDoublev(what, &value);
    if (std::isfinite(value) && value > 0) out = value * unit;
  };
  number(HdSdk::kMaxForce, 1, info.max_force);
  number(HdSdk::kContinuousForce, 1, info.continuous_force);
  number(HdSdk::kMaxStiffness, 1000, info.max_stiffness);  // Told in N/mm.
  number(HdSdk::kMaxDamping, 1000, info.max_damping);
  const auto box = [&](HdSdk::Enum what, Vec3& lower, Vec3& upper) {
    double mm[6] = {};
    sdk_->getDoublev(what, mm);
    const Vec3 a = kMetres * toWorld({mm[0], mm[1], mm[2]}), b = kMetres * toWorld({mm[3], mm[4], mm[5]});
    if (!a.allFinite() || !b.allFinite() || !((b - a).array() > 0.01).all() || !((b - a).array() < 2).all()) return;
    lower = a;
    upper = b;
  };
  box(HdSdk::kUsableWorkspace, info.workspace_lower, info.workspace_upper);
  Vec3 lower = info.workspace_lower, upper = info.workspace_upper;
  box(HdSdk::kMaxWorkspace, lower, upper);
  // The grip gets beyond the box of nominal figures.
  const Vec3 more = 0.5 * (upper - lower);
  info.max_workspace_lower = info.workspace_lower.cwiseMin(lower - more);
  info.max_workspace_upper = info.workspace_upper.cwiseMax(upper + more);
  info.workspace_radius = 0.5 * (info.workspace_upper - info.workspace_lower).minCoeff();
  (void)errors();
}

void OpenHapticsIo::leaveLink() noexcept {
  link_.store(nullptr);  // D2: before inside_ is read; pairs with D1
  // A library that never comes back from a call keeps this thread here; hapticd-vendor then ends its process.
  while (inside_.load()) clock_.sleepUntil(clock_.now() + 10'000);
}

void OpenHapticsIo::close() noexcept {
  if (device_ == HdSdk::kNoDevice) return;
  leaveLink();
  sdk_->stopScheduler();  // From here on no tick.
  sdk_->unschedule(scheduled_);
  constexpr double kZero[3] = {};
  sdk_->makeCurrentDevice(device_);
  sdk_->beginFrame(device_);
  sdk_->setDoublev(HdSdk::kForce, kZero);
  sdk_->endFrame(device_);
  sdk_->disable(HdSdk::kForceOutput);
  sdk_->disableDevice(device_);
  (void)errors();
  device_ = HdSdk::kNoDevice;
  calibration_.store(Calibration::kNeeded);
}

bool OpenHapticsIo::exchange(DeviceLink& link, std::int64_t until_ns) noexcept {
  link_.store(&link);
  while (clock_.now() < until_ns) {
    clock_.sleepUntil(std::min(until_ns, clock_.now() + kLook_ns));
    if (!gone_.load() && clock_.now() - ticked_ns_.load() < kSilent_ns) continue;
    leaveLink();
    return false;
  }
  return true;
}

/** Most recent first: what each means for the device. */
std::uint32_t OpenHapticsIo::errors() noexcept {
  std::uint32_t status = kDeviceOk;
  for (int i = 0; i < kMostErrors; ++i) {
    const unsigned int code = sdk_->getError().code & 0xFFFF;
    if (code == 0) break;
    if (code / 0x100 == HdSdk::kDeviceErrors) status |= kDeviceGone;
    if (code / 0x100 == HdSdk::kForceErrors) status |= kDeviceError;
  }
  return status;
}

void OpenHapticsIo::calibrate() noexcept {
  HdSdk::Enum state = sdk_->checkCalibration();
  if (state == HdSdk::kCalibrationNeedsUpdate) {  // No force is needed.
    int told = 0;
    sdk_->getIntegerv(HdSdk::kCalibrationStyle, &told);
    const auto styles = static_cast<HdSdk::Enum>(told);
    // Never by a reset of the encoders, which takes whatever pose the arm is in for the one it should be in.
    for (const HdSdk::Enum style : {HdSdk::kByItself, HdSdk::kInInkwell}) {
      if ((styles & style) == 0) continue;
      sdk_->updateCalibration(style);
      break;
    }
    state = sdk_->checkCalibration();
  }
  const bool done = state == HdSdk::kCalibrated;
  if (done != (calibration_.load() == Calibration::kDone)) check_.forget();
  calibration_.store(done ? Calibration::kDone : Calibration::kNeeded);
}

void OpenHapticsIo::tick() noexcept {
  if (gone_.load()) return;
  sdk_->makeCurrentDevice(device_);
  if (!energised_ && ++ticks_ % kCalibrationEvery == 0) calibrate();
  sdk_->beginFrame(device_);
  double transform[16] = {};
  int buttons = 0;
  sdk_->getDoublev(HdSdk::kTransform, transform);
  sdk_->getDoublev(HdSdk::kPosition, transform + 12);  // The same place, told in the documented unit.
  sdk_->getIntegerv(HdSdk::kButtons, &buttons);
  const std::uint32_t read = errors() | wrote_;
  if (read == kDeviceOk) take(transform, buttons);
  {
    const Inside inside(*this);
    const auto finish = [this](const DeviceCommand& command) noexcept {
      send(command);
      sdk_->endFrame(device_);  // The transfer: within order(), so that safe() knows of it.
    };
    if (inside.link == nullptr) {
      finish({});
    } else {
      if (read != kDeviceOk) {
        LinkCounters::add(inside.link->counters.lost);
        inside.link->publishStatus(read);
      }
      inside.link->order(clock_.now(), finish);
    }
  }
  wrote_ = errors();  // Of the force: they come with the frame's end, and are told with the next reading.
  if (((read | wrote_) & kDeviceGone) != 0) gone_.store(true);
  ticked_ns_.store(clock_.now());
}

void OpenHapticsIo::take(const double* transform, int buttons) noexcept {
  const std::int64_t now_ns = clock_.now();
  const Inside inside(*this);
  if (inside.link == nullptr) return;
  DeviceLink& link = *inside.link;
  LinkCounters::add(link.counters.exchanges);
  if (asked_) link.round_trip.record(now_ns - asked_ns_);
  asked_ = false;
  if (calibration_.load() != Calibration::kDone) return;
  const Eigen::Matrix3d r_H = Eigen::Map<const Eigen::Matrix4d>(transform).topLeftCorner<3, 3>();
  const auto q = rotationOf(worldFromDevice() * r_H * worldFromDevice().transpose());
  DeviceSample sample;
  sample.t_ns = now_ns;
  sample.p = kMetres * toWorld({transform[12], transform[13], transform[14]});
  if (!q) sample.p.setConstant(std::nan(""));  // A pose is one thing: believed or not.
  const PoseCheck::Verdict verdict = check_.judge(sample.p, now_ns, setup_.info);
  if (verdict != PoseCheck::Verdict::kBelieved) {
    LinkCounters::add(link.counters.rejected);
    if (verdict == PoseCheck::Verdict::kBroken) link.publishStatus(kDeviceError);
    return;
  }
  sample.q = *q;
  sample.buttons = static_cast<std::uint32_t>(buttons);
  sample.status = saturated_ ? kDeviceSaturated : kDeviceOk;
  link.publish(sample);
}

void OpenHapticsIo::send(const DeviceCommand& command) noexcept {
  const std::int64_t now_ns = clock_.now();
  asked_ns_ = now_ns;
  asked_ = true;
  saturated_ = false;
  if (command.enabled != energised_) {
    command.enabled ? sdk_->enable(HdSdk::kForceOutput) : sdk_->disable(HdSdk::kForceOutput);
    energised_ = command.enabled;
  }
  const bool trusted = calibration_.load() == Calibration::kDone && check_.trusted(now_ns, kTrust_ns);
  Vec3 force = Vec3::Zero();
  if (command.enabled && trusted) force = toDevice(shortened(command.force, setup_.info.max_force, saturated_));
  sdk_->setDoublev(HdSdk::kForce, force.data());
}

}  // namespace hapticd
