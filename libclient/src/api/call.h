/** @file
 * What most calls of the C interface are: a question to the daemon, answered by a status alone or with a result.
 */
#pragma once

#include <utility>

#include "libclient/src/connection/connection.h"
#include "libclient/src/reply/reply.h"

namespace hapticd::client {

/** A text that the caller may leave out. */
inline const char* orEmpty(const char* text) noexcept { return text == nullptr ? "" : text; }

/** Refuses an argument before anything is asked. */
inline int refuse(haptic_error* error, const char* where, const char* what) noexcept {
  return edge(error, [&] { return badArgument(where, what); });
}

/** Asks what is answered by a status alone. `make` gives the request. */
template <class Make>
int order(haptic_client* c, haptic_error* error, Make&& make) {
  return edge(error, [&]() -> Failure {
    if (c == nullptr) return badArgument("client", "is null");
    return callDaemon(*c->connection, std::forward<Make>(make));
  });
}

/** Asks for a result that the caller keeps: `use` makes it from the answer. */
template <class Out, class Make, class Use>
int query(haptic_client* c, Out** out, haptic_error* error, Make&& make, Use&& use) {
  return edge(error, [&]() -> Failure {
    if (c == nullptr) return badArgument("client", "is null");
    if (out == nullptr) return badArgument("result", "is null");
    Reply memory;
    Out* made = nullptr;
    const auto keep = [&](auto& results) { made = use(results, memory); };
    if (Failure failure = callDaemon(*c->connection, std::forward<Make>(make), keep)) return failure;
    *out = memory.release(made);
    return {};
  });
}

/** The same where the caller may not want the result. */
template <class Out, class Make, class Use>
int queryIfWanted(haptic_client* c, Out** out, haptic_error* error, Make&& make, Use&& use) {
  Out* unwanted = nullptr;
  const int code = query(c, out == nullptr ? &unwanted : out, error, std::forward<Make>(make), std::forward<Use>(use));
  Reply::free(unwanted);
  return code;
}

}  // namespace hapticd::client
