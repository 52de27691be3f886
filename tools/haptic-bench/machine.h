/** @file
 * The machine a number was measured on: a number without it means nothing.
 */
#pragma once

#include <string>
#include <vector>

namespace haptic_bench {

/** CPU, kernel, preemption, governor, clock source, virtual or not, load, build flags; one "name: value" a line. */
[[nodiscard]] std::vector<std::string> describeMachine();

}  // namespace haptic_bench
