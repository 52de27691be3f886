/** @file
 * A client's messages, with a bound on the questions it leaves open.
 */
#pragma once

#include <capnp/serialize-async.h>

#include <cstdint>
#include <functional>
#include <unordered_set>

namespace hapticd {

/**
 * Cap'n Proto keeps an answer until the client says Finish, and bounds only those that are still being worked on. A
 * client that never says it is cut off at its (kMostOpen + 1)th: to read no further would keep its Finish away, too.
 */
class QuestionLimit final : public capnp::MessageStream {
 public:
  static constexpr std::size_t kMostOpen = 4096;  ///< A program may ask that often before it reads the first answer.

  /** `exceeded` is called once, before the connection fails. */
  QuestionLimit(kj::AsyncCapabilityStream& stream, std::function<void()> exceeded)
      : stream_(stream), exceeded_(std::move(exceeded)) {}

  kj::Promise<kj::Maybe<capnp::MessageReaderAndFds>> tryReadMessage(kj::ArrayPtr<kj::AutoCloseFd> fds,
                                                                    capnp::ReaderOptions options,
                                                                    kj::ArrayPtr<capnp::word> scratch) override;
  kj::Promise<void> writeMessage(kj::ArrayPtr<const int> fds,
                                 kj::ArrayPtr<const kj::ArrayPtr<const capnp::word>> segments) override {
    return stream_.writeMessage(fds, segments);
  }
  kj::Promise<void> writeMessages(kj::ArrayPtr<kj::ArrayPtr<const kj::ArrayPtr<const capnp::word>>> messages) override {
    return stream_.writeMessages(messages);
  }
  kj::Maybe<int> getSendBufferSize() override { return stream_.getSendBufferSize(); }
  kj::Promise<void> end() override { return stream_.end(); }

 private:
  void note(capnp::MessageReader& message);

  capnp::AsyncCapabilityMessageStream stream_;
  std::function<void()> exceeded_;
  std::unordered_set<std::uint32_t>
      open_;  ///< By their numbers: a Finish of none, or a second one, takes no other off.
};

}  // namespace hapticd
