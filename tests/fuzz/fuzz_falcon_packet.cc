// What a Falcon says, in pieces of any size: every byte is read or dropped, and what was read is where a grip can be.
#include <cstdint>
#include <cstdlib>

#include "drivers/falcon/falcon_kinematics.h"
#include "drivers/falcon/falcon_protocol.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace hapticd;
  falcon::Parser parser;
  falcon::Reading reading;
  std::size_t read = 0;
  Vec3 guess = falcon::kMiddle;
  for (std::size_t at = 0; at < size;) {
    const std::size_t piece = std::min<std::size_t>(size - at, 1 + data[at] % 80);
    parser.feed(falcon::payload({data + at, piece}));
    read += piece < falcon::kModemBytes ? 0 : piece - falcon::kModemBytes;
    at += piece;
    while (parser.next(reading)) {
      if (read < falcon::kPacket) std::abort();
      read -= falcon::kPacket;
      const Vec3 t1(falcon::armAngle(reading.encoder[0]), falcon::armAngle(reading.encoder[1]),
                    falcon::armAngle(reading.encoder[2]));
      const auto grip = falcon::gripAt(t1, guess);
      if (!grip) continue;
      if (!grip->p.allFinite() || !falcon::legsAt(grip->p)) std::abort();
      guess = grip->p;
      const auto torques = falcon::torquesFor(grip->dt1_dp, Vec3(1, 2, 3));
      if (torques && !torques->allFinite()) std::abort();
    }
    if (parser.dropped() > read) std::abort();
    if (read - parser.dropped() >= falcon::kPacket) std::abort();
  }
  return 0;
}
