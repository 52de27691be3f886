#include "tools/haptic-bench/trajectory/geodesic.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/model/nearest.h"
#include "tools/mesh_file/flat.h"

namespace haptic_bench {
namespace {

constexpr double kOffCorner = 1e-6;  // Barycentric: a way through a vertex passes beside it.
constexpr int kMaxFacets = 100000;   // Crossed between two samples.

/** A point of a facet and where it is going. */
class Walker {
 public:
  Walker(const Model& model, std::uint32_t facet, double azimuth) : model_(model), facet_(facet) {
    for (std::uint32_t t = 0; t < model.triangles.size(); ++t) {
      const auto& v = model.triangles[t];
      for (std::size_t c = 0; c < 3; ++c) beyond_[{v[c], v[(c + 1) % 3]}] = t;
    }
    const Vec3 n = normalOf(facet_);
    const Vec3 reference = std::abs(n.x()) < 0.9 ? Vec3::UnitX() : Vec3::UnitY();
    const Vec3 ahead = (reference - n * n.dot(reference)).normalized();
    direction_ = std::cos(azimuth) * ahead + std::sin(azimuth) * n.cross(ahead);
  }

  void advance(double way) {
    for (int crossed = 0; way > 0; ++crossed) {
      const Vec3 rate = barycentricRate();
      if (crossed > kMaxFacets || !rate.allFinite()) {
        const Vec3 p = place();
        throw Failure(
            "geodesic",
            fmt::format("at ({:.6g}, {:.6g}, {:.6g}) it is caught among triangles without area that cannot be "
                        "mended",
                        p.x(), p.y(), p.z()),
            "a cleaner mesh, or another azimuth or beginning");
      }
      double step = way;
      int leaves = -1;  // By the edge opposite of this corner.
      for (int c = 0; c < 3; ++c) {
        if (rate[c] < 0 && -at_[c] / rate[c] < step) {
          step = std::max(0.0, -at_[c] / rate[c]);
          leaves = c;
        }
      }
      at_ += step * rate;
      way -= step;
      if (leaves >= 0) cross(leaves);
      at_ = at_.cwiseMax(0);
      at_ /= at_.sum();
    }
  }

  [[nodiscard]] SurfaceSample sample(const NearestPoint& surface) const {
    SurfaceSample s;
    s.point = place();
    for (int c = 0; c < 3; ++c)
      s.normal += at_[c] * surface.vertexNormal(model_.triangles[facet_][static_cast<std::size_t>(c)]);
    constexpr double kNone = 1e-9;
    s.normal = s.normal.norm() > kNone ? Vec3(s.normal.normalized()) : normalOf(facet_);
    return s;
  }

 private:
  [[nodiscard]] Vec3 place() const {
    return at_[0] * model_.corner(facet_, 0) + at_[1] * model_.corner(facet_, 1) + at_[2] * model_.corner(facet_, 2);
  }

  [[nodiscard]] Vec3 normalOf(std::uint32_t t) const {
    const Vec3 a = model_.corner(t, 0);
    return (model_.corner(t, 1) - a).cross(model_.corner(t, 2) - a).normalized();
  }

  /** Change of the barycentric coordinates per metre along the direction. */
  [[nodiscard]] Vec3 barycentricRate() const {
    const Vec3 a = model_.corner(facet_, 0), ab = model_.corner(facet_, 1) - a, ac = model_.corner(facet_, 2) - a;
    const Vec3 n = ab.cross(ac);
    const double b = direction_.cross(ac).dot(n) / n.squaredNorm(), c = ab.cross(direction_).dot(n) / n.squaredNorm();
    return {-b - c, b, c};
  }

  /** Over the edge opposite of `corner`; back from a border. */
  void cross(int corner) {
    const auto& v = model_.triangles[facet_];
    const auto i = static_cast<std::size_t>((corner + 1) % 3), j = static_cast<std::size_t>((corner + 2) % 3);
    const Vec3 edge = (model_.vertex(v[j]) - model_.vertex(v[i])).normalized();
    const double along = direction_.dot(edge);
    const double across = std::sqrt(std::max(0.0, 1 - along * along));
    at_[corner] = 0;
    const auto other = beyond_.find({v[j], v[i]});
    if (other == beyond_.end()) {
      direction_ = along * edge - across * edge.cross(normalOf(facet_));
      return;
    }
    const double share = std::clamp(at_[static_cast<int>(j)], kOffCorner, 1 - kOffCorner);
    const std::uint32_t first = v[i], last = v[j];
    facet_ = other->second;
    at_.setZero();
    for (int c = 0; c < 3; ++c) {
      const std::uint32_t w = model_.triangles[facet_][static_cast<std::size_t>(c)];
      if (w == first) at_[c] = 1 - share;
      if (w == last) at_[c] = share;
    }
    // Into the new facet: its inside lies to the right of the edge as the old facet runs along it.
    direction_ = along * edge + across * edge.cross(normalOf(facet_));
  }

  const Model& model_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> beyond_;  ///< Facet to the left of a directed edge.
  std::uint32_t facet_;
  Vec3 at_ = Vec3::Constant(1.0 / 3);
  Vec3 direction_ = Vec3::Zero();
};

}  // namespace

std::vector<SurfaceSample> geodesic(const Model& given, const Pace& pace, double speed, double azimuth,
                                    const Vec3& from) {
  Model model = given;
  model.triangles = hapticd_mesh_file::withoutFlatTriangles(given.vertices, given.triangles);
  std::uint32_t first = 0;
  double best = std::numeric_limits<double>::infinity();
  for (std::uint32_t t = 0; t < model.triangles.size(); ++t) {
    if (hapticd_mesh_file::isFlat(model.vertices, model.triangles[t])) continue;
    const double off = ((model.corner(t, 0) + model.corner(t, 1) + model.corner(t, 2)) / 3 - from).norm();
    if (off < best) best = off, first = t;
  }
  if (!std::isfinite(best)) throw Failure(given.name, "no triangle has an area", "check the scale and the export");
  const NearestPoint surface(model);
  Walker walker(model, first, azimuth);
  std::vector<SurfaceSample> out;
  const std::size_t n = samplesIn(pace.seconds, pace);
  for (std::size_t i = 0; i < n; ++i) {
    out.push_back(walker.sample(surface));
    out.back().t_s = static_cast<double>(i) / pace.rate_hz;
    out.back().force = pace.force;
    walker.advance(speed / pace.rate_hz);
  }
  return out;
}

}  // namespace haptic_bench
