/** @file
 * A descriptor that the daemon hands out.
 */
#pragma once

#include "libclient/src/connection/connection.h"

namespace hapticd::client {

/** Why a descriptor that the daemon always sends is not there: the kernel drops it where the program may have no more.
 */
[[nodiscard]] Failure noDescriptor(const char* what);
/** Keeps a copy in `fd`, for the caller to close; or says in `refusal` why there is none. Library's thread. */
kj::Promise<void> keepDescriptor(proto::Region::Client region, const char* what, int& fd, Failure& refusal);

}  // namespace hapticd::client
