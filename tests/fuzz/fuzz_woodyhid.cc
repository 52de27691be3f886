// Reports of WoodenHaptics and Polhem: whatever comes, the place is finite, the currents bounded.
#include <cstdint>
#include <cstdlib>

#include "drivers/woodyhid/woody_kinematics.h"
#include "drivers/woodyhid/woodyhid_protocol.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace hapticd;
  const auto reading = woodyhid::decode({data, size});
  if (reading.has_value() != (size >= woodyhid::kReportBytes)) std::abort();
  if (!reading) return 0;
  for (const WoodyModel& model : woodyModels()) {
    const Vec3 angles = woodyAngles(model, reading->encoder);
    const WoodyArm arm = solveWoodyArm(model, angles);
    const Vec3 weight = forceForTorque(arm, arm.gravity_torque, 5);
    if (!isFinite(arm.p) || !(arm.p.norm() < 2) || !(weight.norm() <= 5.0000001)) std::abort();
    if (!isFinite(woodyOrientation(model, angles, arm.pitch, reading->encoder))) std::abort();
    const WoodyCurrents out = woodyCurrents(model, arm, Vec3(3, -4, 5) + weight, 3);
    for (const std::int16_t mA : out.mA) {
      if (mA > 3000 || mA < -3000) std::abort();
    }
  }
  return 0;
}
