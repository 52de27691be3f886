// What a pantograph's board may say, in whatever portions: angles are finite, the grip is, nothing is read twice.
#include <cstdint>
#include <cstdlib>

#include "drivers/pantograph/pantograph_kinematics.h"
#include "drivers/pantograph/pantograph_protocol.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace hapticd::pantograph;
  Parser parser;
  std::uint64_t used = 0, fed = 0;
  while (size > 0) {
    const std::size_t length = data[0] < size ? data[0] : size - 1;
    parser.feed({data + 1, length});
    fed += length;
    while (const auto angles = parser.next()) {
      used += kAnswerBytes;
      const Vec2 radians(static_cast<double>((*angles)[0]), static_cast<double>((*angles)[1]));
      if (!radians.allFinite()) std::abort();
      const Grip grip = gripAt({}, radians);
      if (!grip.p.allFinite() || !grip.jacobian.allFinite() || !(grip.p.norm() < 0.2)) std::abort();
    }
    if (used + parser.dropped() > fed) std::abort();
    data += 1 + length;
    size -= 1 + length;
  }
  return 0;
}
