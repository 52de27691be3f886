// The potential method: the force pushes to the nearest point of the surface, found by trying every triangle. No memory
// of where the hand came from, so thin plates let it through; the most accurate where there is but one side.
#include "tools/haptic-bench/model/nearest.h"

#include "tools/haptic-bench/algorithm/algorithms.h"
#include "tools/haptic-bench/algorithm/native.h"
#include "tools/haptic-bench/spec.h"

namespace haptic_bench {
namespace {

class Potential {
 public:
  explicit Potential(const haptic_algorithm_problem& problem)
      : surface_(modelOf(problem)), stiffness_(problem.stiffness), damping_(problem.damping), radius_(problem.radius) {
    Spec(std::string("nearest:") + problem.options).finish();
  }

  void start(const Vec3&) {}

  void step(const Vec3& hip, const Vec3& v, double, haptic_algorithm_contact& contact) const {
    const SurfacePoint at = surface_.find(hip);
    const double depth = radius_ + (at.inside ? at.distance : -at.distance);
    if (depth <= 0) return answer(contact, Vec3::Zero(), hip, false);
    const Vec3 out = at.outward(hip);
    answer(contact, std::max(0.0, stiffness_ * depth - damping_ * v.dot(out)) * out, hip + depth * out, true);
  }

  [[nodiscard]] std::size_t bytes() const { return surface_.bytes(); }

 private:
  NearestPoint surface_;
  double stiffness_, damping_, radius_;
};

}  // namespace

const haptic_algorithm kNearest =
    nativeAlgorithm<Potential>("nearest", "potential: exact nearest triangle by brute force");

}  // namespace haptic_bench
