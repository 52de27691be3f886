#include "tools/hapticctl-import/isosurface.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <unordered_map>

#include "daemon/builder/volume/tetrahedra.h"

namespace hapticctl_import {
namespace {

constexpr unsigned kAxisBits = 20;  ///< Of an edge's key: three axes and its direction are 63.

class Marcher {
 public:
  Marcher(const LatticeSolid& solid, Surface& out) : solid_(solid), out_(out) {}

  void run() {
    // One layer of nothing about the lattice closes what it cuts off.
    for (int z = -1; z < static_cast<int>(solid_.size[2]); ++z) {
      for (int y = -1; y < static_cast<int>(solid_.size[1]); ++y)
        for (int x = -1; x < static_cast<int>(solid_.size[0]); ++x) cell({x, y, z});
    }
  }

 private:
  using Point = std::array<int, 3>;
  /** A vertex between a corner inside and one that is not. */
  struct Cut : hapticd::CutEdge {
    std::uint32_t vertex;
  };

  [[nodiscard]] bool within(const Point& p) const {
    for (std::size_t k = 0; k < 3; ++k)
      if (p[k] < 0 || p[k] >= static_cast<int>(solid_.size[k])) return false;
    return true;
  }
  [[nodiscard]] float value(std::size_t layer, const Point& p) const {
    if (!within(p)) return -std::numeric_limits<float>::infinity();
    return solid_.layers[layer][static_cast<std::size_t>(p[0]) +
                                solid_.size[0] *
                                    (static_cast<std::size_t>(p[1]) + solid_.size[1] * static_cast<std::size_t>(p[2]))];
  }
  static Point corner(const Point& at, int c) { return {at[0] + (c & 1), at[1] + (c >> 1 & 1), at[2] + (c >> 2)}; }

  void cell(const Point& at) {
    unsigned inside = 255;
    for (std::size_t layer = 0; layer < solid_.layers.size(); ++layer) {
      unsigned of_layer = 0;
      for (int c = 0; c < 8; ++c) of_layer |= (value(layer, corner(at, c)) >= solid_.iso ? 1u : 0u) << c;
      inside &= of_layer;
      if (inside == 0) return;
    }
    if (inside == 255) return;
    hapticd::marchCell(
        inside,
        [&](int in, int out_of) {
          return Cut{{in, out_of}, vertex(at, in, out_of)};
        },
        [&](const Cut& a, const Cut& b, const Cut& c) { add(a, b, c); });
  }

  /** The vertex on the edge between a corner inside and one that is not, made once. */
  std::uint32_t vertex(const Point& at, int in, int out_of) {
    const int a = std::min(in, out_of), b = std::max(in, out_of);
    const Point p = corner(at, a), q = corner(at, b);
    std::uint64_t key = 0;
    for (std::size_t k = 0; k < 3; ++k) key = key << kAxisBits | static_cast<std::uint64_t>(p[k] + 1);
    key = key << 3 | static_cast<std::uint64_t>(b - a);  // Of Kuhn's edges the difference tells the direction.
    const auto [found, made] = edges_.try_emplace(key, static_cast<std::uint32_t>(out_.vertices.size()));
    if (!made) return found->second;
    // Measured from a, the lower end, for all layers and both sides of a cut alike.
    double t = in == a ? 1 : 0;
    for (std::size_t layer = 0; layer < solid_.layers.size(); ++layer) {
      const float va = value(layer, p), vb = value(layer, q);
      if ((in == a ? vb : va) >= solid_.iso) continue;
      double crossing = (static_cast<double>(solid_.iso) - static_cast<double>(va)) /
                        (static_cast<double>(vb) - static_cast<double>(va));
      if (!std::isfinite(va)) crossing = 0.99;
      if (!std::isfinite(vb)) crossing = 0.01;
      t = in == a ? std::min(t, crossing) : std::max(t, crossing);
    }
    t = std::clamp(t, 0.01, 0.99);
    Double3 between;
    for (std::size_t k = 0; k < 3; ++k) between[k] = p[k] + t * (q[k] - p[k]);
    const Double3 x = solid_.place(between);
    out_.vertices.push_back({static_cast<float>(x[0]), static_cast<float>(x[1]), static_cast<float>(x[2])});
    return found->second;
  }

