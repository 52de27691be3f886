#include "libclient/src/upload_region.h"

#include <chrono>
#include <thread>

namespace hapticd::client {

Failure openUpload(Connection& connection, std::size_t bytes, proto::Upload::Client& capability, Mapping& mapping) {
  Failure refusal;
  Failure broken = connection.call([&](Link& link) {
    auto request = link.scene.beginUploadRequest();
    request.setBytes(bytes);
    return ask(kj::mv(request), refusal, [&](auto& results) { capability = results.getUpload(); })
        .then([&]() -> kj::Promise<void> {
          if (refusal) return kj::READY_NOW;
          return capability.regionRequest().send().then([&](auto&& results) -> kj::Promise<void> {
            refusal = toFailure(results.getStatus());
            if (refusal) return kj::READY_NOW;
            proto::Region::Client region = results.getRegion();
            auto fd = region.getFd();
            return fd.then([&, keep = kj::mv(region)](kj::Maybe<int> received) {
              KJ_IF_MAYBE (descriptor, received) {
                refusal = Mapping::map(*descriptor, bytes, true, "upload", mapping);
              } else {
                refusal = {HAPTIC_INTERNAL, "upload", "the daemon sent no descriptor", {}};
              }
            });
          });
        });
  });
  return broken ? std::move(broken) : std::move(refusal);
}

Failure commitPatiently(const std::function<Failure()>& commit) {
  for (std::chrono::milliseconds pause(5);; pause *= 2) {
    Failure failure = commit();
    if (failure.code != HAPTIC_STILL_MAPPED || pause > std::chrono::milliseconds(40)) return failure;
    std::this_thread::sleep_for(pause);
  }
}

}  // namespace hapticd::client
