// The god-object as published (Zilles and Salisbury, "A constraint-based god-object method for haptic display", IROS
// 1995): from where it is, the god-object looks along the straight line to the hand; each facet the line enters holds
// it by the plane of that facet, at most three; the goal is the nearest point to the hand on the right side of those
// planes, and the line to the goal is looked along in its turn. The search is local and nothing else is remembered: it
// is the plain method that others are compared with, over hapticd's own tree so that times compare the methods.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "rt/geometry/sweep/sweep.h"
#include "tools/haptic-bench/algorithm/algorithms.h"
#include "tools/haptic-bench/algorithm/native.h"
#include "tools/haptic-bench/model/built_mesh.h"
#include "tools/haptic-bench/spec.h"

namespace haptic_bench {
namespace {

/** The god-object may stand where normal . x >= offset. */
struct Facet {
  Vec3 normal = Vec3::Zero();
  double offset = 0;
};

constexpr std::size_t kMaxActive = 3;
constexpr int kMaxLooks = 8;
constexpr double kLift = 1e-9;  // Of the model's extent: keeps the god-object above its facet in spite of rounding.

/**
 * The nearest point to `hip` above all facets: the paper's Lagrange multipliers, for each set of active facets in turn;
 * a negative multiplier would mean that the facet pulls.
 */
std::optional<Vec3> nearestAbove(const std::array<Facet, kMaxActive>& facets, std::size_t count, const Vec3& hip,
                                 double tolerance) {
  static constexpr std::uint32_t kSets[] = {0b001, 0b010, 0b100, 0b011, 0b101, 0b110, 0b111};  // Small ones first.
  for (const std::uint32_t set : kSets) {
    if (set >> count != 0) continue;
    Eigen::Matrix<double, Eigen::Dynamic, 3, 0, 3, 3> normals(0, 3);
    Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 3, 1> lack(0);
    for (std::size_t i = 0; i < count; ++i) {
      if ((set >> i & 1) == 0) continue;
      const Eigen::Index row = normals.rows();
      normals.conservativeResize(row + 1, 3);
      lack.conservativeResize(row + 1);
      normals.row(row) = facets[i].normal;
      lack[row] = facets[i].offset - facets[i].normal.dot(hip);
    }
    const Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 3, 1> multipliers =
        (normals * normals.transpose()).fullPivLu().solve(lack);
    if (!multipliers.allFinite() || (multipliers.array() < 0).any()) continue;
    const Vec3 goal = hip + normals.transpose() * multipliers;
    bool above = true;
    for (std::size_t i = 0; i < count; ++i) above = above && facets[i].normal.dot(goal) >= facets[i].offset - tolerance;
    if (above) return goal;
  }
  return std::nullopt;
}

class GodObject {
 public:
  explicit GodObject(const haptic_algorithm_problem& problem)
      : mesh_(buildMesh(modelOf(problem))), stiffness_(problem.stiffness), damping_(problem.damping) {
    Spec(std::string("god-object:") + problem.options).finish();
    refuseBall(problem);
    shape_.kind = hapticd::ShapeKind::kMesh;
    shape_.mesh = &mesh_.view;
    double extent = 0;
    for (std::uint32_t v = 0; v < problem.vertex_count; ++v) {
      for (const float x : problem.vertices[v]) extent = std::max(extent, std::abs(double{x}));
    }
    lift_ = kLift * extent;
  }

  void start(const Vec3& hip) { god_object_ = hip; }

  void step(const Vec3& hip, const Vec3& v, double, haptic_algorithm_contact& contact) {
    std::array<Facet, kMaxActive> active;
    std::size_t count = 0;
    Vec3 goal = hip;
    for (int look = 0; look < kMaxLooks; ++look) {
      hapticd::SweepHit hit;
      if (!enters(goal, hit)) {
        god_object_ = goal;
        break;
      }
      // A fourth facet: the oldest is given up.
      if (count == kMaxActive) std::rotate(active.begin(), active.begin() + 1, active.end());
      count = std::min(count + 1, kMaxActive);
      active[count - 1] = {hit.normal, hit.offset + lift_};
      const std::optional<Vec3> next = nearestAbove(active, count, hip, lift_ / 4);
      if (!next) break;  // It stays where it is.
      goal = *next;
    }
    const Vec3 pull = god_object_ - hip;
    if (count == 0 || pull.isZero(0)) return answer(contact, Vec3::Zero(), god_object_, false);
    const Vec3 out = pull.normalized();
    answer(contact, std::max(0.0, stiffness_ * pull.norm() - damping_ * v.dot(out)) * out, god_object_, true);
  }

  [[nodiscard]] std::size_t bytes() const { return mesh_.mapping.size() + sizeof(*this); }

 private:
  bool enters(const Vec3& goal, hapticd::SweepHit& hit) const {
    hapticd::Sweep sweep;
    sweep.a = god_object_;
    sweep.d = goal - god_object_;
    sweep.tolerance = lift_ / 2;
    sweep.limit = UINT32_MAX;
    return hapticd::sweepShape(shape_, sweep, hit) == hapticd::SweepResult::kHit;
  }

  hapticd::SnapshotMemory mesh_;
  hapticd::Shape shape_;
  double stiffness_, damping_;
  double lift_ = 0;
  Vec3 god_object_ = Vec3::Zero();
};

}  // namespace

const haptic_algorithm kGodObject =
    nativeAlgorithm<GodObject>("god-object", "Zilles and Salisbury 1995 as published: local, no friction");

}  // namespace haptic_bench
