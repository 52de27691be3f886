#include "tests/conformance/woody_rig.h"

#include <gtest/gtest.h>

#include "tests/conformance/play.h"
#include "tests/conformance/trouble.h"
#include "tests/support/time.h"

namespace hapticd::test {
namespace {

WoodySetup played(haptic_emu::WoodyKind kind, haptic_emu::WoodyHidModel& model, ManualClock& clock, const char* key) {
  DeviceUri uri{"woodyhid", kind == haptic_emu::WoodyKind::kPolhem3 ? "polhem_v3" : "woodenhaptics_v2015", {}};
  if (key != nullptr) uri.query.emplace_back(key, "1");
  auto setup = resolveWoody(uri);
  EXPECT_TRUE(setup.ok());
  setup->counters = std::make_shared<WoodyCounters>();
  setup->hid = [&model, &clock] { return std::make_unique<haptic_emu::InProcessHid>(model, clock); };
  return std::move(*setup);
}

}  // namespace

WoodyRig::WoodyRig(haptic_emu::WoodyKind kind, std::uint8_t report_bytes, const char* query_key)
    : model(kind, report_bytes),
      setup(played(kind, model, clock, query_key)),
      device_(std::make_unique<WoodyIo>(setup), {.thread = false}, clock) {}

void WoodyRig::advance(std::int64_t ns) {
  play(ns, clock, device_, model, [this] {
    if (held_) model.hand.place(at_);
  });
}

void WoodyRig::calibrate() {
  std::array<std::int32_t, 6> counts{};
  for (std::size_t i = 0; i < 6; ++i) counts[i] = setup.model->calibration[i];
  for (std::size_t i = 0; i < 3; ++i) model.gimbal[i] = setup.model->calibration[3 + i];
  hold(solveWoodyArm(*setup.model, woodyAngles(*setup.model, counts)).p);
  device_.write(clock.now(), {});
  advance(20 * kMs);
  model.pressCalibration();
  advance(20 * kMs);
}

void WoodyRig::makeReady() {
  const auto opened = device_.open();
  ASSERT_TRUE(opened.ok()) << toString(opened.error());
  calibrate();
  ASSERT_EQ(device_.calibration(), Calibration::kDone);
}

void WoodyRig::hold(const Vec3& p) {
  // A hand brings the arm there: nobody jumps half a metre in a millisecond.
  constexpr int kSteps = 200;
  const Vec3 from = model.hand.position();
  held_ = true;
  for (int i = 1; i <= kSteps; ++i) {
    at_ = from + (p - from) * (static_cast<double>(i) / kSteps);
    advance(kMs);
  }
}

void WoodyRig::trouble(Trouble trouble, bool on) { makeTrouble(model.faults, trouble, on); }

std::uint64_t WoodyRig::complaints() const { return complaintsOf(const_cast<IoDevice&>(device_).link().counters); }

}  // namespace hapticd::test
