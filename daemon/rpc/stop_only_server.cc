#include "daemon/rpc/stop_only_server.h"

#include <algorithm>

namespace hapticd {
namespace {

using Context = capnp::CallContext<capnp::AnyPointer, capnp::AnyPointer>;
using Dispatched = capnp::Capability::Server::DispatchCallResult;

/** Their numbers in control.capnp: hello, listDevices, scene, stop. */
constexpr std::uint16_t kServed[] = {0, 1, 5, 11};

/** Each method's results begin with the status. */
Dispatched refuse(Context context) {
  const Error error{ErrorCode::kQuotaExceeded, "connection",
                    "this user, or all together, have as many as there may be: this one may stop devices and no more",
                    "close some"};
  context.releaseParams();
  setStatus(context.getResults().initAs<proto::Daemon::StopResults>().initStatus(), error);
  return {kj::READY_NOW, false};
}

class NoScene final : public proto::Scene::Server {
 public:
  DispatchCallResult dispatchCall(std::uint64_t /*interface*/, std::uint16_t /*method*/, Context context) override {
    return refuse(context);
  }
};

}  // namespace

Dispatched StopOnlyServer::dispatchCall(std::uint64_t interface, std::uint16_t method, Context context) {
  if (std::find(std::begin(kServed), std::end(kServed), method) == std::end(kServed)) return refuse(context);
  return DaemonServer::dispatchCall(interface, method, context);
}

kj::Promise<void> StopOnlyServer::scene(SceneContext context) {
  return answer(context, [](auto, auto results) -> Result<void> {
    results.setScene(kj::heap<NoScene>());
    return {};
  });
}

}  // namespace hapticd
