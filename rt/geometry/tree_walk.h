/** @file
 * The walk through a mesh's tree that all queries share: nearest boxes first, as far as the answer can still get
 * better.
 */
#pragma once

#include <limits>
#include <utility>

#include "rt/scene/mesh_view.h"

namespace hapticd {

/** What a walk has cost: nodes and triangles visited. */
struct Work {
  std::uint32_t& done;
  std::uint32_t limit;
};

/**
 * Visits the leaves in rising order of `key(node)`, a lower bound of what `leaf(first, count)` can find there, while
 * it is at most `bound`, which the leaves lower. Infinity: never. False if the work was used up. Servo-safe if key and
 * leaf are.
 */
template <class Key, class Leaf>
[[nodiscard]] bool walkTree(const MeshView& mesh, Work work, const double& bound, Key&& key, Leaf&& leaf) HD_RT {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  struct Entry {
    std::uint32_t node;
    double key;
  };
  Entry stack[HD_BVH_MAX_DEPTH + 1];
  std::uint32_t size = 0;
  if (mesh.node_count == 0) return true;
  ++work.done;
  if (const double k = key(mesh.nodes[0]); k < kNever) stack[size++] = {0, k};
  while (size > 0) {
    const Entry entry = stack[--size];
    if (entry.key > bound) continue;
    const hd_bvh_node& node = mesh.nodes[entry.node];
    if (node.count > 0) {
      work.done += node.count;
      leaf(node.first, node.count);
    } else {
      work.done += 2;
      Entry near{node.first, key(mesh.nodes[node.first])};
      Entry far{node.first + 1, key(mesh.nodes[node.first + 1])};
      if (far.key < near.key) std::swap(near, far);
      if (far.key < kNever) stack[size++] = far;
      if (near.key < kNever) stack[size++] = near;
    }
    if (work.done > work.limit) return false;
  }
  return true;
}

/** Squared distance from x to the node's box; 0 within. */
[[nodiscard]] inline double squaredDistance(const hd_bvh_node& node, const Vec3& x) HD_RT {
  double sum = 0;
  for (int i = 0; i < 3; ++i) {
    const double outside = std::max(std::max(double{node.lower[i]} - x[i], x[i] - double{node.upper[i]}), 0.0);
    sum += outside * outside;
  }
  return sum;
}

}  // namespace hapticd
