#include "libclient/src/connection/descriptor.h"

#include <fcntl.h>

#include <cerrno>
#include <cstring>

namespace hapticd::client {

Failure noDescriptor(const char* what) {
  return {HAPTIC_SYSTEM, what, "its descriptor did not come: this program may have no more", kFewerDescriptors};
}

kj::Promise<void> keepDescriptor(proto::Region::Client region, const char* what, int& fd, Failure& refusal) {
  auto promise = region.getFd();
  return promise.then([&, what, keep = kj::mv(region)](kj::Maybe<int> received) {
    KJ_IF_MAYBE (descriptor, received) {
      fd = ::fcntl(*descriptor, F_DUPFD_CLOEXEC, 0);
      if (fd < 0) refusal = {HAPTIC_SYSTEM, what, std::strerror(errno), kFewerDescriptors};
    } else {
      refusal = noDescriptor(what);
    }
  });
}

}  // namespace hapticd::client
