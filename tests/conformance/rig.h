/** @file
 * The conformance suite: what any driver must do, run against each. A driver joins by a Rig, its device together with
 * the played hardware behind it, and one line in rigs.cc.
 */
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

#include "rt/device.h"
#include "tests/support/stepped/push.h"

namespace hapticd::test {

/** Troubles on the wire that a rig may be able to make. */
enum class Trouble : std::uint8_t { kSilence, kGarbage, kTruncation, kEncoderJump };

/**
 * A device and the world behind it, in virtual time. Everything is SI and in the frame of hapticd; `true` means
 * measured in the world, past the driver.
 */
class Rig {
 public:
  virtual ~Rig() = default;

  [[nodiscard]] virtual Device& device() = 0;
  [[nodiscard]] virtual std::int64_t now() const = 0;
  /** World, wire and I/O thread go on. The servo does not: the suite is the servo. */
  virtual void advance(std::int64_t ns) = 0;

  /** Opens, and does what a user must do before it can be armed (homing). */
  virtual void makeReady() = 0;
  /** The grip goes there, within 60 ms, and is held. A place within the workspace. */
  virtual void hold(const Vec3& p) = 0;
  [[nodiscard]] virtual Vec3 truePosition() const = 0;
  /** What the motors push with now. */
  [[nodiscard]] virtual Vec3 trueForce() const = 0;

  /** What the driver may be off by: sensing, counting, rounding of its own. */
  [[nodiscard]] virtual double positionTolerance() const = 0;
  [[nodiscard]] virtual double forceTolerance() const = 0;
  /** From a command to the motors, and from the world to a reading: at most so long. */
  [[nodiscard]] virtual std::int64_t mostDelay_ns() const = 0;
  /** Fresh readings a second of a servo at 1 kHz, at least. */
  [[nodiscard]] virtual double leastRate_hz() const { return 900; }

  // Asked of devices behind a wire only.
  virtual void unplug() {}
  virtual void plugIn() {}
  /** What its user does after it was plugged in again. */
  virtual void makeReadyAgain() {}
  /** From now on, or no more. */
  virtual void trouble(Trouble, bool) {}
  /** Bytes that went wrong and readings that were refused, as the driver counts them. */
  [[nodiscard]] virtual std::uint64_t complaints() const { return 0; }
};

/** A driver in the suite. */
struct RigCase {
  std::string name;
  std::function<std::unique_ptr<Rig>()> make;
  bool wire = true;  ///< Behind one that can be pulled or disturbed; a simulator is not.
};
inline void PrintTo(const RigCase& rig, std::ostream* out) { *out << rig.name; }

/** Every driver that joins, and those behind a wire; see rigs.cc. */
[[nodiscard]] std::vector<RigCase> rigCases();
[[nodiscard]] std::vector<RigCase> wireCases();

}  // namespace hapticd::test
