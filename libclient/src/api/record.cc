// record.h: recordings.
#include <hapticclient/record.h>
#include <unistd.h>

#include <utility>

#include "libclient/src/api/call.h"
#include "libclient/src/connection/descriptor.h"
#include "libclient/src/connection/loop.h"

using hapticd::client::Connection;
using hapticd::client::Failure;
using hapticd::client::Link;
using hapticd::client::Reply;
namespace client = hapticd::client;
namespace proto = hapticd::proto;

/** The handle of record.h. */
struct haptic_recording {
  explicit haptic_recording(std::shared_ptr<Connection> to)
      : connection(std::move(to)), link(connection->linkNumber()) {}
  ~haptic_recording() {
    connection->run([this](Connection::Loop&) { capability = nullptr; });
    if (fd >= 0) ::close(fd);
  }

  std::shared_ptr<Connection> connection;
  const std::uint64_t link;                       ///< Over which it was started.
  proto::Recording::Client capability = nullptr;  ///< Library's thread.
  int fd = -1;
};

namespace {

/** Asks for the stream and keeps a descriptor of it. */
kj::Promise<void> takeStream(haptic_recording& recording, Failure& refusal) {
  return recording.capability.streamRequest().send().then([&](auto&& results) -> kj::Promise<void> {
    refusal = client::toFailure(results.getStatus());
    if (refusal) return kj::READY_NOW;
    return client::keepDescriptor(results.getStream(), "stream", recording.fd, refusal);
  });
}

}  // namespace

extern "C" {

int haptic_recording_start(haptic_client* c, const char* uri, haptic_recording** recording, haptic_error* error) {
  return client::edge(error, [&]() -> Failure {
    if (c == nullptr) return client::badArgument("client", "is null");
    if (recording == nullptr) return client::badArgument("recording", "is null");
    auto made = std::make_unique<haptic_recording>(c->connection);
    Failure refusal;
    Failure broken = c->connection->call([&](Link& link) {
      auto request = link.daemon.recordRequest();
      request.setUri(client::orEmpty(uri));
      return client::ask(kj::mv(request), refusal, [&](auto& results) { made->capability = results.getRecording(); })
          .then([&]() -> kj::Promise<void> {
            if (refusal) return kj::READY_NOW;
            return takeStream(*made, refusal);
          });
    });
    if (broken) return broken;
    if (refusal) return refusal;
    *recording = made.release();
    return {};
  });
}

int haptic_recording_fd(const haptic_recording* recording) { return recording == nullptr ? -1 : recording->fd; }

int haptic_recording_stop(haptic_recording* recording, haptic_recording_end** end, haptic_error* error) {
  return client::edge(error, [&]() -> Failure {
    if (recording == nullptr) return client::badArgument("recording", "is null");
    Connection& connection = *recording->connection;
    if (Failure failure = connection.unreachable()) return failure;
    if (recording->link != connection.linkNumber()) return client::begunBefore("recording", "start another");
    Reply memory;
    auto* made = memory.make<haptic_recording_end>();
    Failure failure = client::callDaemon(
        connection, [&](Link&) { return recording->capability.stopRequest(); },
        [&](auto& results) {
          made->cycles = results.getCycles();
          made->lost = results.getLost();
          made->reason = memory.text(results.getReason().cStr());
        });
    if (failure) return failure;
    if (end != nullptr) *end = memory.release(made);
    return {};
  });
}

void haptic_recording_close(haptic_recording* recording) {
  if (recording == nullptr) return;
  if (recording->connection->ownProcess()) {
    delete recording;
  } else if (recording->fd >= 0) {
    ::close(std::exchange(recording->fd, -1));  // this process's own; the capability is of a thread of the parent
  }
}

}  // extern "C"
