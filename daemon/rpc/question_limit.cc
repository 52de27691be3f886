#include "daemon/rpc/question_limit.h"

#include <capnp/rpc.capnp.h>
#include <kj/exception.h>

namespace hapticd {

kj::Promise<kj::Maybe<capnp::MessageReaderAndFds>> QuestionLimit::tryReadMessage(kj::ArrayPtr<kj::AutoCloseFd> fds,
                                                                                 capnp::ReaderOptions options,
                                                                                 kj::ArrayPtr<capnp::word> scratch) {
  return stream_.tryReadMessage(fds, options, scratch).then([this](kj::Maybe<capnp::MessageReaderAndFds> message) {
    KJ_IF_MAYBE (m, message) {
      note(*m->reader);
    }
    return message;
  });
}

void QuestionLimit::note(capnp::MessageReader& message) {
  const auto root = message.getRoot<capnp::rpc::Message>();
  switch (root.which()) {
    case capnp::rpc::Message::BOOTSTRAP:
      open_.insert(root.getBootstrap().getQuestionId());
      break;
    case capnp::rpc::Message::CALL:
      open_.insert(root.getCall().getQuestionId());
      break;
    case capnp::rpc::Message::FINISH:
      open_.erase(root.getFinish().getQuestionId());
      break;
    default:
      break;
  }
  if (open_.size() <= kMostOpen) return;
  exceeded_();
  kj::throwFatalException(kj::Exception(kj::Exception::Type::OVERLOADED, "", 0,
                                        kj::str("more than ", kMostOpen, " answers are held: send Finish")));
}

}  // namespace hapticd
