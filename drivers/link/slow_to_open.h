/** @file
 * For devices whose open() may take seconds: firmware to load, a vendor's library to start.
 */
#pragma once

namespace hapticd {

/** A Device that can be told, by another thread, that nobody waits for its open() any more. */
class SlowToOpen {
 public:
  virtual ~SlowToOpen() = default;
  /** open() returns soon with an error, also one that begins only now. For good. */
  virtual void giveUp() noexcept = 0;
};

}  // namespace hapticd
