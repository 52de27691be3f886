/** @file
 * Collision libraries to compare with. Only haptic-bench links them, each in a file of its own.
 */
#pragma once

#include <cstdint>
#include <memory>

#include "rt/base/math.h"
#include "tools/haptic-bench/model/model.h"

namespace haptic_bench {

/** One pair of solids in a library's own form. */
class Peer {
 public:
  virtual ~Peer() = default;
  /** Whether they touch, no more. */
  [[nodiscard]] virtual bool touch(const hapticd::Pose& tool) = 0;
  /** All that the library tells of the contact, up to `most` records: pairs of triangles or points. */
  [[nodiscard]] virtual std::uint32_t contacts(const hapticd::Pose& tool, std::uint32_t most) = 0;
};

struct PeerKind {
  const char* name;
  const char* what;  ///< A record is one of these.
  std::unique_ptr<Peer> (*make)(const Model& base, const Model& tool);
};

/** FCL's triangles under trees of oriented boxes. */
extern const PeerKind kFclPeer;
/** Bullet's GImpact, its algorithm called directly: contactPairTest() knows nothing of it. */
extern const PeerKind kBulletPeer;

}  // namespace haptic_bench
