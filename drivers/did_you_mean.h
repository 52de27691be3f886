/** @file
 * Which name was meant: for errors that say what is near.
 */
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace hapticd {

/** The candidate that is fewest edits away, "" if none is near. */
[[nodiscard]] std::string_view nearest(std::string_view word, const std::vector<std::string_view>& candidates);

/** The names nearest to `wanted`, at most `most`, joined by ", "; all when there are few. */
[[nodiscard]] std::string nearestNames(std::string_view wanted, std::vector<std::string> names, std::size_t most = 5);

}  // namespace hapticd
