#include "daemon/rpc/answered_stream.h"

#include <utility>

namespace hapticd {

kj::Promise<void> AnsweredStream::written() {
  if (writing_ == 0) return kj::READY_NOW;
  auto paf = kj::newPromiseAndFulfiller<void>();
  waiting_.push_back(kj::mv(paf.fulfiller));
  return kj::mv(paf.promise);
}

kj::Promise<void> AnsweredStream::counted(kj::Promise<void> write) {
  ++writing_;
  auto gone = kj::defer([this] {
    if (--writing_ != 0) return;
    for (auto& reader : std::exchange(waiting_, {})) reader->fulfill();
  });
  return write.attach(kj::mv(gone)).eagerlyEvaluate(nullptr);  // In this order: it is told once it is so.
}

kj::Promise<std::size_t> AnsweredStream::tryRead(void* to, std::size_t least, std::size_t most) {
  return written().then([this, to, least, most] { return stream_->tryRead(to, least, most); });
}

kj::Promise<AnsweredStream::ReadResult> AnsweredStream::tryReadWithFds(void* to, std::size_t least, std::size_t most,
                                                                       kj::AutoCloseFd* fds, std::size_t most_fds) {
  return written().then(
      [this, to, least, most, fds, most_fds] { return stream_->tryReadWithFds(to, least, most, fds, most_fds); });
}

kj::Promise<AnsweredStream::ReadResult> AnsweredStream::tryReadWithStreams(void* to, std::size_t least,
                                                                           std::size_t most,
                                                                           kj::Own<kj::AsyncCapabilityStream>* streams,
                                                                           std::size_t most_streams) {
  return written().then([this, to, least, most, streams, most_streams] {
    return stream_->tryReadWithStreams(to, least, most, streams, most_streams);
  });
}

kj::Promise<void> AnsweredStream::write(const void* from, std::size_t size) {
  return counted(stream_->write(from, size));
}

kj::Promise<void> AnsweredStream::write(kj::ArrayPtr<const kj::ArrayPtr<const kj::byte>> pieces) {
  return counted(stream_->write(pieces));
}

kj::Promise<void> AnsweredStream::writeWithFds(kj::ArrayPtr<const kj::byte> data,
                                               kj::ArrayPtr<const kj::ArrayPtr<const kj::byte>> more,
                                               kj::ArrayPtr<const int> fds) {
  return counted(stream_->writeWithFds(data, more, fds));
}

kj::Promise<void> AnsweredStream::writeWithStreams(kj::ArrayPtr<const kj::byte> data,
                                                   kj::ArrayPtr<const kj::ArrayPtr<const kj::byte>> more,
                                                   kj::Array<kj::Own<kj::AsyncCapabilityStream>> streams) {
  return counted(stream_->writeWithStreams(data, more, kj::mv(streams)));
}

}  // namespace hapticd
