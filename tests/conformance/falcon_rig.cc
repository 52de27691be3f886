#include "tests/conformance/falcon_rig.h"

#include <gtest/gtest.h>

#include "tests/conformance/play.h"
#include "tests/conformance/trouble.h"
#include "tests/support/time.h"

namespace hapticd::test {
namespace {

FalconSetup played(haptic_emu::FalconModel& model, ManualClock& clock) {
  auto setup = resolveFalcon({"falcon", "played", {}}, {});
  EXPECT_TRUE(setup.ok());
  setup->open_usb = haptic_emu::openInProcess(model, clock);
  // As good as any other to a played device.
  setup->read_firmware = [] {
    std::vector<std::uint8_t> firmware(3000);
    for (std::size_t i = 0; i < firmware.size(); ++i) firmware[i] = static_cast<std::uint8_t>(i * 7);
    return Result<std::vector<std::uint8_t>>(firmware);
  };
  return std::move(*setup);
}

}  // namespace

FalconRig::FalconRig()
    : setup(played(model, clock)), device_(std::make_unique<FalconIo>(setup, clock), {.thread = false}, clock) {}

void FalconRig::advance(std::int64_t ns) {
  play(ns, clock, device_, model, [this] {
    // A hand takes its way, at one metre a second.
    if (held_) model.hand.place(model.hand.position() + clampNorm(at_ - model.hand.position(), 0.25e-3));
  });
}

void FalconRig::home() {
  for (const double z : {0.125, 0.172, 0.125}) {
    model.hand.place({0, 0, z});
    advance(20 * kMs);
  }
}

void FalconRig::makeReady() {
  const auto opened = device_.open();
  ASSERT_TRUE(opened.ok()) << toString(opened.error());
  home();
  ASSERT_EQ(device_.calibration(), Calibration::kDone);
}

void FalconRig::makeReadyAgain() {
  held_ = false;
  home();
}

void FalconRig::hold(const Vec3& p) {
  held_ = true;
  at_ = Vec3(p.y(), p.z(), p.x() + 0.125);
}

void FalconRig::unplug() { model.faults.add({haptic_emu::FaultKind::kUnplug, 0, INT64_MAX}); }

void FalconRig::trouble(Trouble trouble, bool on) { makeTrouble(model.faults, trouble, on); }

std::uint64_t FalconRig::complaints() const { return complaintsOf(const_cast<IoDevice&>(device_).link().counters); }

}  // namespace hapticd::test
