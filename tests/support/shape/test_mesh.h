/** @file
 * Small meshes with a tree, made in the test itself: median splits, no builder process.
 */
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <numeric>
#include <random>
#include <vector>

#include "rt/scene/vertex_motion.h"

namespace hapticd::test {

/** Owns the arrays of a MeshView. Not movable once view() was taken. */
class TestMesh {
 public:
  std::vector<std::array<float, 3>> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<hd_bvh_node> nodes;
  std::uint32_t flags = 0;

  std::uint32_t addVertex(const Vec3& x) {
    vertices.push_back({static_cast<float>(x.x()), static_cast<float>(x.y()), static_cast<float>(x.z())});
    return static_cast<std::uint32_t>(vertices.size() - 1);
  }
  void addTriangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) { triangles.push_back({a, b, c}); }
  void addQuad(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    addTriangle(a, b, c);
    addTriangle(a, c, d);
  }

  /** Each vertex so many times as far from the origin, told for each anew. */
  template <class Factor>
  void scale(Factor&& factor) {
    for (auto& v : vertices) {
      const auto by = static_cast<float>(factor());
      for (float& x : v) x *= by;
    }
  }

  /** Builds the tree (reordering the triangles) and points into the arrays. */
  MeshView* view() {
    nodes.clear();
    depth_ = 0;
    if (!triangles.empty()) build(0, static_cast<std::uint32_t>(triangles.size()), 1);
    view_.vertices = reinterpret_cast<const MeshView::Float3*>(vertices.data());
    view_.triangles = reinterpret_cast<const MeshView::Index3*>(triangles.data());
    view_.nodes = nodes.data();
    view_.vertex_count = static_cast<std::uint32_t>(vertices.size());
    view_.triangle_count = static_cast<std::uint32_t>(triangles.size());
    view_.node_count = static_cast<std::uint32_t>(nodes.size());
    view_.depth = depth_;
    view_.flags = flags;
    corners_.clear();
    for (const auto& t : triangles) corners_.push_back({vertices[t[0]], vertices[t[1]], vertices[t[2]]});
    view_.corners = reinterpret_cast<const MeshView::Corners*>(corners_.data());
    connect();
    view_.neighbours = reinterpret_cast<const MeshView::Index3*>(neighbours_.data());
    return &view_;
  }

  /** The same with what vertex moves need. */
  MeshView* deformableView() {
    view();
    parents_.assign(nodes.size(), HD_NO_INDEX);
    leaf_.assign(triangles.size(), 0);
    for (std::uint32_t n = 0; n < nodes.size(); ++n) {
      for (std::uint32_t c = 0; c < nodes[n].used; ++c) {
        const std::uint32_t place = HD_BVH_WIDTH * n + c;
        if (nodes[n].count[c] == 0) parents_[nodes[n].child[c]] = place;
        for (std::uint32_t i = 0; i < nodes[n].count[c]; ++i) leaf_[nodes[n].child[c] + i] = place;
      }
    }
    first_.clear();
    around_.clear();
    source_.resize(vertices.size());
    std::iota(source_.begin(), source_.end(), 0u);
    for (std::uint32_t v = 0; v < vertices.size(); ++v) {
      first_.push_back(static_cast<std::uint32_t>(around_.size()));
      for (std::uint32_t t = 0; t < triangles.size(); ++t) {
        if (std::count(triangles[t].begin(), triangles[t].end(), v) > 0) around_.push_back(t);
      }
    }
    first_.push_back(static_cast<std::uint32_t>(around_.size()));
    view_.flags |= HD_MESH_DEFORMABLE;
    view_.deform = {reinterpret_cast<MeshView::Float3*>(vertices.data()),
                    reinterpret_cast<MeshView::Corners*>(corners_.data()),
                    nodes.data(),
                    parents_.data(),
                    first_.data(),
                    around_.data(),
                    leaf_.data(),
                    source_.data(),
                    static_cast<std::uint32_t>(source_.size())};
    motion_.assign(vertices.size(), VertexMotion{});
    view_.deform.motion = motion_.data();
    return &view_;
  }

 private:
  Vec3 center(std::uint32_t t) const {
    Vec3 c = Vec3::Zero();
    for (const std::uint32_t v : triangles[t]) c += Vec3(vertices[v][0], vertices[v][1], vertices[v][2]);
    return c / 3;
  }

