/** @file
 * What objects do to a hand in free space: fields that are felt within their reach, and guides that draw it to a point,
 * a curve or a surface. Thesis section 5.2.4; docs/effects.md tells the laws. For the guard all of it is active.
 */
#pragma once

#include <array>
#include <cstdint>
#include <limits>

#include "rt/base/math.h"
#include "rt/scene/scene.h"

namespace hapticd {

/**
 * Effects on one device point. Servo thread only; deterministic, no longer than twice searches of kMostVisitsOfAll,
 * which end with the nearest place found until then.
 *
 * All fields act together; of the guides that one in whose well the hand is deepest, which of equal guides is the
 * nearest. So all guides that rest are one potential, and no closed way gives energy.
 *
 * An effect that is set, changed or removed, and one whose object jumps, comes and goes within kBlend: what the force
 * was before, less what it would have been by what is ordered now, fades. Per tick the change of orders adds
 * |that| dt / kBlend at most. How the hand moves meanwhile is felt at once. One that ends by its time fades as long.
 * One whose object a pose puts elsewhere than its motion brings it comes over Scene::putOver(), or what is left of
 * that.
 */
class ObjectEffects {
 public:
  static constexpr double kBlend = 0.02;  ///< [s]
  /** Nodes and triangles of meshes that one effect visits, and all of them in a tick, each at least its kLeastVisits.
   * As many again in a tick that brings new orders: for another share of it another place may be found. */
  static constexpr int kMostVisits = 1024, kMostVisitsOfAll = 4096, kLeastVisits = 192;

  /** Force on a hand at p that moves at v, in W [N]. Once a tick of `dt`. */
  [[nodiscard]] Vec3 step(const Scene& scene, const Vec3& p, const Vec3& v, double dt, std::int64_t now_ns) HD_RT;
  /** Most that all of them together damp by [N s/m]: what the device can show beside what else damps it. */
  void setMaxDamping(double b) HD_RT { max_damping_ = b; }
  /** What they damped by in the last step [N s/m]. */
  [[nodiscard]] double damping() const HD_RT { return damping_; }
  /** The hand is somewhere else: nothing of before counts, and the next step() has all of its force at once. */
  void reset() HD_RT;
  /** Nodes, triangles and primitives that the last step has visited: what its time went by. */
  [[nodiscard]] int visits() const HD_RT { return visits_; }

 private:
  /** Where the hand is by an effect's geometry. Vectors in the object's frame. */
  struct Place {
    Vec3 way = Vec3::Zero();         ///< From the hand to the guide.
    Mat3 across = Mat3::Identity();  ///< Takes the part of a velocity that a guide damps.
    double distance = 0;             ///< 0 within a solid.
    int visits = 0;                  ///< What it took to find it.
  };
  /** The end of the spring by which friction holds the hand, in the object's frame. */
  struct Anchor {
    std::uint32_t object = 0;
    std::uint64_t step = 0;  ///< When it held last.
    Vec3 at = Vec3::Zero();
  };

  [[nodiscard]] static bool find(const SceneObject& object, const EffectParameters& effect, const Vec3& x,
                                 int most_visits, Place& place) HD_RT;
  struct Hand {
    Vec3 p = Vec3::Zero(), v = Vec3::Zero();
    std::int64_t now_ns = 0;
    double max_damping = 0;
  };
  struct Felt {
    Vec3 force = Vec3::Zero();
    double damping = 0;
    double most = 0;          ///< Than which the force is no larger [N].
    std::uint32_t guide = 0;  ///< Slot of the guide that acts, 0 for none.
    bool ends = false;        ///< That of the last tick is at its end.
  };

  /** Moves the anchor. */
  [[nodiscard]] Vec3 friction(Anchor& anchor, std::uint32_t object, const EffectParameters& effect, const Vec3& x,
                              double share) const HD_RT;
  /** By the orders of now; `before`: among the objects as they stood a tick ago, but for those that have jumped, and
   * changing nothing. */
  [[nodiscard]] Felt feel(const Scene& scene, const Hand& hand, bool before) HD_RT;

  double max_damping_ = std::numeric_limits<double>::infinity();
  double damping_ = 0;
  std::array<Anchor, kMaxObjects> anchor_{};
  std::uint64_t steps_ = 0;
  int visits_ = 0;                 ///< In the last tick.
  std::uint32_t guide_ = 0;        ///< Slot of the guide that acted in the last tick, 0 for none.
  bool fresh_ = true;              ///< No step since reset().
  Hand hand_;                      ///< Of the last tick,
  Vec3 last_ = Vec3::Zero();       ///< the force by what was ordered then, and what
  Vec3 last_rest_ = Vec3::Zero();  ///< still faded [N].
  Vec3 rest_ = Vec3::Zero();       ///< What fades after the last change [N],
  double blend_ = kBlend;          ///< over so long,
  double left_ = 0;                ///< for so much longer [s].
  double most_ = 0;                ///< Of Felt::most the largest of the last tick and meanwhile [N].
  std::uint64_t changes_ = 0;      ///< Scene::effectChanges() of the last tick.
};

}  // namespace hapticd
