/** @file
 * How time passes for a played device whose I/O thread is stepped by hand.
 */
#pragma once

#include <algorithm>

#include "drivers/link/io_device.h"
#include "rt/base/clock.h"

namespace hapticd::test {

/** Four times a millisecond: `move` the hand, then the I/O thread works, then the world goes on by `pass`. */
template <class Move, class Pass>
void playWorld(std::int64_t ns, ManualClock& clock, IoDevice& device, Move&& move, Pass&& pass) {
  const std::int64_t until_ns = clock.now() + ns;
  while (clock.now() < until_ns) {
    move();
    const std::int64_t step_ns = std::min<std::int64_t>(until_ns, clock.now() + 250'000);
    device.pump(step_ns);
    clock.sleepUntil(step_ns);
    pass();
  }
}

/** The same where the world is a played device's model. */
template <class Model, class Move>
void play(std::int64_t ns, ManualClock& clock, IoDevice& device, Model& model, Move&& move) {
  playWorld(ns, clock, device, move, [&] { model.advance(clock.now()); });
}

}  // namespace hapticd::test
