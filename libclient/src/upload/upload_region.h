/** @file
 * The daemon's memory for an upload, as the client fills it.
 */
#pragma once

#include <functional>

#include "libclient/src/connection/connection.h"
#include "libclient/src/session/mapping.h"

namespace hapticd::client {

/** Begins an upload of `bytes` and maps it writable. The capability is the library's thread's to destroy. */
Failure openUpload(Connection& connection, std::size_t bytes, proto::Upload::Client& capability, Mapping& mapping);

/**
 * Commits what has been unmapped. The kernel says "still mapped" also while it holds a page for itself for a moment
 * (migration, write-back, a page on its way to an LRU list), so that answer is asked for a few times, for 75 ms in all.
 */
Failure commitPatiently(const std::function<Failure()>& commit);

}  // namespace hapticd::client
