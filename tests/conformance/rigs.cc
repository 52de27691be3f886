// Who joins the conformance suite: one line each.
#include "tests/conformance/falcon_rig.h"
#include "tests/conformance/rig.h"
#include "tests/conformance/sample_rig.h"
#include "tests/conformance/sim_rig.h"

namespace hapticd::test {

std::vector<RigCase> rigCases() {
  return {
      {"Sim", makeSimRig},
      {"Sample", [] { return std::make_unique<SampleRig>(); }},
      {"Falcon", [] { return std::make_unique<FalconRig>(); }},
  };
}

}  // namespace hapticd::test
