/** @file
 * Which seeds a test draws from. The same in every run, unless the environment says otherwise: HAPTICD_FIRST_SEED=n
 * counts from n instead of 1, for a soak; HAPTICD_SEED=n runs one seed of a property only, and of others the nth.
 */
#pragma once

#include <cstdint>
#include <cstdlib>
#include <vector>

namespace hapticd {

/** The seeds of a property: 1 to count, or those that the environment names. */
inline std::vector<unsigned> seeds(unsigned count) {
  const char* const one = std::getenv("HAPTICD_SEED");
  const char* const from = one != nullptr ? one : std::getenv("HAPTICD_FIRST_SEED");
  const unsigned first = from != nullptr ? static_cast<unsigned>(std::strtoul(from, nullptr, 10)) : 1;
  std::vector<unsigned> all;
  for (unsigned i = 0; i < (one != nullptr ? 1 : count); ++i) all.push_back(first + i);
  return all;
}

/** The seeds of a property that takes half a minute and more under the thread sanitizer: there a quarter of them. */
inline std::vector<unsigned> longSeeds(unsigned count) {
#if defined(__SANITIZE_THREAD__)
  count = (count + 3) / 4;
#endif
  return seeds(count);
}

#if defined(__has_feature)
#define HAPTICD_SEES_ADDRESSES __has_feature(address_sanitizer)
#elif defined(__SANITIZE_ADDRESS__)
#define HAPTICD_SEES_ADDRESSES 1
#endif

/** Of so many draws of one kind, of which a few show what the address sanitizer can see of them: there a quarter. */
constexpr unsigned drawn(unsigned count) {
#if HAPTICD_SEES_ADDRESSES
  count = (count + 3) / 4;
#endif
  return count;
}

/** The seed of a test that draws from one: the usual one, or as far from it as the environment is from 1. */
inline std::uint32_t seedOf(std::uint32_t usual) { return usual + seeds(1).front() - 1; }

}  // namespace hapticd
