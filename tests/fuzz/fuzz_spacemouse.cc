// Reports of a SpaceMouse, one after the other: the tool stays in its box and finite.
#include <cstdint>
#include <cstdlib>

#include "drivers/spacemouse/cap_pose.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace hapticd;
  SpaceMouseParameters parameters;
  CapPose still(parameters);
  parameters.mode = "rate";
  CapPose moving(parameters);
  spacemouse::State state;
  // Each report with its length before it.
  while (size > 0) {
    const std::size_t length = data[0] % 20 < size ? data[0] % 20 : size - 1;
    const spacemouse::State before = state;
    const spacemouse::Report kind = spacemouse::take({data + 1, length}, state);
    if (kind == spacemouse::Report::kNone && (state.axis != before.axis || state.buttons != before.buttons))
      std::abort();
    const CapDeflection cap = capDeflection(state, parameters.dead_zone);
    still.step(cap, 0.004);
    moving.step(cap, 0.004);
    for (const CapPose* pose : {&still, &moving}) {
      if (!(pose->pose().p.cwiseAbs().maxCoeff() <= 0.1) || !isFinite(pose->pose().q)) std::abort();
    }
    data += 1 + length;
    size -= 1 + length;
  }
  return 0;
}