  /** Edges of two triangles that run opposite ways join them; any other edge is a border. */
  void connect() {
    std::map<std::array<std::uint32_t, 2>, std::array<std::uint32_t, 2>> side;  // directed edge -> triangle, edge
    std::map<std::array<std::uint32_t, 2>, int> uses;
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
      for (std::uint32_t e = 0; e < 3; ++e) {
        const std::array<std::uint32_t, 2> edge{triangles[t][e], triangles[t][(e + 1) % 3]};
        side[edge] = {t, e};
        ++uses[edge];
      }
    }
    neighbours_.assign(triangles.size(), {HD_NO_INDEX, HD_NO_INDEX, HD_NO_INDEX});
    for (const auto& [edge, here] : side) {
      const auto there = side.find({edge[1], edge[0]});
      if (there == side.end() || uses[edge] > 1 || uses[there->first] > 1) continue;
      neighbours_[here[0]][here[1]] = there->second[0];
    }
  }

  /** Sorts a range by its longest side and returns the middle. */
  std::uint32_t halve(std::uint32_t first, std::uint32_t end) {
    Vec3 low = Vec3::Constant(INFINITY), high = -low;
    for (std::uint32_t t = first; t < end; ++t) {
      low = low.cwiseMin(center(t));
      high = high.cwiseMax(center(t));
    }
    int axis = 0;
    (high - low).maxCoeff(&axis);
    std::vector<std::uint32_t> order(end - first);
    std::iota(order.begin(), order.end(), first);
    std::vector<double> key(end - first);
    for (std::uint32_t t = first; t < end; ++t) key[t - first] = center(t)[axis];
    std::stable_sort(order.begin(), order.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return key[a - first] < key[b - first]; });
    std::vector<std::array<std::uint32_t, 3>> sorted;
    sorted.reserve(order.size());
    for (const std::uint32_t t : order) sorted.push_back(triangles[t]);
    std::copy(sorted.begin(), sorted.end(), triangles.begin() + first);
    return first + (end - first) / 2;
  }

  /** A node over the triangles of a range, which is halved three times. */
  std::uint32_t build(std::uint32_t first, std::uint32_t end, std::uint32_t depth) {
    depth_ = std::max(depth_, depth);
    const auto here = static_cast<std::uint32_t>(nodes.size());
    nodes.emplace_back();
    std::vector<std::array<std::uint32_t, 2>> ranges{{first, end}};
    for (int times = 0; times < 3; ++times) {
      std::vector<std::array<std::uint32_t, 2>> halves;
      for (const auto& [from, to] : ranges) {
        if (to - from <= HD_BVH_LEAF_TRIANGLES) {
          halves.push_back({from, to});
        } else {
          const std::uint32_t middle = halve(from, to);
          halves.push_back({from, middle});
          halves.push_back({middle, to});
        }
      }
      ranges = halves;
    }
    nodes[here].used = static_cast<std::uint32_t>(ranges.size());
    for (std::uint32_t c = 0; c < ranges.size(); ++c) {
      const auto [from, to] = ranges[c];
      const bool leaf = to - from <= HD_BVH_LEAF_TRIANGLES;
      const std::uint32_t child = leaf ? from : build(from, to, depth + 1);
      hd_bvh_node& node = nodes[here];
      node.child[c] = child;
      node.count[c] = static_cast<std::uint8_t>(leaf ? to - from : 0);
      for (int i = 0; i < 3; ++i) {
        node.lower[i][c] = INFINITY;
        node.upper[i][c] = -INFINITY;
        for (std::uint32_t t = from; t < to; ++t) {
          for (const std::uint32_t v : triangles[t]) {
            node.lower[i][c] = std::min(node.lower[i][c], vertices[v][i]);
            node.upper[i][c] = std::max(node.upper[i][c], vertices[v][i]);
          }
        }
      }
    }
    return here;
  }

  MeshView view_;
  std::uint32_t depth_ = 0;
  std::vector<std::array<std::uint32_t, 3>> neighbours_;
  std::vector<std::array<std::array<float, 3>, 3>> corners_;
  std::vector<VertexMotion> motion_;
  std::vector<std::uint32_t> parents_, leaf_, first_, around_, source_;
};

