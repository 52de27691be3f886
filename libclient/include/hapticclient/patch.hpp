/** @file
 * Local models from a mesh: the piece of surface where the hand will be while the model is in force. A program that
 * sends such a patch at 30 Hz and 5 ms late lets the hand feel nearly what the servo itself would render of the mesh.
 *
 *     auto mesh = haptic::SurfaceMesh::make(vertices, triangles);
 *     ...
 *     haptic_local_model model{};                       // slot, device, lease, blend, material are the program's
 *     haptic::fitPatch(*mesh, {sample.p...}, {sample.v...}, {.from_s = 0.005, .to_s = 0.038}, model);
 *     session.push(model, {.latest = true});
 *
 * The mesh's frame is the model's frame: for an object that moves, convert p and v into it and set `frame` to its id.
 */
#pragma once

#include <hapticclient/push.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <hapticclient/surface.hpp>

namespace haptic {

/** For which time and how far around a patch is to hold. */
struct PatchOptions {
  double from_s = 0.005;  ///< The model comes into force so long after the sample it is made from (latency) [s] ...
  double to_s = 0.04;     ///< ... and is replaced so long after it (latency + period) [s].
  double reach_m = 1e-3;  ///< How far the hand may stray from the way it is expected to take [m].
};

namespace detail {

/** The tangent plane under one point of the expected way. */
struct Support {
  Vector x{};        ///< The point, behind the surface.
  Vector foot{};     ///< Its nearest point on the mesh.
  Vector normal{};   ///< Outward, unit.
  double depth = 0;  ///< [m]

  [[nodiscard]] double slack(const Vector& y) const { return dot(normal, foot - y); }
};

inline Support supportAt(const SurfaceMesh& mesh, const Vector& x) {
  const SurfaceMesh::Foot foot = mesh.nearest(x);
  Support s{x, foot.point, foot.normal, std::max(0.0, -SurfaceMesh::above(foot, x))};
  // On an inner edge the way out leads to the edge, straight.
  if (s.depth > 0 && dot(s.normal, s.foot - x) < (1 - 1e-9) * s.depth) s.normal = 1 / s.depth * (s.foot - x);
  return s;
}

/** Where the hand will be: ten points along its way at the depth it has now, then six beside and beyond. */
struct Way {
  static constexpr std::size_t kAlong = 10;
  std::array<Support, HAPTIC_HALFSPACES> support;
  std::size_t middle = kAlong / 2;

  Way(const SurfaceMesh& mesh, const Vector& p, const Vector& v, const PatchOptions& options) {
    const SurfaceMesh::Foot now = mesh.nearest(p);
    const double inside = -SurfaceMesh::above(now, p);
    const double press = inside > 0 ? inside : options.reach_m / 2;
    const auto at = [&](const Vector& y) {
      const SurfaceMesh::Foot foot = mesh.nearest(y);
      return supportAt(mesh, foot.point - press * foot.normal);
    };
    std::array<Vector, kAlong> along;
    for (std::size_t i = 0; i < kAlong; ++i) {
      const double part = static_cast<double>(i) / (kAlong - 1);
      along[i] = p + ((1 - part) * options.from_s + part * options.to_s) * v;
      support[i] = at(along[i]);
    }
    Vector ahead = v - dot(v, now.normal) * now.normal;
    if (!(length(ahead) > 0))
      ahead = cross(now.normal, std::abs(now.normal[0]) < 0.5 ? Vector{1, 0, 0} : Vector{0, 1, 0});
    ahead = options.reach_m / length(ahead) * ahead;
    const Vector aside = cross(now.normal, ahead);
    const Vector& first = along.front();
    const Vector& last = along.back();
    std::size_t i = kAlong;
    for (const Vector& y : {first + aside, first - aside, last + aside, last - aside, first - ahead, last + ahead}) {
      support[i++] = at(y);
    }
  }
};

/** Planes that together are one solid: where all of them overlap (convex), or where any is (corner). */
class PatchFit {
 public:
  PatchFit(const Way& way, bool convex) : way_(way), convex_(convex) {
    double slip = 0;
    for (std::size_t i = 0; i < Way::kAlong; ++i) slip += way.support[i].depth * way.support[i].depth;
    tolerance_ = 1e-8 * slip;
    chosen_[count_++] = way.middle;
    error_ = errorOf(count_);
    for (std::size_t i = 0; i < way.support.size(); ++i) {
      if (i == way.middle || known(way.support[i])) continue;
      chosen_[count_] = i;
      const double with = errorOf(count_ + 1);
      if (with > error_ + tolerance_) continue;  // It would cut off, or add, what the mesh has not there.
      error_ = with;
      ++count_;
    }
  }

