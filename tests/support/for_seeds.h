/** @file
 * A property over many seeds.
 */
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/support/random.h"

namespace hapticd {

/** Runs `check` for each; stops at the first that fails and names it. */
template <class Check>
void forEachSeed(const std::vector<unsigned>& all, Check&& check) {
  for (const unsigned seed : all) {
    SCOPED_TRACE("HAPTICD_SEED=" + std::to_string(seed));
    check(seed);
    if (::testing::Test::HasFailure()) return;
  }
}

template <class Check>
void forSeeds(unsigned count, Check&& check) {
  forEachSeed(seeds(count), check);
}
/** After those that a soak has found. */
template <class Check>
void forSeeds(const std::vector<unsigned>& found, unsigned count, Check&& check) {
  forEachSeed(found, check);
  if (!::testing::Test::HasFailure()) forSeeds(count, check);
}

}  // namespace hapticd
