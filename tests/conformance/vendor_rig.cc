#include "tests/conformance/vendor_rig.h"

#include <dlfcn.h>
#include <gtest/gtest.h>

#include "drivers/vendor/vendor_driver.h"
#include "tests/conformance/play.h"
#include "tests/conformance/trouble.h"
#include "tests/support/time.h"

namespace hapticd::test {
namespace {

void* library() {
  void* const handle = ::dlopen(FAKE_VENDOR_SDK, RTLD_NOW | RTLD_LOCAL);
  if (handle == nullptr) throw std::runtime_error(::dlerror());
  return handle;
}

/** As when it was just loaded. */
fake_sdk::State& fresh(int system_type) {
  auto& state = *reinterpret_cast<fake_sdk::State* (*)()>(::dlsym(library(), "fake_sdk_state"))();
  std::memset(static_cast<void*>(&state), 0, sizeof state);
  state.version_major = 3;
  state.system_type = system_type;
  state.calibrated = true;
  for (int i = 0; i < 9; i += 4) state.rotation[i] = 1;
  return state;
}

Vec3 vec(const std::atomic<double> (&v)[3]) { return {v[0], v[1], v[2]}; }
// HD's axes are right, up and toward the operator.
Vec3 toWorld(const Vec3& v_H) { return {v_H.z(), v_H.x(), v_H.y()}; }
Vec3 toHd(const Vec3& v_W) { return {v_W.y(), v_W.z(), v_W.x()}; }

}  // namespace

VendorRig::VendorRig(Kind kind, const char* text)
    : state(fresh(kind == Kind::kSigma7 ? 104 : 33)),
      kind_(kind),
      tick_(reinterpret_cast<void (*)()>(::dlsym(library(), "fake_sdk_tick"))) {
  auto uri = parseDeviceUri(text != nullptr ? text : hd() ? "openhaptics://default" : "dhd://default");
  EXPECT_TRUE(uri.ok());
  uri->query.emplace_back("sdk", FAKE_VENDOR_SDK);
  auto io = makeVendorIo(*uri, clock);
  EXPECT_TRUE(io.ok()) << toString(io.error());
  device_ = std::make_unique<IoDevice>(std::move(*io), IoOptions{.thread = false}, clock);
}

void VendorRig::place(const Vec3& p) {
  const Vec3 told = hd() ? Vec3(1000 * toHd(p)) : p;
  for (int i = 0; i < 3; ++i) state.place[i] = told[i];
}

Vec3 VendorRig::truePosition() const {
  const Vec3 told = vec(state.place);
  return hd() ? Vec3(toWorld(told) / 1000) : told;
}

Vec3 VendorRig::trueForce() const { return hd() ? toWorld(vec(state.force)) : vec(state.force); }

void VendorRig::advance(std::int64_t ns) {
  // A hand takes its way, at four metres a second.
  const auto move = [this] { place(truePosition() + clampNorm(at_ - truePosition(), 1e-3)); };
  playWorld(ns, clock, *device_, move, [this] {
    if (clock.now() < next_tick_ns_) return;
    next_tick_ns_ = clock.now() + kMs;
    if (hd()) tick_();
  });
}

void VendorRig::makeReady() {
  const auto opened = device_->open();
  ASSERT_TRUE(opened.ok()) << toString(opened.error());
  advance(2 * kMs);
  ASSERT_EQ(device_->calibration(), Calibration::kDone);
}

void VendorRig::trouble(Trouble trouble, bool on) {
  for (std::atomic<bool>* fault : {&state.silent, &state.garbled, &state.failing, &state.jumping}) *fault = false;
  std::atomic<bool>& fault = trouble == Trouble::kSilence      ? state.silent
                             : trouble == Trouble::kGarbage    ? state.garbled
                             : trouble == Trouble::kTruncation ? state.failing
                                                               : state.jumping;
  fault = on;
}

std::uint64_t VendorRig::complaints() const { return complaintsOf(device_->link().counters); }

}  // namespace hapticd::test
