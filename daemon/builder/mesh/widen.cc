#include <algorithm>
#include <array>

#include "daemon/builder/mesh/bvh.h"

namespace hapticd {
namespace {

float halfArea(const BinaryNode& n) {
  const float x = n.upper[0] - n.lower[0], y = n.upper[1] - n.lower[1], z = n.upper[2] - n.lower[2];
  return x * y + y * z + z * x;
}

/** Up to eight nodes of the binary tree that together are `root`, from left to right. */
struct Children {
  std::array<std::uint32_t, HD_BVH_WIDTH> node{};
  std::uint32_t count = 1;

  Children(const std::vector<BinaryNode>& binary, std::uint32_t root) {
    node[0] = root;
    while (count < HD_BVH_WIDTH) {
      std::uint32_t widest = count;
      for (std::uint32_t i = 0; i < count; ++i) {
        if (binary[node[i]].count != 0) continue;
        if (widest == count || halfArea(binary[node[i]]) > halfArea(binary[node[widest]])) widest = i;
      }
      if (widest == count) return;
      std::copy_backward(node.begin() + widest + 1, node.begin() + count, node.begin() + count + 1);
      const std::uint32_t left = binary[node[widest]].first;
      node[widest] = left;
      node[widest + 1] = left + 1;
      ++count;
    }
  }
};

}  // namespace

std::vector<hd_bvh_node> widen(const std::vector<BinaryNode>& binary, std::uint32_t& depth) {
  struct Task {
    std::uint32_t binary, parent, child, depth;
  };
  std::vector<hd_bvh_node> nodes;
  nodes.reserve(binary.size() / 8 + 1);
  depth = 0;
  std::vector<Task> stack{{0, HD_NO_INDEX, 0, 1}};
  while (!stack.empty()) {
    const Task task = stack.back();
    stack.pop_back();
    depth = std::max(depth, task.depth);
    const auto here = static_cast<std::uint32_t>(nodes.size());
    if (task.parent != HD_NO_INDEX) nodes[task.parent].child[task.child] = here;
    hd_bvh_node& node = nodes.emplace_back();
    const Children children(binary, task.binary);
    node.used = children.count;
    for (std::uint32_t c = children.count; c-- > 0;) {  // The first child is to come next.
      const BinaryNode& from = binary[children.node[c]];
      for (int k = 0; k < 3; ++k) {
        node.lower[k][c] = from.lower[k];
        node.upper[k][c] = from.upper[k];
      }
      node.count[c] = static_cast<std::uint8_t>(from.count);
      node.child[c] = from.first;
      if (from.count == 0) stack.push_back({children.node[c], here, c, task.depth + 1});
    }
  }
  return nodes;
}

}  // namespace hapticd
