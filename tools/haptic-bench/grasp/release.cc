#include "tools/haptic-bench/grasp/release.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace haptic_bench::grasp {
namespace {

using namespace hapticd;  // NOLINT(google-build-using-namespace)

constexpr double kLetsGo = 0.1;     // Part of its depth by which a finger opens in a second [1/s].
constexpr double kEnough_m = 0.02;  // Slid so far, or
constexpr double kEnough_rad = std::numbers::pi / 3;
constexpr double kPatience_s = 60;
constexpr int kSwings_ticks = 2000;     // Between soft fingers, before it hangs still.
constexpr double kBarStiffness = 1000;  // Of the bar [N/m]

}  // namespace

SetFinger fingerOf(bool coupled, double arm, double stiffness) {
  SetFinger finger{};
  finger.law = static_cast<std::uint32_t>(PadLaw::kLinear);
  finger.flags = coupled ? 0U : kFingerUncoupled;
  finger.radius = FingertipConstants::kRadius;
  finger.arm = arm;
  finger.stiffness = stiffness;
  finger.damping = 2;
  return finger;
}

Block barOf(double mass, double lever) {
  Block bar;
  bar.half = {0.03, 0.06, 0.015};
  bar.lever = lever;
  bar.mass = mass;
  bar.material = {kBarStiffness, 1, kSandpaper, kSandpaperSliding};
  return bar;
}

double yieldsAt(const Block& block, bool coupled, double arm, double turned) {
  const double part = std::abs(block.lever * std::cos(turned)) / arm;
  return block.slips() * (coupled ? std::hypot(1, part) : std::max(1.0, part));
}

Release letGo(bool coupled, double arm, double lever, const Watch& watch) {
  const Block bar = barOf(0.2, lever);
  Release out{coupled, arm, lever};
  out.slid_10 = out.slid_30 = out.turned_5 = std::numeric_limits<double>::quiet_NaN();
  Hand steady;
  steady.unsteady = 0;
  Rig rig(bar, steady, fingerOf(coupled, arm, kBarStiffness * arm * arm));
  rig.grasp(1.5 * yieldsAt(bar, coupled, arm, 0) + 0.5);
  for (int i = 0; i < kSwings_ticks; ++i) rig.tick();
  out.closed = yieldsAt(bar, coupled, arm, rig.turned());
  const double turned = rig.turned(), began = rig.time();
  const auto once = [](double& value, bool now, double is) {
    if (now && std::isnan(value)) value = is;
  };
  bool yielded = false;
  while (rig.time() - began < kPatience_s && rig.held()) {
    const double slid = rig.slid(), angle = std::abs(rig.turned() - turned);
    const Vec3 com = rig.place() * Vec3(0, lever, 0);
    if (watch) watch(out, {rig.time() - began, com.y(), com.z(), rig.turned(), slid, rig.grip()});
    yielded = yielded || rig.slips();
    if (!yielded) out.yields = rig.grip();
    once(out.slid_10, angle > std::numbers::pi / 18, slid);
    once(out.slid_30, angle > std::numbers::pi / 6, slid);
    once(out.turned_5, slid > 5e-3, angle);
    if (slid > kEnough_m || angle > kEnough_rad) break;
    rig.want(rig.wanted() * (1 - kLetsGo * kPeriod_s));
    rig.tick();
  }
  return out;
}

std::vector<Release> releases(const Watch& watch) {
  std::vector<Release> out;
  for (const double arm : {kSandpaperArm, 3 * kSandpaperArm}) {
    for (const double part : {0.25, 0.5, 1.0, 2.0}) {
      for (const bool coupled : {true, false}) out.push_back(letGo(coupled, arm, part * arm, watch));
    }
  }
  return out;
}

}  // namespace haptic_bench::grasp