  [[nodiscard]] bool betterThan(const PatchFit& other) const {
    if (std::abs(error_ - other.error_) > tolerance_) return error_ < other.error_;
    return count_ > other.count_;
  }
  void write(haptic_local_model& model) const {
    model.kind = convex_ ? HAPTIC_MODEL_HALFSPACES : HAPTIC_MODEL_CORNER;
    model.count = static_cast<std::uint32_t>(count_);
    for (std::size_t i = 0; i < count_; ++i) {
      const Support& s = way_.support[chosen_[i]];
      const Support& middle = way_.support[way_.middle];
      for (std::size_t k = 0; k < 3; ++k) model.halfspace[i][k] = static_cast<float>(s.normal[k]);
      model.halfspace[i][3] = static_cast<float>(dot(s.normal, s.foot - middle.foot));
    }
  }

 private:
  [[nodiscard]] bool known(const Support& s) const {
    return std::any_of(chosen_.begin(), chosen_.begin() + static_cast<std::ptrdiff_t>(count_), [&](std::size_t i) {
      const Support& other = way_.support[i];
      return length(s.normal - other.normal) < 1e-5 && std::abs(other.slack(s.foot)) <= 1e-5 * (s.depth + other.depth);
    });
  }
  /** Squared difference of the way out from the mesh's, summed along the way, with the first `count` planes. */
  [[nodiscard]] double errorOf(std::size_t count) const {
    double sum = 0;
    for (std::size_t j = 0; j < Way::kAlong; ++j) {
      const Support& truth = way_.support[j];
      const Support* face = nullptr;
      for (std::size_t i = 0; i < count; ++i) {
        const Support& s = way_.support[chosen_[i]];
        if (face == nullptr || (s.slack(truth.x) < face->slack(truth.x)) == convex_) face = &s;
      }
      const Vector off = std::max(0.0, face->slack(truth.x)) * face->normal - truth.depth * truth.normal;
      sum += dot(off, off);
    }
    return sum;
  }

  const Way& way_;
  bool convex_;
  std::array<std::size_t, HAPTIC_HALFSPACES> chosen_{};  ///< Each support once, at most.
  std::size_t count_ = 0;
  double error_ = 0;
  double tolerance_ = 0;
};

inline void writePlane(const Support& s, haptic_local_model& model) {
  model.kind = HAPTIC_MODEL_PLANE;
  model.count = 0;
  model.radius = 0;
  std::copy(s.foot.begin(), s.foot.end(), model.origin);
  std::copy(s.normal.begin(), s.normal.end(), model.normal);
}

}  // namespace detail

/**
 * Fills in the geometry of `model` (kind, origin, normal): the tangent plane under the middle of the way that a hand at
 * p with velocity v [m/s] takes between the two times. About 50 us on a million triangles.
 */
inline void fitPlane(const SurfaceMesh& mesh, const Vector& p, const Vector& v, const PatchOptions& options,
                     haptic_local_model& model) {
  const detail::Way way(mesh, p, v, options);
  detail::writePlane(way.support[way.middle], model);
}

/**
 * The same with up to 16 faces: half-spaces where the mesh bulges, a corner where it is hollow, whichever gives the
 * force nearer to the mesh's along the way; edges as sharp as the mesh's. On a mesh that bulges the force is the mesh's
 * while the hand keeps its way and its faces there are few; where there are many, that of a neighbouring face. A hand
 * behind a wall thinner than twice its depth is taken to stand behind the other face.
 */
inline void fitPatch(const SurfaceMesh& mesh, const Vector& p, const Vector& v, const PatchOptions& options,
                     haptic_local_model& model) {
  const detail::Way way(mesh, p, v, options);
  detail::writePlane(way.support[way.middle], model);
  model.radius = 1e-9;
  const detail::PatchFit bulge(way, true), hollow(way, false);
  (hollow.betterThan(bulge) ? hollow : bulge).write(model);
}

}  // namespace haptic
