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
  kj::Promise<void> done = kj::READY_NOW;  // First: what is done for want of nothing is told so.
  const Result<void> result = caught([&] { return body(context.getParams(), context.getResults()); });
  setStatus(context.getResults().initStatus(), result);
  return done;
}

/** As answer(), with `body(params)`, which comes before all that the answer needs memory for: what makes safe. */
template <class Context, class Body>
kj::Promise<void> answerAfter(Context context, Body&& body) {
  const Result<void> result = caught([&] { return body(context.getParams()); });
  setStatus(context.getResults().initStatus(), result);
  return kj::READY_NOW;
}

/** An answer that comes later: done(result) once; nothing happens when the caller has gone meanwhile. */
template <class Context>
class LaterAnswer {
 public:
  explicit LaterAnswer(Context context) : context_(context) { (void)context_.getResults(); }  // Now it can be refused.
  /** Whoever should have answered had no memory to: so the caller hears. */
  ~LaterAnswer() {
    if (fulfiller_.get() != nullptr) done(Error{ErrorCode::kSystem, "memory", {}, {}});
  }
  LaterAnswer(const LaterAnswer&) = delete;
  LaterAnswer& operator=(const LaterAnswer&) = delete;

  /** Before anything else. */
  [[nodiscard]] kj::Promise<void> promise() {
    auto paf = kj::newPromiseAndFulfiller<void>();
    fulfiller_ = kj::mv(paf.fulfiller);
    return kj::mv(paf.promise);
  }
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
  auto later = std::make_shared<LaterAnswer<Context>>(context);
  auto promise = later->promise();
  const Result<void> asked = caught([&]() -> Result<void> { return ask(context.getParams(), later); });
  if (!asked) later->done(asked);
  return promise;
}

}  // namespace hapticd
