/** @file
 * Finding the daemon's socket.
 */
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "libclient/src/connection/fork_guard.h"
#include "libclient/src/reply/failure.h"

namespace hapticd::client {

/** What the search depends on; empty strings for what is not set. */
struct SocketSearch {
  std::string given;        ///< By the program: taken as it is.
  std::string environment;  ///< $HAPTICD_SOCKET
  std::string runtime_dir;  ///< $XDG_RUNTIME_DIR
  bool administration = false;
};

/** With the environment of this process. */
SocketSearch searchHere(std::string given, bool administration);

/** Paths to try, in order. */
std::vector<std::string> candidates(const SocketSearch& search);

/** A connected, non-blocking, close-on-exec stream socket. Waits for a place in the backlog at most so long. */
Failure connectTo(const std::string& path, std::int64_t timeout_ns, OwnDescriptor& connected);

/** One refusal for a whole search: the paths tried, why each failed, and the last one's remedy, else how to start a
 * daemon. */
Failure nobodyAnswers(const std::vector<std::string>& paths, const std::vector<Failure>& why);

}  // namespace hapticd::client
