/** @file
 * A client's stream that takes no more requests while answers wait for their reader.
 */
#pragma once

#include <kj/async-io.h>

#include <vector>

namespace hapticd {

/**
 * Reads nothing as long as something that was written has not gone out. Else a client that sends requests and reads no
 * answers would have the daemon keep them all: the flow limit of Cap'n Proto ends with the answer, not with its
 * reading.
 */
class AnsweredStream final : public kj::AsyncCapabilityStream {
 public:
  explicit AnsweredStream(kj::Own<kj::AsyncCapabilityStream> stream) : stream_(kj::mv(stream)) {}

  kj::Promise<std::size_t> tryRead(void* to, std::size_t least, std::size_t most) override;
  kj::Promise<ReadResult> tryReadWithFds(void* to, std::size_t least, std::size_t most, kj::AutoCloseFd* fds,
                                         std::size_t most_fds) override;
  kj::Promise<ReadResult> tryReadWithStreams(void* to, std::size_t least, std::size_t most,
                                             kj::Own<kj::AsyncCapabilityStream>* streams,
                                             std::size_t most_streams) override;
  kj::Promise<void> write(const void* from, std::size_t size) override;
  kj::Promise<void> write(kj::ArrayPtr<const kj::ArrayPtr<const kj::byte>> pieces) override;
  kj::Promise<void> writeWithFds(kj::ArrayPtr<const kj::byte> data,
                                 kj::ArrayPtr<const kj::ArrayPtr<const kj::byte>> more,
                                 kj::ArrayPtr<const int> fds) override;
  kj::Promise<void> writeWithStreams(kj::ArrayPtr<const kj::byte> data,
                                     kj::ArrayPtr<const kj::ArrayPtr<const kj::byte>> more,
                                     kj::Array<kj::Own<kj::AsyncCapabilityStream>> streams) override;
  kj::Promise<void> whenWriteDisconnected() override { return stream_->whenWriteDisconnected(); }
  void shutdownWrite() override { stream_->shutdownWrite(); }
  void abortRead() override { stream_->abortRead(); }
  void getsockopt(int level, int option, void* value, kj::uint* length) override {
    stream_->getsockopt(level, option, value, length);
  }
  void setsockopt(int level, int option, const void* value, kj::uint length) override {
    stream_->setsockopt(level, option, value, length);
  }
  kj::Maybe<int> getFd() const override { return stream_->getFd(); }

 private:
  /** Done when all that was written has gone out, or cannot any more. */
  kj::Promise<void> written();
  kj::Promise<void> counted(kj::Promise<void> write);

  kj::Own<kj::AsyncCapabilityStream> stream_;
  int writing_ = 0;
  std::vector<kj::Own<kj::PromiseFulfiller<void>>> waiting_;
};

}  // namespace hapticd