  /** A triangle that looks from what is inside to what is not, whatever the values are. */
  void add(const Cut& a, const Cut& b, const Cut& c) {
    if (hapticd::looksOut(a, b, c) != solid_.mirrored) {
      out_.triangles.push_back({a.vertex, b.vertex, c.vertex});
    } else {
      out_.triangles.push_back({a.vertex, c.vertex, b.vertex});
    }
  }

  const LatticeSolid& solid_;
  Surface& out_;
  std::unordered_map<std::uint64_t, std::uint32_t> edges_;
};

}  // namespace

Surface isosurface(const LatticeSolid& solid) {
  for (const std::uint32_t n : solid.size) {
    if (n + 1 < 1u << kAxisBits) continue;
    throw ImportError("size", fmt::format("{} points along an axis, {} can be", n, (1u << kAxisBits) - 2),
                      "take larger steps");
  }
  Surface surface;
  Marcher(solid, surface).run();
  return surface;
}

Surface isosurface(const Image& image, float iso) {
  LatticeSolid solid;
  solid.size = image.size;
  solid.layers = {image.values};
  solid.iso = iso;
  solid.mirrored = cellVolume(image) < 0;
  solid.place = [&image](const Double3& at) {
    Double3 x;
    for (std::size_t k = 0; k < 3; ++k) {
      x[k] = image.origin[k];
      for (std::size_t axis = 0; axis < 3; ++axis) x[k] += image.step[axis][k] * at[axis];
    }
    return x;
  };
  return isosurface(solid);
}

std::size_t keepLargest(Surface& surface) {
  std::vector<std::uint32_t> parent(surface.vertices.size());
  std::iota(parent.begin(), parent.end(), 0u);
  const auto root = [&](std::uint32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (const auto& t : surface.triangles) {
    parent[root(t[1])] = root(t[0]);
    parent[root(t[2])] = root(t[0]);
  }
  std::vector<std::size_t> count(parent.size(), 0);
  for (const auto& t : surface.triangles) ++count[root(t[0])];
  const auto parts = static_cast<std::size_t>(std::count_if(count.begin(), count.end(), [](auto n) { return n > 0; }));
  if (parts < 2) return parts;
  const auto largest = static_cast<std::uint32_t>(std::max_element(count.begin(), count.end()) - count.begin());
  Surface kept;
  std::vector<std::uint32_t> place(parent.size(), UINT32_MAX);
  for (auto t : surface.triangles) {
    if (root(t[0]) != largest) continue;
    for (std::uint32_t& v : t) {
      if (place[v] == UINT32_MAX) {
        place[v] = static_cast<std::uint32_t>(kept.vertices.size());
        kept.vertices.push_back(surface.vertices[v]);
      }
      v = place[v];
    }
    kept.triangles.push_back(t);
  }
  surface = std::move(kept);
  return parts;
}

double volumeOf(const Surface& surface) {
  double sum = 0;
  for (const auto& t : surface.triangles) {
    double p[3][3];
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t k = 0; k < 3; ++k) p[c][k] = static_cast<double>(surface.vertices[t[c]][k]);
    sum += p[0][0] * (p[1][1] * p[2][2] - p[1][2] * p[2][1]) + p[0][1] * (p[1][2] * p[2][0] - p[1][0] * p[2][2]) +
           p[0][2] * (p[1][0] * p[2][1] - p[1][1] * p[2][0]);
  }
  return sum / 6;
}

std::string toPly(const Surface& surface) {
  std::string out = fmt::format(
      "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
      "element face {}\nproperty list uchar uint vertex_indices\nend_header\n",
      surface.vertices.size(), surface.triangles.size());
  const std::size_t head = out.size();
  out.resize(head + 12 * surface.vertices.size() + 13 * surface.triangles.size());
  char* at = out.data() + head;
  for (const auto& v : surface.vertices) {
    std::memcpy(at, v.data(), 12);
    at += 12;
  }
  for (const auto& t : surface.triangles) {
    *at++ = 3;
    std::memcpy(at, t.data(), 12);
    at += 12;
  }
  return out;
}

}  // namespace hapticctl_import
