/** @file
 * For devices without a cable.
 */
#pragma once

namespace hapticd {

/** A Device that knows of its battery. */
class HasBattery {
 public:
  virtual ~HasBattery() = default;
  /** 0 to 100; -1 while it has not told, or has none. Any thread. */
  [[nodiscard]] virtual int batteryPercent() const noexcept = 0;
};

}  // namespace hapticd
