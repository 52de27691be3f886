#include "tests/conformance/sample_rig.h"

#include <gtest/gtest.h>

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

void SampleRig::trouble(Trouble trouble, bool on) {
  using haptic_emu::FaultKind;
  constexpr FaultKind kKinds[] = {FaultKind::kSilence, FaultKind::kGarbage, FaultKind::kTruncation,
                                  FaultKind::kEncoderJump};
  if (on) {
    model.faults.add({kKinds[static_cast<std::size_t>(trouble)], 0, INT64_MAX});
  } else {
    model.faults.clear();
  }
}

std::uint64_t SampleRig::complaints() const {
  const LinkCounters& counters = const_cast<IoDevice&>(device_).link().counters;
  return counters.dropped_bytes.load() + counters.rejected.load() + counters.lost.load();
}

}  // namespace hapticd::test
