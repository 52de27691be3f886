/** @file
 * A property over many seeds.
 */
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "tests/support/random.h"

namespace hapticd {

/** Runs `check` for many seeds; stops at the first that fails and names it. */
template <class Check>
void forSeeds(unsigned count, Check check) {
  for (const unsigned seed : seeds(count)) {
    SCOPED_TRACE("HAPTICD_SEED=" + std::to_string(seed));
    check(seed);
    if (::testing::Test::HasFailure()) return;
  }
}

}  // namespace hapticd
