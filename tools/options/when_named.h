/** @file
 * A subcommand is chosen while the command line is read, and run when all of it is.
 */
#pragma once

#include <CLI/CLI.hpp>
#include <type_traits>
#include <utility>

namespace hapticd_options {

/** What is chosen when the command line names `command`. */
template <class Action>
void whenNamed(CLI::App* command, Action& chosen, std::type_identity_t<Action> action) {
  command->callback([&chosen, action = std::move(action)] { chosen = action; });
}

}  // namespace hapticd_options
