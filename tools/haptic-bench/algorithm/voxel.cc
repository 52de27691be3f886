// Voxel sampling with three degrees of freedom: signed distances to the surface, taken at the corners of a grid when
// the model is loaded; a step interpolates the eight about the hand and pushes along their slope. As fast as can be, at
// the price of the volume's making, its memory, and edges as round as a voxel is wide.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "tools/haptic-bench/algorithm/algorithms.h"
#include "tools/haptic-bench/algorithm/native.h"
#include "tools/haptic-bench/model/nearest.h"
#include "tools/haptic-bench/spec.h"

namespace haptic_bench {
namespace {

/** Signed distances on a grid, negative inside. */
class Volume {
 public:
  /** `cells` along the longest side of the model's box, which is widened by `margin` of that side. */
  Volume(const Model& model, int cells, double margin) {
    Vec3 lower = model.vertex(0), upper = lower;
    for (std::uint32_t v = 0; v < model.vertices.size(); ++v) {
      lower = lower.cwiseMin(model.vertex(v));
      upper = upper.cwiseMax(model.vertex(v));
    }
    const double longest = (upper - lower).maxCoeff();
    side_ = longest / cells;
    lower_ = lower - Vec3::Constant(margin * longest);
    for (int i = 0; i < 3; ++i) {
      count_[static_cast<std::size_t>(i)] =
          2 + static_cast<int>(std::ceil((upper[i] - lower[i] + 2 * margin * longest) / side_));
    }
    const NearestPoint surface(model);
    values_.reserve(static_cast<std::size_t>(count_[0]) * static_cast<std::size_t>(count_[1]) *
                    static_cast<std::size_t>(count_[2]));
    for (int z = 0; z < count_[2]; ++z) {
      for (int y = 0; y < count_[1]; ++y) {
        for (int x = 0; x < count_[0]; ++x) {
          const SurfacePoint at = surface.find(lower_ + side_ * Vec3(x, y, z));
          values_.push_back(static_cast<float>(at.inside ? -at.distance : at.distance));
        }
      }
    }
  }

  /** Trilinear. False outside the grid. */
  bool sample(const Vec3& x, double& distance, Vec3& slope) const {
    const Vec3 g = (x - lower_) / side_;
    int cell[3];
    double f[3];
    for (int i = 0; i < 3; ++i) {
      if (!(g[i] >= 0 && g[i] < count_[static_cast<std::size_t>(i)] - 1)) return false;
      cell[i] = static_cast<int>(g[i]);
      f[i] = g[i] - cell[i];
    }
    distance = 0;
    slope.setZero();
    for (int corner = 0; corner < 8; ++corner) {
      const int b[3] = {corner & 1, corner >> 1 & 1, corner >> 2 & 1};
      const double w[3] = {b[0] ? f[0] : 1 - f[0], b[1] ? f[1] : 1 - f[1], b[2] ? f[2] : 1 - f[2]};
      const double value = at(cell[0] + b[0], cell[1] + b[1], cell[2] + b[2]);
      distance += w[0] * w[1] * w[2] * value;
      slope += value / side_ *
               Vec3((b[0] ? 1 : -1) * w[1] * w[2], (b[1] ? 1 : -1) * w[0] * w[2], (b[2] ? 1 : -1) * w[0] * w[1]);
    }
    return true;
  }

  [[nodiscard]] std::size_t bytes() const { return values_.size() * sizeof(float); }

 private:
  [[nodiscard]] double at(int x, int y, int z) const {
    return values_[(static_cast<std::size_t>(z) * static_cast<std::size_t>(count_[1]) + static_cast<std::size_t>(y)) *
                       static_cast<std::size_t>(count_[0]) +
                   static_cast<std::size_t>(x)];
  }

  Vec3 lower_ = Vec3::Zero();
  double side_ = 0;
  std::array<int, 3> count_{};
  std::vector<float> values_;
};

Volume makeVolume(const haptic_algorithm_problem& problem) {
  Spec options(std::string("voxel:") + problem.options);
  const int cells = options.count("cells", 64, 4, 512);
  const double margin = options.number("margin", 0.1, 0, 1);
  options.finish();
  refuseBall(problem);
  return {modelOf(problem), cells, margin};
}

class Voxel {
 public:
  explicit Voxel(const haptic_algorithm_problem& problem)
      : volume_(makeVolume(problem)), stiffness_(problem.stiffness), damping_(problem.damping) {}

  void start(const Vec3&) {}

  void step(const Vec3& hip, const Vec3& v, double, haptic_algorithm_contact& contact) const {
    double distance = 0;
    Vec3 slope;
    if (!volume_.sample(hip, distance, slope) || distance >= 0 || slope.isZero(0)) {
      return answer(contact, Vec3::Zero(), hip, false);
    }
    const Vec3 out = slope.normalized();
    answer(contact, std::max(0.0, -stiffness_ * distance - damping_ * v.dot(out)) * out, hip - distance * out, true);
  }

  [[nodiscard]] std::size_t bytes() const { return volume_.bytes(); }

 private:
  Volume volume_;
  double stiffness_, damping_;
};

}  // namespace

const haptic_algorithm kVoxel =
    nativeAlgorithm<Voxel>("voxel", "signed distances sampled on a grid; voxel:cells=64,margin=0.1");

}  // namespace haptic_bench
