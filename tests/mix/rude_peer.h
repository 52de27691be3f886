/** @file
 * A peer of the control socket that speaks Cap'n Proto as nobody should: calls of anything with anything in it, answers
 * to nothing that was asked, messages with some bits turned, or cut short.
 */
#pragma once

#include <cstdint>
#include <string>

namespace hapticd::test {

/** Some hundreds of messages, whether anybody answers or not. */
void beRude(const std::string& socket, std::uint32_t seed);

/** A session whose client writes anything anywhere in its region, until the daemon has had enough. */
void scribble(const std::string& socket, std::uint32_t seed);

}  // namespace hapticd::test
