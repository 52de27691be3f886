/** @file
 * Where the stack lies, varied on purpose.
 */
#pragma once

namespace haptic_bench {

/**
 * Calls `what` with the stack some 300 bytes deeper for each of `steps`; a dozen are a page. How the stack lies to
 * other memory within the pages decides up to 4 % of a tick; the kernel draws it anew for each process, so that what
 * stays the same in all rounds of one would be taken for a change by whoever compares two.
 */
template <class What>
[[gnu::noinline]] void withDeeperStack(int steps, What&& what) {
  volatile char frame[288];
  frame[0] = 0;
  if (steps > 0) {
    withDeeperStack(steps - 1, what);
  } else {
    what();
  }
  frame[1] = frame[0];  // Not a tail call: the frame stays.
}

}  // namespace haptic_bench
