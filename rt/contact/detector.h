/** @file
 * The one interface of the collision detectors: two bodies' shapes and motions in, contacts out, within a budget.
 */
#pragma once

#include <cstdint>

#include "rt/base/clock.h"
#include "rt/base/math.h"
#include "rt/contact/contact.h"

namespace hapticd {

struct VolumeView;

/** How much a query may cost. Both bounds hold; none is ever overrun by more than one unit. */
struct WorkBudget {
  std::uint32_t units = 0;       ///< Of the detector's work, repeatable; 0: no bound but the bodies' sizes.
  std::int64_t deadline_ns = 0;  ///< On `clock`, 0: none. Read every few hundred units.
  Clock* clock = nullptr;        ///< Null: no deadline.
};

/** One body at the time of the query. */
struct BodyState {
  const VolumeView* volume = nullptr;
  Pose X_WO;         ///< Now.
  Pose X_WO_before;  ///< At the previous query: thin walls are guarded by sweeping between the two.
  Twist V_WO;        ///< Of the origin [m/s, rad/s], in the world.
};

struct DetectorQuery {
  BodyState a;              ///< The tool.
  BodyState b;              ///< What it touches.
  double margin = 0;        ///< Contacts up to this far apart are reported, with negative depth [m]; see each detector.
  double period = 0;        ///< Until the next query, if known: what will have parted by then is not reported [s].
  bool first_only = false;  ///< Whether they touch, no more: ends at the first contact.
  std::uint32_t max_contacts = kMostClusters;
  WorkBudget budget;
};

/**
 * Finds where two bodies touch. Keeps what it learnt from query to query (temporal coherence); unless the budget ends
 * the search, results never depend on that but for `age` and `report`. One thread. Memory is taken when it is made.
 */
class Detector {
 public:
  virtual ~Detector() = default;
  [[nodiscard]] virtual const char* name() const noexcept = 0;
  /** Contacts that part faster than they touch are dropped; resting ones keep their features and grow older. */
  virtual void find(const DetectorQuery& query, ContactSet& contacts) HD_RT = 0;
  /** Forgets what it knows of the last query: a teleport, another volume. */
  virtual void reset() HD_RT = 0;
};

}  // namespace hapticd
