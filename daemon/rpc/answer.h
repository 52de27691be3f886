/** @file
 * How a method answers: every refusal becomes a Status, no exception crosses to the client.
 */
#pragma once

#include <kj/async.h>
#include <kj/exception.h>

#include <exception>
#include <memory>
#include <new>

#include "daemon/rpc/convert.h"

namespace hapticd {

/** Logs a defect and words it for the client, without its text. */
[[nodiscard]] Error defect(const char* text) noexcept;

/** What to say where there was no memory. Does without any itself, if need be. */
[[nodiscard]] Error outOfMemory() noexcept;

/** What Cap'n Proto or KJ has thrown: what it cannot read in a client's message is the client's, all else a defect. */
[[nodiscard]] Error thrown(const kj::Exception& e) noexcept;

/** The result of `body`; kSystem for want of memory, else as of what it throws. */
template <class Body>
[[nodiscard]] Result<void> caught(Body&& body) noexcept {
  try {
    return body();
  } catch (const kj::Exception& e) {
    return thrown(e);
  } catch (const std::bad_alloc&) {
    return outOfMemory();
  } catch (const std::exception& e) {
    return defect(e.what());
  } catch (...) {
    return defect("an unknown exception");
  }
}

/** Runs `body(params, results)`, which returns Result<void>, and sets the status of the answer. */
template <class Context, class Body>
kj::Promise<void> answer(Context context, Body&& body) {
  const Result<void> result = caught([&] { return body(context.getParams(), context.getResults()); });
  setStatus(context.getResults().initStatus(), result);
  return kj::READY_NOW;
}

/** An answer that comes later: done(result) once; nothing happens when the caller has gone meanwhile. */
template <class Context>
class LaterAnswer {
 public:
  LaterAnswer(Context context, kj::Own<kj::PromiseFulfiller<void>> fulfiller)
      : context_(context), fulfiller_(kj::mv(fulfiller)) {}
  [[nodiscard]] bool waiting() { return fulfiller_->isWaiting(); }
  void done(const Result<void>& result) {
    if (!fulfiller_->isWaiting()) return;
    setStatus(context_.getResults().initStatus(), result);
    fulfiller_->fulfill();
  }
  /** As answer() does it. */
  template <class Body>
  void answer(Body&& body) {
    if (fulfiller_->isWaiting()) done(caught([&] { return body(context_.getResults()); }));
  }

 private:
  Context context_;
  kj::Own<kj::PromiseFulfiller<void>> fulfiller_;
};

/** `ask(params, later)` hands on the LaterAnswer, a shared pointer to it, or returns why there is nothing to wait for.
 */
template <class Context, class Ask>
kj::Promise<void> answerLater(Context context, Ask&& ask) {
  auto paf = kj::newPromiseAndFulfiller<void>();
  auto later = std::make_shared<LaterAnswer<Context>>(context, kj::mv(paf.fulfiller));
  const Result<void> asked = caught([&]() -> Result<void> { return ask(context.getParams(), later); });
  if (!asked) later->done(asked);
  return kj::mv(paf.promise);
}

}  // namespace hapticd
