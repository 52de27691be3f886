/** @file
 * What a connection gets that comes beyond its user's number, or that of all: who wants to stop a device finds a way.
 */
#pragma once

#include "daemon/rpc/servers.h"

namespace hapticd {

/** Lists devices and stops them; all else is refused as over the quota. */
class StopOnlyServer final : public DaemonServer {
 public:
  StopOnlyServer(Core& core, std::uint64_t connection) : DaemonServer(core, connection) {}

  DispatchCallResult dispatchCall(std::uint64_t interface, std::uint16_t method,
                                  capnp::CallContext<capnp::AnyPointer, capnp::AnyPointer> context) override;

 protected:
  /** Clients ask for it as they greet. It refuses everything. */
  kj::Promise<void> scene(SceneContext context) override;
};

}  // namespace hapticd
