/** @file
 * Ticks from a client's push to the force it makes.
 */
#pragma once

#include <cstdint>

namespace haptic_bench {

/**
 * A session, an ingest and a servo stepped by hand, with the client's pushes at every phase of the period and ingest
 * anywhere within it. Returns the most ticks that began between a push and the end of the one whose force shows it:
 * counts, so it is exact on any machine. `seed` moves the phases.
 */
[[nodiscard]] double worstPushToForce(std::uint32_t seed);

}  // namespace haptic_bench
