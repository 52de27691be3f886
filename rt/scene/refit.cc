#include "rt/scene/refit.h"

#include <algorithm>

namespace hapticd {
namespace {

struct Bounds {
  float lower[3], upper[3];
};

/** Stores the box of a child; false if it was the same already. */
bool replaceBox(hd_bvh_node& node, std::uint32_t child, const Bounds& box) HD_RT {
  bool changed = false;
  for (int k = 0; k < 3; ++k) {
    changed |= node.lower[k][child] != box.lower[k] || node.upper[k][child] != box.upper[k];
    node.lower[k][child] = box.lower[k];
    node.upper[k][child] = box.upper[k];
  }
  return changed;
}

Bounds boundsOfLeaf(const MeshView& mesh, std::uint32_t first, std::uint32_t count) HD_RT {
  Bounds box;
  const float(&start)[3] = mesh.corners[first][0];
  std::copy_n(start, 3, box.lower);
  std::copy_n(start, 3, box.upper);
  for (std::uint32_t t = first; t < first + count; ++t) {
    for (const auto& corner : mesh.corners[t]) {
      for (int k = 0; k < 3; ++k) {
        box.lower[k] = std::min(box.lower[k], corner[k]);
        box.upper[k] = std::max(box.upper[k], corner[k]);
      }
    }
  }
  return box;
}

Bounds boundsOfNode(const hd_bvh_node& node) HD_RT {
  Bounds box;
  for (int k = 0; k < 3; ++k) {
    box.lower[k] = *std::min_element(node.lower[k], node.lower[k] + node.used);
    box.upper[k] = *std::max_element(node.upper[k], node.upper[k] + node.used);
  }
  return box;
}

}  // namespace

void Refit::add(std::uint32_t triangle) HD_RT {
  const std::uint32_t place = mesh_.deform.triangle_leaf[triangle];
  if (count_ > 0 && place_[count_ - 1] == place) return;
  if (count_ == kMost) finish();
  place_[count_++] = place;
}

void Refit::finish() HD_RT {
  // Upward, level by level: a box that changed has its parent computed again, even if a shorter branch did so already.
  // So every box is exact in the end; one that did not change ends the climb.
  while (count_ > 0) {
    std::sort(place_, place_ + count_);
    const std::uint32_t* const end = std::unique(place_, place_ + count_);
    count_ = 0;
    for (const std::uint32_t* at = place_; at != end; ++at) climb(*at);
  }
}

/** Makes the box of that place anew; if it has changed the one above is next. Notes no more than it has been given. */
void Refit::climb(std::uint32_t place) HD_RT {
  const MeshView::Deform& d = mesh_.deform;
  const std::uint32_t n = place / HD_BVH_WIDTH, child = place % HD_BVH_WIDTH;
  hd_bvh_node& node = d.nodes[n];
  const bool leaf = node.count[child] > 0;
  const Bounds box =
      leaf ? boundsOfLeaf(mesh_, node.child[child], node.count[child]) : boundsOfNode(d.nodes[node.child[child]]);
  if (!replaceBox(node, child, box) || d.parents[n] == HD_NO_INDEX) return;
  if (count_ == 0 || place_[count_ - 1] != d.parents[n]) place_[count_++] = d.parents[n];
}

}  // namespace hapticd
