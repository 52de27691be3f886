/** @file
 * The daemon's memory for an upload, as the client fills it.
 */
#pragma once

#include "libclient/src/connection.h"
#include "libclient/src/mapping.h"

namespace hapticd::client {

/** Begins an upload of `bytes` and maps it writable. The capability is the library's thread's to destroy. */
Failure openUpload(Connection& connection, std::size_t bytes, proto::Upload::Client& capability, Mapping& mapping);

}  // namespace hapticd::client
