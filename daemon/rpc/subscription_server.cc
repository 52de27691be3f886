#include "daemon/log/log.h"
#include "daemon/rpc/servers.h"

namespace hapticd {

SubscriptionServer::SubscriptionServer(Core& core, const Clients::Subscriber& by, proto::EventListener::Client listener,
                                       std::uint32_t kinds)
    : core_(core),
      by_(by),
      listener_(kj::mv(listener)),
      tasks_(*this),
      id_(core.events().subscribe(kinds, [this] { wake(); })) {}

void SubscriptionServer::wake() {
  if (pumping_) return;
  // Later: whoever publishes is in the middle of something, and the next events then share a call.
  tasks_.add(kj::evalLater([this] { return pump(); }));
  pumping_ = true;  // Only now: there may be no memory for it.
}

kj::Promise<void> SubscriptionServer::pump() {
  EventHub::Batch batch;
  try {
    batch = core_.events().take(id_);
    if (batch.events.empty()) {
      pumping_ = false;
      return kj::READY_NOW;
    }
    auto request = listener_.eventsRequest();
    request.setLost(batch.lost);
    auto list = request.initEvents(static_cast<unsigned>(batch.events.size()));
    for (unsigned i = 0; i < batch.events.size(); ++i) write(list[i], batch.events[i]);
    return request.send().ignoreResult().then([this] { return pump(); });
  } catch (const std::exception&) {  // No memory, which kj tells by its own. These are lost, but whoever listens hears
                                     // of the next.
    pumping_ = false;
    core_.events().notTold(id_, batch.events.size() + batch.lost);
    return kj::READY_NOW;
  }
}

void SubscriptionServer::taskFailed(kj::Exception&& exception) {
  log::debug("a subscriber is dropped: {}", log::printable(exception.getDescription().cStr()));
  core_.events().unsubscribe(id_);
}

}  // namespace hapticd
