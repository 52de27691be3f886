#include "tools/hapticctl-cut/mesh_distance.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace hapticctl_cut {
namespace {

Vec3 at(const Surface& mesh, std::uint32_t vertex) {
  const auto& v = mesh.vertices[vertex];
  return {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])};
}

std::uint64_t edgeKey(std::uint32_t a, std::uint32_t b) {
  return static_cast<std::uint64_t>(std::min(a, b)) << 32 | std::max(a, b);
}

/** Directions that tell inside from outside at each feature; of any length. */
struct PseudoNormals {
  std::vector<Vec3> vertex, face;
  std::unordered_map<std::uint64_t, Vec3> edge;

  explicit PseudoNormals(const Surface& mesh) : vertex(mesh.vertices.size(), Vec3::Zero()) {
    edge.reserve(mesh.triangles.size() * 3 / 2);
    for (const auto& t : mesh.triangles) {
      const Vec3 p[3] = {at(mesh, t[0]), at(mesh, t[1]), at(mesh, t[2])};
      const Vec3 n = (p[1] - p[0]).cross(p[2] - p[0]).stableNormalized();
      face.push_back(n);
      for (std::size_t c = 0; c < 3; ++c) {
        const Vec3 a = p[(c + 1) % 3] - p[c], b = p[(c + 2) % 3] - p[c];
        vertex[t[c]] += std::atan2(a.cross(b).norm(), a.dot(b)) * n;
        const auto [found, made] = edge.try_emplace(edgeKey(t[c], t[(c + 1) % 3]), n);
        if (!made) found->second += n;
      }
    }
  }
};

/** The nearest point of a triangle: bit c of `corners` set if corner c has a part in it. */
struct Nearest {
  Vec3 point;
  unsigned corners;
};

/** By the regions of Ericson, Real-Time Collision Detection (2005), section 5.1.5. */
Nearest nearestOf(const Vec3 (&p)[3], const Vec3& x) {
  const Vec3 ab = p[1] - p[0], ac = p[2] - p[0], ax = x - p[0];
  const double d1 = ab.dot(ax), d2 = ac.dot(ax);
  if (d1 <= 0 && d2 <= 0) return {p[0], 1};
  const Vec3 bx = x - p[1];
  const double d3 = ab.dot(bx), d4 = ac.dot(bx);
  if (d3 >= 0 && d4 <= d3) return {p[1], 2};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return {p[0] + ab * (d1 / (d1 - d3)), 3};
  const Vec3 cx = x - p[2];
  const double d5 = ab.dot(cx), d6 = ac.dot(cx);
  if (d6 >= 0 && d5 <= d6) return {p[2], 4};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return {p[0] + ac * (d2 / (d2 - d6)), 5};
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    return {p[1] + (p[2] - p[1]) * ((d4 - d3) / ((d4 - d3) + (d5 - d6))), 6};
  }
  const double sum = va + vb + vc;
  return {p[0] + ab * (vb / sum) + ac * (vc / sum), 7};
}

using Widths = std::array<std::vector<double>, 3>;

/**
 * A lattice point looks at triangles no farther away than this times the square of a diagonal of the widest cell beside
 * it: of an edge that is crossed both ends see the crossing, and whoever sees a triangle sees the nearest one too.
 */
constexpr double kReach = 1.02;

/** The planes of all points that may look at what is in this box: steps that grow by a fifth make up for the 1.6. */
void around(const Lattice& lattice, const Widths& width, const Vec3& lower, const Vec3& upper, std::size_t (&first)[3],
            std::size_t (&end)[3]) {
  const auto range = [&](double beyond) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto& planes = lattice.plane[k];
      const auto axis = static_cast<Eigen::Index>(k);
      first[k] = static_cast<std::size_t>(std::lower_bound(planes.begin(), planes.end(), lower[axis] - beyond) -
                                          planes.begin());
      end[k] = static_cast<std::size_t>(std::upper_bound(planes.begin(), planes.end(), upper[axis] + beyond) -
                                        planes.begin());
    }
  };
  range(0);
  double squared = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t from = std::min(first[k] > 0 ? first[k] - 1 : 0, width[k].size() - 1);
    const std::size_t to = std::min(end[k] + 1, width[k].size());
    const double widest = *std::max_element(width[k].begin() + static_cast<std::ptrdiff_t>(from),
                                            width[k].begin() + static_cast<std::ptrdiff_t>(to));
    squared += widest * widest;
  }
  range(1.6 * std::sqrt(squared));
}

}  // namespace

