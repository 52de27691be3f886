#include "libclient/src/upload/upload_region.h"

#include <unistd.h>

#include <chrono>
#include <thread>

#include "libclient/src/connection/descriptor.h"

namespace hapticd::client {

Failure openUpload(Connection& connection, std::size_t bytes, proto::Upload::Client& capability, Mapping& mapping) {
  int fd = -1;
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
            return keepDescriptor(results.getRegion(), "upload", fd, refusal);
          });
        });
  });
  // On the caller's thread: the pages of a large mesh take longer than a session may be without a heartbeat.
  if (!broken && !refusal) refusal = Mapping::map(fd, bytes, true, "upload", mapping);
  if (fd >= 0) ::close(fd);
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
