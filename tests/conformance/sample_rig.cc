#include "tests/conformance/sample_rig.h"

#include <gtest/gtest.h>

#include "tests/conformance/trouble.h"

namespace hapticd::test {

void SampleRig::advance(std::int64_t ns) {
  const std::int64_t until_ns = clock.now() + ns;
  while (clock.now() < until_ns) {
    if (held_) model.hand.place(model.hand.position() + clampNorm(at_ - model.hand.position(), 0.5e-3));
    const std::int64_t step_ns = std::min<std::int64_t>(until_ns, clock.now() + 250'000);
    device_.pump(step_ns);
    clock.sleepUntil(step_ns);
    model.advance(clock.now());
  }
}

void SampleRig::makeReady() {
  const auto opened = device_.open();
  ASSERT_TRUE(opened.ok()) << toString(opened.error());
}

void SampleRig::trouble(Trouble trouble, bool on) { makeTrouble(model.faults, trouble, on); }

std::uint64_t SampleRig::complaints() const { return complaintsOf(const_cast<IoDevice&>(device_).link().counters); }

}  // namespace hapticd::test
