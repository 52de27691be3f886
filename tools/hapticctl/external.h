/** @file
 * Subcommands that are programs of their own (hapticctl-NAME), and advice for those that do not exist.
 */
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace hapticctl {

/** Where hapticctl-NAME is: beside this program, where it is built (../hapticctl-NAME), in the libexec folder installed
 * with it, or on PATH; empty if nowhere. */
[[nodiscard]] std::string findExternal(std::string_view name);
/**
 * Becomes that program, the command being word `word`. It finds in HAPTICCTL who called it, and in HAPTICD_SOCKET the
 * socket, where the user has given one before the command; what else stands there comes behind its arguments, if it
 * `hands_on` what it does not know. Returns only on failure, with errno set.
 */
void runExternal(const std::string& program, int argc, char** argv, int word, bool hands_on);
/** Those of `known` that `word` may have meant, nearest first. */
[[nodiscard]] std::vector<std::string> suggestions(std::string_view word, const std::vector<std::string>& known);

}  // namespace hapticctl
