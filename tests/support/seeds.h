/** @file
 * Which seeds a test draws from. The same in every run, unless the environment says otherwise: HAPTICD_FIRST_SEED=n
 * counts from n instead of 1, for a soak; HAPTICD_SEED=n runs one seed of a property only, and of others the nth.
 */
#pragma once

#include <cstdint>
#include <cstdlib>
#include <vector>

namespace hapticd {

// g++'s first: some library gives it a __has_feature that knows nothing.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define HAPTICD_SANITIZED 1
#elif defined(__has_feature)
#define HAPTICD_SANITIZED (__has_feature(address_sanitizer) || __has_feature(thread_sanitizer))
#endif

/** Of so many draws of one kind, of which a few show what a sanitizer can see of them: there a quarter. */
template <class Int>
constexpr Int drawn(Int count) {
#if HAPTICD_SANITIZED
  if (count >= 8) count = (count + 3) / 4;
#endif
  return count;
}

/** The seeds of a property: 1 to drawn(count), or those that the environment names. */
inline std::vector<unsigned> seeds(unsigned count) {
  const char* const one = std::getenv("HAPTICD_SEED");
  const char* const from = one != nullptr ? one : std::getenv("HAPTICD_FIRST_SEED");
  const unsigned first = from != nullptr ? static_cast<unsigned>(std::strtoul(from, nullptr, 10)) : 1;
  std::vector<unsigned> all;
  for (unsigned i = 0; i < (one != nullptr ? 1 : drawn(count)); ++i) all.push_back(first + i);
  return all;
}

/** Whether a property draws all that it names, and must have met what is rare. */
inline bool drawsAll() { return seeds(8).size() == 8; }

/** The seed of a test that draws from one: the usual one, or as far from it as the environment is from 1. */
inline std::uint32_t seedOf(std::uint32_t usual) { return usual + seeds(1).front() - 1; }

}  // namespace hapticd
