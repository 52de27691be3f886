// Which triangle lies across each edge.
#include <fmt/core.h>

#include <algorithm>

#include "daemon/builder/mesh/counted.h"
#include "daemon/builder/mesh/mesh.h"

namespace hapticd {

void connect(Mesh& mesh, BuildMonitor& monitor) {
  // Half-edges by their lower vertex (counting sort), then within one such bucket by the higher one. A half-edge is one
  // 64-bit word: higher vertex, triangle * 4 + edge. 16 M triangles * 4 fit 32 bits.
  static_assert(std::uint64_t{HD_MAX_TRIANGLES} * 4 <= UINT32_MAX);
  std::vector<std::uint32_t> start(mesh.vertices.size() + 1, 0);
  for (const Index3& v : mesh.triangles)
    for (int e = 0; e < 3; ++e) ++start[std::min(v[e], v[(e + 1) % 3]) + 1];
  for (std::size_t i = 1; i < start.size(); ++i) start[i] += start[i - 1];
  std::vector<std::uint64_t> half(mesh.triangles.size() * 3);
  std::vector<std::uint32_t> fill(start.begin(), start.end() - 1);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const Index3& v = mesh.triangles[t];
    for (std::uint32_t e = 0; e < 3; ++e) {
      const auto [low, high] = std::minmax(v[e], v[(e + 1) % 3]);
      half[fill[low]++] = std::uint64_t{high} << 32 | (t * 4 + e);
    }
  }

  mesh.neighbours.assign(mesh.triangles.size(), {HD_NO_INDEX, HD_NO_INDEX, HD_NO_INDEX});
  std::size_t crowded = 0;
  std::uint32_t first_crowded = HD_NO_INDEX;
  for (std::size_t b = 0; b + 1 < start.size(); ++b) {
    std::sort(half.begin() + start[b], half.begin() + start[b + 1]);
    for (std::uint32_t i = start[b]; i < start[b + 1];) {
      std::uint32_t end = i + 1;
      while (end < start[b + 1] && half[end] >> 32 == half[i] >> 32) ++end;
      const auto triangleOf = [&](std::uint32_t k) { return static_cast<std::uint32_t>(half[k]) / 4; };
      if (end - i == 2) {
        const std::uint32_t s = triangleOf(i), t = triangleOf(i + 1);
        mesh.neighbours[s][half[i] & 3] = t;
        mesh.neighbours[t][half[i + 1] & 3] = s;
      } else if (end - i > 2) {
        ++crowded;
        for (std::uint32_t k = i; k < end; ++k)
          first_crowded = std::min(first_crowded, mesh.source_triangle[triangleOf(k)]);
      }
      i = end;
    }
  }
  if (crowded != 0) {
    monitor.notes.push_back(
        fmt::format("{} to more than two triangles, the first at triangle {}; each counts as a border",
                    counted(crowded, "edge belongs", "edges belong"), first_crowded));
  }
}

}  // namespace hapticd
