// Who joins the conformance suite: one line each.
#include "tests/conformance/falcon_rig.h"
#include "tests/conformance/rig.h"
#include "tests/conformance/sample_rig.h"
#include "tests/conformance/sim_rig.h"
#include "tests/conformance/vendor_rig.h"
#include "tests/conformance/woody_rig.h"

namespace hapticd::test {

std::vector<RigCase> rigCases() {
  return {
      {"Sim", makeSimRig, false},
      {"Sample", [] { return std::make_unique<SampleRig>(); }},
      {"Falcon", [] { return std::make_unique<FalconRig>(); }},
      {"Wooden2015", [] { return std::make_unique<WoodyRig>(haptic_emu::WoodyKind::kWooden2015); }},
      {"Polhem3", [] { return std::make_unique<WoodyRig>(haptic_emu::WoodyKind::kPolhem3, std::uint8_t{14}); }},
      {"ForceDimensionOmega", [] { return std::make_unique<VendorRig>(VendorRig::Kind::kOmega3); }},
      {"ForceDimensionSigma", [] { return std::make_unique<VendorRig>(VendorRig::Kind::kSigma7); }},
      {"OpenHaptics", [] { return std::make_unique<VendorRig>(VendorRig::Kind::kTouch); }},
  };
}

std::vector<RigCase> wireCases() {
  std::vector<RigCase> out = rigCases();
  std::erase_if(out, [](const RigCase& each) { return !each.wire; });
  return out;
}

}  // namespace hapticd::test
