#include "daemon/builder/volume/hole_fill.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <unordered_set>

#include "daemon/builder/volume/tetrahedra.h"

namespace hapticd {
namespace {

constexpr double kHalf = 0.5;
constexpr double kSmooth = 0.4;  // A change below this is no jump across the mesh, which is by 1.
constexpr int kHalvings = 12;    // Then the place of a jump is known to a 4096th of a voxel.

Lattice3 cornerOf(const Lattice3& voxel, int c) {
  return {voxel[0] + (c & 1), voxel[1] + (c >> 1 & 1), voxel[2] + (c >> 2)};
}

std::uint64_t keyOf(const Lattice3& p) {
  std::uint64_t key = 0;
  for (const std::int32_t x : p) key = key << 20 | static_cast<std::uint32_t>(x);
  return key;
}

/** Where a lattice edge goes from inside to outside. */
struct Crossing {
  std::uint32_t vertex = 0;
  bool free = false;  ///< Through one half, not through the mesh.
};

/** A crossing and between which corners of a voxel it is. */
struct Cut : CutEdge {
  Crossing crossing;
};

class Filler {
 public:
  Filler(const MeshView& mesh, const WindingTree& winding, const VolumeLattice& lattice)
      : mesh_(mesh), winding_(winding), lattice_(lattice) {}

  Result<HoleFill> run(BuildMonitor& monitor) {
    std::size_t done = 0;
    const auto goesOn = [&] { return done++ % 64 != 0 || monitor.progress(0, "closing holes"); };
    const Error cancelled{ErrorCode::kCancelled, "build", {}, {}};
    for (std::uint32_t t = 0; t < mesh_.triangle_count; ++t) {
      for (int e = 0; e < 3; ++e) {
        if (mesh_.neighbours[t][e] != HD_NO_INDEX) continue;
        beginAt(mesh_.vertex(t, e), mesh_.vertex(t, (e + 1) % 3));
        if (!goesOn()) return cancelled;
      }
    }
    while (!open_.empty()) {
      if (!goesOn()) return cancelled;
      const Lattice3 voxel = open_.back();
      open_.pop_back();
      visit(voxel);
      if (fill_.triangles.size() > HD_MAX_TRIANGLES / 2) {
        return Error{ErrorCode::kInvalidArgument, "volume holes",
                     fmt::format("more than {} triangles would close them", HD_MAX_TRIANGLES / 2),
                     "choose a larger voxel"};
      }
    }
    if (!any_inside_) {
      return Error{ErrorCode::kBadMesh, "mesh", "the open surface encloses nothing",
                   "give it a thickness, or turn its triangles outward"};
    }
    return std::move(fill_);
  }

 private:
  /** The voxels about a border edge. */
  void beginAt(const Vec3& a, const Vec3& b) {
    const double steps = std::max(1.0, std::ceil((b - a).norm() / lattice_.voxel));
    for (double i = 0; i <= steps; ++i) {
      const Vec3 u = (a + i / steps * (b - a) - lattice_.origin) / lattice_.voxel;
      Lattice3 middle;
      for (std::size_t k = 0; k < 3; ++k)
        middle[k] = static_cast<std::int32_t>(std::floor(u[static_cast<Eigen::Index>(k)]));
      for (std::int32_t n = 0; n < 27; ++n)
        enqueue({middle[0] + n % 3 - 1, middle[1] + n / 3 % 3 - 1, middle[2] + n / 9 - 1});
    }
  }

  void enqueue(const Lattice3& voxel) {
    for (std::size_t k = 0; k < 3; ++k)
      if (voxel[k] < 0 || voxel[k] >= static_cast<std::int32_t>(lattice_.cells[k] * HD_BRICK_EDGE)) return;
    if (seen_.insert(keyOf(voxel)).second) open_.push_back(voxel);
  }

  double value(const Lattice3& p) {
    const auto [found, made] = values_.try_emplace(keyOf(p), 0);
    if (made) found->second = winding_.at(lattice_.at(p));
    return found->second;
  }

  void visit(const Lattice3& voxel) {
    unsigned inside = 0;
    for (int c = 0; c < 8; ++c) inside |= (value(cornerOf(voxel, c)) > kHalf ? 1u : 0u) << c;
    any_inside_ |= inside != 0;
    if (inside == 0 || inside == 255) return;
    marchCell(
        inside, [&](int in, int out_of) { return cutOf(voxel, in, out_of); },
        [&](const Cut& a, const Cut& b, const Cut& c) { add(a, b, c); });
  }

  /** Also goes on to the voxels that share the edge, if the surface passes it. */
  Cut cutOf(const Lattice3& voxel, int in, int out_of) {
    const int low = std::min(in, out_of), direction = std::abs(in - out_of);  // Of Kuhn's edges that tells which.
    const std::uint64_t key = keyOf(cornerOf(voxel, low)) << 3 | static_cast<std::uint64_t>(direction);
    const auto [found, made] = crossings_.try_emplace(key);
    if (made) found->second = cross(cornerOf(voxel, in), cornerOf(voxel, out_of));
    const Cut cut{{in, out_of}, found->second};
    if (!cut.crossing.free) return cut;
    for (std::size_t k = 0; k < 3; ++k) {
      if ((direction >> k & 1) != 0) continue;
      Lattice3 beside = voxel;
      beside[k] += (low >> k & 1) != 0 ? 1 : -1;
      enqueue(beside);
    }
    return cut;
  }

  Crossing cross(const Lattice3& in, const Lattice3& out_of) {
    const Vec3 a = lattice_.at(in), along = lattice_.at(out_of) - a;
    double from = 0, to = 1, more = value(in), less = value(out_of);
    const auto narrow = [&](double t) {
      const double w = winding_.at(a + t * along);
      (w > kHalf ? from : to) = t;
      (w > kHalf ? more : less) = w;
    };
    for (int i = 0; i < kHalvings && more - less > kSmooth; ++i) narrow((from + to) / 2);
    Crossing crossing;
    crossing.free = more - less <= kSmooth;
    const auto linear = [&] { return from + (to - from) * (more - kHalf) / (more - less); };
    if (crossing.free) narrow(linear());
    const Vec3 x = a + (crossing.free ? linear() : (from + to) / 2) * along;
    crossing.vertex = static_cast<std::uint32_t>(fill_.vertices.size());
    fill_.vertices.push_back({static_cast<float>(x.x()), static_cast<float>(x.y()), static_cast<float>(x.z())});
    return crossing;
  }

  /** A triangle that looks from what is inside to what is not. The mesh's own are left. */
  void add(const Cut& a, const Cut& b, const Cut& c) {
    const Crossing &i = a.crossing, &j = b.crossing, &k = c.crossing;
    if (!i.free && !j.free && !k.free) return;
    if (looksOut(a, b, c)) {
      fill_.triangles.push_back({i.vertex, j.vertex, k.vertex});
    } else {
      fill_.triangles.push_back({i.vertex, k.vertex, j.vertex});
    }
  }

  const MeshView& mesh_;
  const WindingTree& winding_;
  const VolumeLattice& lattice_;
  HoleFill fill_;
  bool any_inside_ = false;
  std::vector<Lattice3> open_;
  std::unordered_set<std::uint64_t> seen_;
  std::unordered_map<std::uint64_t, double> values_;
  std::unordered_map<std::uint64_t, Crossing> crossings_;
};

}  // namespace

Result<HoleFill> fillHoles(const MeshView& mesh, const WindingTree& winding, const VolumeLattice& lattice,
                           BuildMonitor& monitor) {
  return Filler(mesh, winding, lattice).run(monitor);
}

}  // namespace hapticd
