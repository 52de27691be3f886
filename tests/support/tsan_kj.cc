// Tells the thread sanitizer of the locks inside Debian's libkj, which is not built with it: whoever lets go of a
// kj::Mutex happens before whoever gets it next. All hand-overs between KJ's loops go through such a lock, so no report
// needs to be suppressed. Linked into a test program, these stand before libkj's own, which do the work.
#include <dlfcn.h>
#include <kj/mutex.h>
#include <sanitizer/tsan_interface.h>

#include <cstdlib>

namespace {

/** The function of that mangled name in the libraries after this program. */
template <class Function>
Function next(const char* name) {
  void* const found = dlsym(RTLD_NEXT, name);
  if (found == nullptr) std::abort();  // another libkj: its names have changed
  return reinterpret_cast<Function>(found);
}

}  // namespace

namespace kj::_ {

bool Mutex::lock(Exclusivity exclusivity, Maybe<Duration> timeout, LockSourceLocationArg location) {
  using Lock = bool (*)(Mutex*, Exclusivity, Maybe<Duration>, LockSourceLocationArg);
  static const auto kReal = next<Lock>(
      "_ZN2kj1_5Mutex4lockENS1_11ExclusivityENS_5MaybeINS_8QuantityIlNS0_15NanosecondLabelEEEEENS_"
      "18NoopSourceLocationE");
  const bool locked = kReal(this, exclusivity, timeout, location);
  if (locked) __tsan_acquire(this);
  return locked;
}

void Mutex::unlock(Exclusivity exclusivity, Waiter* waiter_to_skip) {
  using Unlock = void (*)(Mutex*, Exclusivity, Waiter*);
  static const auto kReal = next<Unlock>("_ZN2kj1_5Mutex6unlockENS1_11ExclusivityEPNS1_6WaiterE");
  __tsan_release(this);
  kReal(this, exclusivity, waiter_to_skip);
}

void Mutex::wait(Predicate& predicate, Maybe<Duration> timeout, LockSourceLocationArg location) {
  using Wait = void (*)(Mutex*, Predicate&, Maybe<Duration>, LockSourceLocationArg);
  static const auto kReal = next<Wait>(
      "_ZN2kj1_5Mutex4waitERNS1_9PredicateENS_5MaybeINS_8QuantityIlNS0_15NanosecondLabelEEEEENS_18NoopSourceLocationE");
  __tsan_release(this);  // it is let go within, and taken again
  kReal(this, predicate, timeout, location);
  __tsan_acquire(this);
}

}  // namespace kj::_