std::optional<std::string> whyOpen(const Surface& mesh) {
  std::unordered_map<std::uint64_t, int> turns;  // One way and the other must come out even.
  turns.reserve(mesh.triangles.size() * 3 / 2);
  for (const auto& t : mesh.triangles) {
    for (std::size_t c = 0; c < 3; ++c) turns[edgeKey(t[c], t[(c + 1) % 3])] += t[c] < t[(c + 1) % 3] ? 1 : -1;
  }
  for (const auto& t : mesh.triangles) {
    for (std::size_t c = 0; c < 3; ++c) {
      if (turns[edgeKey(t[c], t[(c + 1) % 3])] == 0) continue;
      const Vec3 x = at(mesh, t[c]);
      return fmt::format("is not closed: there is a hole at {:.4g}, {:.4g}, {:.4g}", x.x(), x.y(), x.z());
    }
  }
  if (hapticctl_import::volumeOf(mesh) <= 0) return "is inside out: its triangles look inward";
  return std::nullopt;
}

std::vector<float> insideness(const Surface& mesh, const Lattice& lattice) {
  const PseudoNormals normals(mesh);
  constexpr float kUnknown = 1e30f;
  std::vector<float> nearest(lattice.count(), kUnknown);  // Squared.
  std::vector<bool> inside(lattice.count(), false);
  const Widths width = {lattice.widths(0), lattice.widths(1), lattice.widths(2)};
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& t = mesh.triangles[i];
    const Vec3 p[3] = {at(mesh, t[0]), at(mesh, t[1]), at(mesh, t[2])};
    const Vec3 lower = p[0].cwiseMin(p[1]).cwiseMin(p[2]), upper = p[0].cwiseMax(p[1]).cwiseMax(p[2]);
    std::size_t first[3], end[3];
    around(lattice, width, lower, upper, first, end);
    const Vec3 n = normals.face[i];
    for (std::size_t z = first[2]; z < end[2]; ++z) {
      for (std::size_t y = first[1]; y < end[1]; ++y) {
        for (std::size_t x = first[0]; x < end[0]; ++x) {
          const Vec3 q = lattice.at(x, y, z);
          const double reach_squared =
              kReach * (width[0][x] * width[0][x] + width[1][y] * width[1][y] + width[2][z] * width[2][z]);
          const double above = n.dot(q - p[0]);
          if (above * above > reach_squared) continue;
          const Nearest found = nearestOf(p, q);
          const double squared = (q - found.point).squaredNorm();
          float& best = nearest[lattice.index(x, y, z)];
          if (squared > reach_squared || squared >= static_cast<double>(best)) continue;
          Vec3 out = n;
          if (found.corners == 1 || found.corners == 2 || found.corners == 4) {
            out = normals.vertex[t[found.corners >> 1]];
          } else if (found.corners != 7) {
            const std::size_t a = (found.corners & 1) != 0 ? 0 : 1, b = (found.corners & 4) != 0 ? 2 : 1;
            out = normals.edge.at(edgeKey(t[a], t[b]));
          }
          best = static_cast<float>(squared);
          inside[lattice.index(x, y, z)] = out.dot(q - found.point) <= 0;
        }
      }
    }
  }
  // Between two neighbours of which one is unknown nothing crosses: both are on the same side.
  std::vector<float> out(lattice.count());
  for (std::size_t z = 0; z < lattice.size(2); ++z) {
    for (std::size_t y = 0; y < lattice.size(1); ++y) {
      bool side = false;
      for (std::size_t x = 0; x < lattice.size(0); ++x) {
        const std::size_t i = lattice.index(x, y, z);
        if (nearest[i] < kUnknown) side = inside[i];
        const float distance = nearest[i] < kUnknown ? std::sqrt(nearest[i]) : kUnknown;
        out[i] = side ? distance : -distance;
      }
    }
  }
  return out;
}

}  // namespace hapticctl_cut