/** A tree that holds nothing back: nodes in a row, each with a leaf and the next, boxes about everything. */
inline std::vector<hd_bvh_node> flatTree(std::uint32_t triangles) {
  std::vector<hd_bvh_node> nodes;
  for (std::uint32_t first = 0; first < triangles; first += 255) {
    hd_bvh_node node{};
    for (int i = 0; i < 3; ++i) {
      std::fill_n(node.lower[i], 2, -100.0F);
      std::fill_n(node.upper[i], 2, 100.0F);
    }
    node.child[0] = first;
    node.count[0] = static_cast<std::uint8_t>(std::min(triangles - first, 255u));
    node.child[1] = static_cast<std::uint32_t>(nodes.size() + 1);
    node.used = first + 255 < triangles ? 2 : 1;
    nodes.push_back(node);
  }
  return nodes;
}

/** A closed box, outward. */
inline TestMesh boxMesh(const Vec3& half, const Vec3& center = Vec3::Zero(), bool inward = false) {
  TestMesh m;
  for (int i = 0; i < 8; ++i) {
    m.addVertex(center +
                Vec3(i & 1 ? half.x() : -half.x(), i & 2 ? half.y() : -half.y(), i & 4 ? half.z() : -half.z()));
  }
  const std::uint32_t q[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (const auto& f : q) {
    if (inward) {
      m.addQuad(f[3], f[2], f[1], f[0]);
    } else {
      m.addQuad(f[0], f[1], f[2], f[3]);
    }
  }
  m.flags = HD_MESH_CLOSED;
  return m;
}

/** A sphere of `stacks` x 2 stacks quads, the poles fans: 4 stacks (stacks - 1) triangles. */
inline TestMesh sphereMesh(double radius, std::uint32_t stacks, const Vec3& center = Vec3::Zero()) {
  TestMesh m;
  const std::uint32_t slices = 2 * stacks;
  m.addVertex(center + Vec3(0, 0, radius));
  for (std::uint32_t i = 1; i < stacks; ++i) {
    for (std::uint32_t j = 0; j < slices; ++j) {
      const double theta = M_PI * i / stacks, phi = 2 * M_PI * j / slices;
      m.addVertex(center + radius * Vec3(sin(theta) * cos(phi), sin(theta) * sin(phi), cos(theta)));
    }
  }
  const std::uint32_t south = m.addVertex(center + Vec3(0, 0, -radius));
  const auto at = [&](std::uint32_t i, std::uint32_t j) { return 1 + (i - 1) * slices + j % slices; };
  for (std::uint32_t j = 0; j < slices; ++j) {
    m.addTriangle(0, at(1, j), at(1, j + 1));
    for (std::uint32_t i = 1; i + 1 < stacks; ++i) m.addQuad(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
    m.addTriangle(south, at(stacks - 1, j + 1), at(stacks - 1, j));
  }
  m.flags = HD_MESH_CLOSED;
  return m;
}

/** Closed, with ridges, pits, spikes and thin parts: a sphere whose vertices go in and out. */
inline TestMesh crumpled(std::mt19937& random, std::uint32_t stacks) {
  TestMesh mesh = sphereMesh(1, stacks);
  std::uniform_real_distribution<double> u(0.5, 1.4);
  for (auto& v : mesh.vertices) {
    const double by = u(random);
    for (float& x : v) x = static_cast<float>(x * by);
  }
  return mesh;
}

/** z = f(x, y) over a square of n x n quads, facing +z. Open. */
inline TestMesh heightMesh(double half, std::uint32_t n, const std::function<double(double, double)>& f) {
  TestMesh m;
  for (std::uint32_t j = 0; j <= n; ++j) {
    for (std::uint32_t i = 0; i <= n; ++i) {
      const double x = -half + 2 * half * i / n, y = -half + 2 * half * j / n;
      m.addVertex({x, y, f(x, y)});
    }
  }
  for (std::uint32_t j = 0; j < n; ++j) {
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint32_t a = j * (n + 1) + i;
      m.addQuad(a, a + 1, a + n + 2, a + n + 1);
    }
  }
  return m;
}

}  // namespace hapticd::test
