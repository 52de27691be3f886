/** @file
 * The builder's loop: jobs in, snapshots out, until the daemon closes the socket.
 */
#pragma once

namespace hapticd {

/** Returns the process's exit status: 0 when the daemon is gone, 1 on a protocol violation. */
[[nodiscard]] int serveBuilds(int socket);

}  // namespace hapticd
