#include "daemon/rpc/servers.h"

namespace hapticd {

kj::Promise<void> SessionServer::regions(RegionsContext context) {
  return answer(context, [&](auto, auto results) -> Result<void> {
    const Session* session = core_.sessions().find(id_);
    if (session == nullptr) return Error{ErrorCode::kTimeout, "session", "the session has ended", "open a new session"};
    if (session->state != Session::State::kOffered) {
      return Error{ErrorCode::kInvalidArgument, "session", "its regions are mapped and sealed", "open a new session"};
    }
    auto a = RegionServer::handOut(core_, session->client.uid, session->regions.fileA().share());
    if (!a) return a.error();
    auto b = RegionServer::handOut(core_, session->client.uid, session->regions.fileB().share());
    if (!b) return b.error();
    results.setA(std::move(*a));
    results.setB(std::move(*b));
    return {};
  });
}

kj::Promise<void> SessionServer::mapped(MappedContext context) {
  return answer(context, [&](auto, auto) { return core_.sessions().mapped(id_); });
}

kj::Promise<void> SessionServer::acquireLease(AcquireLeaseContext context) {
  return answer(context, [&](auto, auto) { return core_.acquireLease(id_); });
}

kj::Promise<void> SessionServer::releaseLease(ReleaseLeaseContext context) {
  return answerAfter(context, [&](auto) { return core_.releaseLease(id_); });
}

kj::Promise<void> SessionServer::arm(ArmContext context) {
  return answerLater(context, [&](auto, auto later) -> Result<void> {
    core_.arm(id_, [later](const Result<void>& result) { later->done(result); });
    return {};
  });
}

kj::Promise<void> SessionServer::disarm(DisarmContext context) {
  return answerAfter(context, [&](auto) { return core_.disarm(id_); });
}

}  // namespace hapticd
