/** @file
 * The simulated device in the conformance suite.
 */
#pragma once

#include <memory>

#include "tests/conformance/rig.h"

namespace hapticd::test {

[[nodiscard]] std::unique_ptr<Rig> makeSimRig();

}  // namespace hapticd::test
