#include "daemon/builder/volume/winding.h"

#include <array>
#include <cmath>
#include <numbers>

namespace hapticd {
namespace {

constexpr double kFar = 2;  // Barill et al.'s beta: from how many radii away moments do.

Vec3 areaOf(const MeshView& mesh, std::uint32_t t) {
  const Vec3 a = mesh.vertex(t, 0);
  return (mesh.vertex(t, 1) - a).cross(mesh.vertex(t, 2) - a) / 2;
}

Vec3 middleOf(const MeshView& mesh, std::uint32_t t) {
  return (mesh.vertex(t, 0) + mesh.vertex(t, 1) + mesh.vertex(t, 2)) / 3;
}

}  // namespace

double windingOfTriangle(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& x) {
  const Vec3 u = a - x, v = b - x, w = c - x;
  const double lu = u.norm(), lv = v.norm(), lw = w.norm();
  const double volume = u.dot(v.cross(w));
  if (volume == 0) return 0;  // Also on an edge or corner, where the formula has 0 / 0.
  return std::atan2(volume, lu * lv * lw + u.dot(v) * lw + v.dot(w) * lu + w.dot(u) * lv) / (2 * std::numbers::pi);
}

WindingTree::WindingTree(const MeshView& mesh) : mesh_(mesh), moments_(std::size_t{mesh.node_count} * HD_BVH_WIDTH) {
  std::vector<std::uint32_t> parents(mesh.node_count, HD_NO_INDEX);  // The place above each node.
  std::vector<double> weight(moments_.size(), 0);
  // Children come after their parent: from the end, what is below is known.
  for (std::uint32_t n = mesh.node_count; n-- > 0;) {
    const hd_bvh_node& node = mesh.nodes[n];
    for (std::uint32_t i = 0; i < node.used; ++i) {
      const std::size_t place = std::size_t{HD_BVH_WIDTH} * n + i;
      Moments& m = moments_[place];
      if (node.count[i] == 0) {
        parents[node.child[i]] = static_cast<std::uint32_t>(place);
        for (std::size_t k = 0; k < mesh.nodes[node.child[i]].used; ++k) {
          const std::size_t below = std::size_t{HD_BVH_WIDTH} * node.child[i] + k;
          m.center += weight[below] * moments_[below].center;
          weight[place] += weight[below];
        }
      } else {
        for (std::uint32_t t = node.child[i]; t < node.child[i] + node.count[i]; ++t) {
          const double area = areaOf(mesh, t).norm();
          m.center += area * middleOf(mesh, t);
          weight[place] += area;
        }
      }
      if (weight[place] > 0) m.center /= weight[place];
      Vec3 reach;
      for (int k = 0; k < 3; ++k) reach[k] = std::max(node.upper[k][i] - m.center[k], m.center[k] - node.lower[k][i]);
      m.far2 = kFar * kFar * reach.squaredNorm();
    }
  }
  gather(parents);
}

void WindingTree::gather(const std::vector<std::uint32_t>& parents) {
  for (std::uint32_t n = 0; n < mesh_.node_count; ++n) {
    const hd_bvh_node& node = mesh_.nodes[n];
    for (std::uint32_t i = 0; i < node.used; ++i) {
      for (std::uint32_t t = node.child[i]; t < node.child[i] + node.count[i]; ++t) {
        // Each triangle to the places above it, of which there are HD_BVH_MAX_DEPTH at most.
        for (std::uint32_t place = HD_BVH_WIDTH * n + i; place != HD_NO_INDEX; place = parents[place / HD_BVH_WIDTH])
          add(moments_[place], t);
      }
    }
  }
}

void WindingTree::add(Moments& m, std::uint32_t t) const {
  const Vec3 area = areaOf(mesh_, t), middle = middleOf(mesh_, t) - m.center;
  m.area += area;
  m.first += (area * middle.transpose() + middle * area.transpose()) / 2;
  Mat3 dd = 9 * middle * middle.transpose();  // Mean of d d^T over a triangle: (sum v v^T + 9 m m^T) / 12.
  for (int c = 0; c < 3; ++c) {
    const Vec3 d = mesh_.vertex(t, c) - m.center;
    dd += d * d.transpose();
  }
  dd /= 12;
  m.second += 2 * dd * area + area * dd.trace();
  const auto sym = [&](int i, int j, int k) {
    return (area[i] * dd(j, k) + area[j] * dd(i, k) + area[k] * dd(i, j)) / 3;
  };
  const double cubic[10] = {sym(0, 0, 0), sym(1, 1, 1), sym(2, 2, 2), sym(0, 0, 1), sym(0, 0, 2),
                            sym(0, 1, 1), sym(1, 1, 2), sym(0, 2, 2), sym(1, 2, 2), sym(0, 1, 2)};
  for (std::size_t i = 0; i < 10; ++i) m.cubic[i] += cubic[i];
}

double WindingTree::farField(const Moments& m, const Vec3& r, double r2) {
  // Taylor's series of y / |y|^3 about r, contracted with the moments.
  const double inverse2 = 1 / r2, inverse3 = inverse2 / std::sqrt(r2), inverse5 = inverse3 * inverse2;
  const double x = r.x(), y = r.y(), z = r.z();
  const auto& c = m.cubic;
  const double cubic = c[0] * x * x * x + c[1] * y * y * y + c[2] * z * z * z +
                       3 * (c[3] * x * x * y + c[4] * x * x * z + c[5] * x * y * y + c[6] * y * y * z +
                            c[7] * x * z * z + c[8] * y * z * z) +
                       6 * c[9] * x * y * z;
  const double sum = m.area.dot(r) * inverse3 + m.first.trace() * inverse3 - 3 * r.dot(m.first * r) * inverse5 +
                     0.5 * (15 * cubic * inverse5 * inverse2 - 3 * m.second.dot(r) * inverse5);
  return sum / (4 * std::numbers::pi);
}

double WindingTree::at(const Vec3& x) const {
  double sum = 0;
  std::array<std::uint32_t, HD_BVH_MAX_DEPTH * HD_BVH_WIDTH> open;
  std::size_t count = 0;
  open[count++] = 0;
  while (count > 0) {
    const std::uint32_t n = open[--count];
    const hd_bvh_node& node = mesh_.nodes[n];
    for (std::uint32_t i = 0; i < node.used; ++i) {
      const Moments& m = moments_[std::size_t{HD_BVH_WIDTH} * n + i];
      const Vec3 r = m.center - x;
      const double r2 = r.squaredNorm();
      if (r2 > m.far2 && r2 > 0) {
        sum += farField(m, r, r2);
      } else if (node.count[i] == 0) {
        open[count++] = node.child[i];
      } else {
        for (std::uint32_t t = node.child[i]; t < node.child[i] + node.count[i]; ++t)
          sum += windingOfTriangle(mesh_.vertex(t, 0), mesh_.vertex(t, 1), mesh_.vertex(t, 2), x);
      }
    }
  }
  return sum;
}

}  // namespace hapticd
