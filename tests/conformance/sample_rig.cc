#include "tests/conformance/sample_rig.h"

#include <gtest/gtest.h>

#include "tests/conformance/play.h"
#include "tests/conformance/trouble.h"

namespace hapticd::test {

void SampleRig::advance(std::int64_t ns) {
  play(ns, clock, device_, model, [this] {
    if (held_) model.hand.place(model.hand.position() + clampNorm(at_ - model.hand.position(), 0.5e-3));
  });
}

void SampleRig::makeReady() {
  const auto opened = device_.open();
  ASSERT_TRUE(opened.ok()) << toString(opened.error());
}

void SampleRig::trouble(Trouble trouble, bool on) { makeTrouble(model.faults, trouble, on); }

std::uint64_t SampleRig::complaints() const { return complaintsOf(const_cast<IoDevice&>(device_).link().counters); }

}  // namespace hapticd::test
