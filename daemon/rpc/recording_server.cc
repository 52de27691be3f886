#include <fmt/format.h>

#include "daemon/rpc/servers.h"

namespace hapticd {

kj::Promise<void> RecordingServer::stream(StreamContext context) {
  return answer(context, [&](auto, auto results) -> Result<void> {
    if (!stream_.valid()) {
      return Error{ErrorCode::kInvalidArgument, "stream", "it was handed out before", "start another recording"};
    }
    auto region = RegionServer::handOut(core_, uid_, duplicate(stream_.get()));
    if (!region) return region.error();
    results.setStream(std::move(*region));
    stream_.reset();  // Else the recorder would not see that the reader has gone.
    return {};
  });
}

kj::Promise<void> RecordingServer::stop(StopContext context) {
  return answerLater(context, [&](auto, auto later) -> Result<void> {
    core_.recordings().stop(id_, [later](const RecordingEnd& end) {
      later->answer([&](auto results) -> Result<void> {
        results.setReason(end.reason.c_str());
        results.setCycles(end.cycles);
        results.setLost(end.lost);
        return {};
      });
    });
    return {};
  });
}

}  // namespace hapticd
