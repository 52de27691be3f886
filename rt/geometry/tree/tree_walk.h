/** @file
 * The walk through a mesh's tree that all queries share: nearest boxes first, as far as the answer can still get
 * better.
 */
#pragma once

#include <bit>

#include "rt/base/contract.h"
#include "rt/geometry/tree/boxes.h"
#include "rt/scene/mesh_view.h"

namespace hapticd {

/** What a walk has cost: nodes and triangles visited. */
struct Work {
  std::uint32_t& done;
  std::uint32_t limit;
};

/**
 * Asks for a child's memory, so that those of several children come together. Always inline: to g++ 12 a call of a
 * function that only fetches has no effect, and it leaves it out.
 */
[[gnu::always_inline]] inline void fetch(const MeshView& mesh, std::uint32_t child, std::uint32_t count) HD_RT {
  const auto* const from = count > 0 ? reinterpret_cast<const char*>(&mesh.corners[child])
                                     : reinterpret_cast<const char*>(&mesh.nodes[child]);
  constexpr int kLine = 64;
  for (int line = 0; line < 4; ++line) __builtin_prefetch(from + line * kLine);
}

/**
 * Visits the leaves in rising order of the keys that `look(node, key)` gives the children of its mask, each a lower
 * bound of what `leaf(first, count)` can find there, while it is at most `bound()`, which the leaves lower. Of equal
 * keys the first child comes first. False if the work was used up. Servo-safe if look, bound and leaf are.
 */
template <class Look, class Bound, class Leaf>
[[nodiscard]] bool walkTree(const MeshView& mesh, Work work, Look&& look, Bound&& bound, Leaf&& leaf) HD_RT {
  struct Entry {
    std::uint32_t child, count;
    float key;
  };
  Entry stack[(HD_BVH_WIDTH - 1) * HD_BVH_MAX_DEPTH + 1];
  std::uint32_t size = 0;
  if (mesh.node_count == 0) return true;
  stack[size++] = {0, 0, 0};
  while (size > 0) {
    const Entry entry = stack[--size];
    if (entry.key > bound()) continue;
    if (entry.count > 0) {
      work.done += entry.count;
      leaf(entry.child, entry.count);
    } else {
      ++work.done;
      const hd_bvh_node& node = mesh.nodes[entry.child];
      float key[HD_BVH_WIDTH];
      const std::uint32_t base = size;
      for (std::uint32_t mask = look(node, key); mask != 0;) {
        const auto i = static_cast<std::uint32_t>(std::bit_width(mask) - 1);
        mask &= ~(1u << i);
        std::uint32_t at = size++;
        for (; at > base && stack[at - 1].key < key[i]; --at) stack[at] = stack[at - 1];
        stack[at] = {node.child[i], node.count[i], key[i]};
        fetch(mesh, node.child[i], node.count[i]);
      }
    }
    if (work.done > work.limit) return false;
  }
  return true;
}

}  // namespace hapticd
