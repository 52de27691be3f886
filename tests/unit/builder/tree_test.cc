// The tree against brute force: shape, boxes, bounds, refit.
#include <algorithm>
#include <map>
#include <set>

#include "rt/scene/refit.h"
#include "tests/support/seeds.h"
#include "tests/unit/builder/built.h"

namespace hapticd::test {
namespace {

struct ExactBox {
  float lower[3], upper[3];
};

ExactBox boxOfTriangles(const MeshView& mesh, std::uint32_t first, std::uint32_t count) {
  ExactBox box;
  std::fill_n(box.lower, 3, std::numeric_limits<float>::infinity());
  std::fill_n(box.upper, 3, -std::numeric_limits<float>::infinity());
  for (std::uint32_t t = first; t < first + count; ++t)
    for (const std::uint32_t v : mesh.triangles[t])
      for (int k = 0; k < 3; ++k) {
        box.lower[k] = std::min(box.lower[k], mesh.vertices[v][k]);
        box.upper[k] = std::max(box.upper[k], mesh.vertices[v][k]);
      }
  return box;
}

/** Recursive: the box of each child is exactly that of its triangles; returns all of them in order. */
std::vector<std::uint32_t> checkNode(const MeshView& mesh, std::uint32_t n, std::uint32_t depth,
                                     std::uint32_t& deepest) {
  const hd_bvh_node& node = mesh.nodes[n];
  deepest = std::max(deepest, depth);
  EXPECT_GE(node.used, 1u);
  EXPECT_LE(node.used, HD_BVH_WIDTH);
  std::vector<std::uint32_t> all;
  for (std::uint32_t c = 0; c < node.used; ++c) {
    std::vector<std::uint32_t> triangles;
    if (node.count[c] != 0) {
      EXPECT_LE(node.count[c], HD_BVH_LEAF_TRIANGLES);
      for (std::uint32_t i = 0; i < node.count[c]; ++i) triangles.push_back(node.child[c] + i);
    } else {
      EXPECT_GT(node.child[c], n);
      triangles = checkNode(mesh, node.child[c], depth + 1, deepest);
    }
    // In leaf order the triangles of a subtree are one range.
    EXPECT_EQ(triangles.back() - triangles.front() + 1, triangles.size());
    const ExactBox box = boxOfTriangles(mesh, triangles.front(), static_cast<std::uint32_t>(triangles.size()));
    for (int k = 0; k < 3; ++k) {
      EXPECT_EQ(box.lower[k], node.lower[k][c]) << n;
      EXPECT_EQ(box.upper[k], node.upper[k][c]) << n;
    }
    all.insert(all.end(), triangles.begin(), triangles.end());
  }
  return all;
}

void checkTree(const MeshView& mesh) {
  std::uint32_t deepest = 0;
  const auto all = checkNode(mesh, 0, 1, deepest);
  EXPECT_EQ(all.size(), mesh.triangle_count);
  EXPECT_EQ(deepest, mesh.depth);
  EXPECT_LE(deepest, HD_BVH_MAX_DEPTH);
}

TEST(Tree, BoxesAreExactAndEveryTriangleIsInOneLeaf) {
  for (const UploadMesh& mesh : {cube(), torus(30, 17), terrain(40, 5), torus(30, 17).soup()})
    checkTree(build(mesh).memory.view);
  UploadMesh one;
  one.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  one.triangles = {{0, 1, 2}};
  const Built single = build(one);
  checkTree(single.memory.view);
  EXPECT_EQ(single.stats.nodes, 1u);
}

TEST(Tree, TheTrianglesAreThoseOfTheUpload) {
  const UploadMesh mesh = torus(25, 13);
  const Built built = build(mesh);
  using Corners = std::array<Float3, 3>;
  const auto canonical = [](Corners c) {
    std::rotate(c.begin(), std::min_element(c.begin(), c.end()), c.end());  // winding kept
    return c;
  };
  std::multiset<Corners> expected, got;
  for (const Index3& t : mesh.triangles)
    expected.insert(canonical({mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]}));
  const MeshView& view = built.memory.view;
  for (std::uint32_t t = 0; t < view.triangle_count; ++t) {
    Corners c;
    for (int k = 0; k < 3; ++k) std::copy_n(view.vertices[view.triangles[t][k]], 3, c[k].begin());
    got.insert(canonical(c));
  }
  EXPECT_EQ(got, expected);
}

TEST(Tree, NeighboursAreThoseOfBruteForce) {
  UploadMesh mesh = terrain(12, 2);
  mesh.triangles.erase(mesh.triangles.begin() + 100);  // a hole
  const Built built = build(mesh);
  const MeshView& view = built.memory.view;
  const auto edge = [&](std::uint32_t t, int e) {
    return std::pair(view.triangles[t][e], view.triangles[t][(e + 1) % 3]);
  };
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> owner;
  for (std::uint32_t t = 0; t < view.triangle_count; ++t)
    for (int e = 0; e < 3; ++e) owner[edge(t, e)] = t;
  for (std::uint32_t t = 0; t < view.triangle_count; ++t)
    for (int e = 0; e < 3; ++e) {
      const auto [a, b] = edge(t, e);
      const auto across = owner.find({b, a});
      EXPECT_EQ(view.neighbours[t][e], across == owner.end() ? HD_NO_INDEX : across->second);
    }
}

TEST(Tree, StaysShallowWhereSplitsPeelOffOneByOne) {
  // Triangles at 2^-k: the surface area heuristic cuts off a few at a time, in three directions.
  UploadMesh mesh;
  for (int k = 0; k < 120; ++k)
    for (int axis = 0; axis < 3; ++axis)
      for (int copy = 0; copy < 6; ++copy) {
        const float x = std::ldexp(1.0f, -k) * (1 + 0.01f * static_cast<float>(copy));
        const auto base = static_cast<std::uint32_t>(mesh.vertices.size());
        Float3 p{}, q{}, r{};
        p[axis] = x;
        q[axis] = x * 1.001f;
        r[axis] = x;
        r[(axis + 1) % 3] = x * 0.001f;
        mesh.vertices.insert(mesh.vertices.end(), {p, q, r});
        mesh.triangles.push_back({base, base + 1, base + 2});
      }
  const Built built = build(mesh);
  EXPECT_GT(built.stats.triangles, 2000u);
  checkTree(built.memory.view);
}

TEST(Tree, EqualCentresSplitAtTheMedian) {
  UploadMesh mesh;  // stars about one centre: nothing to bin by
  for (int i = 0; i < 1000; ++i) {
    const float s = 1.0f + static_cast<float>(i);
    const auto base = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), {{-s / 16, -s / 16, 0}, {s / 16, s / 16, 0}, {-s / 16, s / 16, 0}});
    mesh.triangles.push_back({base, base + 1, base + 2});
  }
  const Built built = build(mesh);
  EXPECT_EQ(built.stats.triangles, 1000u);
  EXPECT_LE(built.stats.depth, 9u) << "no deeper than halves: ceil(log2(1000 / 4)) + 1";
  checkTree(built.memory.view);
}

/** Expected cost of a random ray by the surface area heuristic: nodes entered and triangles tested, at 1 each. */
double cost(const MeshView& mesh) {
  const auto area = [](const double(&d)[3]) { return d[0] * d[1] + d[1] * d[2] + d[2] * d[0]; };
  double sum = 0;
  for (std::uint32_t i = 0; i < mesh.node_count; ++i) {
    const hd_bvh_node& n = mesh.nodes[i];
    for (std::uint32_t c = 0; c < n.used; ++c) {
      const double d[3] = {double{n.upper[0][c]} - n.lower[0][c], double{n.upper[1][c]} - n.lower[1][c],
                           double{n.upper[2][c]} - n.lower[2][c]};
      sum += area(d) * std::max(1, int{n.count[c]});
    }
  }
  const hd_bvh_node& root = mesh.nodes[0];
  double whole[3];
  for (int k = 0; k < 3; ++k) {
    whole[k] = double{*std::max_element(root.upper[k], root.upper[k] + root.used)} -
               *std::min_element(root.lower[k], root.lower[k] + root.used);
  }
  return sum / area(whole);
}

TEST(Tree, NodesAreWellFilled) {
  const Built built = build(torus(120, 60));
  EXPECT_LT(built.stats.nodes * 10, built.stats.triangles);
}

TEST(Tree, CostGrowsWithTheLogarithm) {
  // A surface tree by areas costs about a constant per level: 16 times the triangles, four more levels.
  const double small = cost(build(torus(60, 30)).memory.view), large = cost(build(torus(240, 120)).memory.view);
  EXPECT_LT(large, small * 1.6);
}

/** One by one, as many as a message holds, and more than are noted at once. */
TEST(Refit, EqualsABuildOfTheMovedMesh) {
  for (const int batch : {1, 26, 400}) {
    Built built = build(torus(40, 21).soup(), HD_MESH_DEFORMABLE);
    MeshView& mesh = built.memory.view;
    ASSERT_NE(mesh.deform.vertices, nullptr);
    std::mt19937 random(seedOf(7));
    std::uniform_real_distribution<float> place(-0.1f, 0.1f);
    std::uniform_int_distribution<std::uint32_t> pick(0, mesh.deform.source_count - 1);
    for (int round = 0; round < 40; ++round) {
      Refit refit(mesh);
      for (int i = 0; i < batch; ++i) {
        const std::uint32_t v = pick(random);
        const float p[3] = {place(random), place(random), place(random)};
        ASSERT_EQ(moveVertex(mesh, v, p, refit), ErrorCode::kOk);
        EXPECT_EQ(mesh.vertices[mesh.deform.source_vertex[v]][0], p[0]);
      }
      refit.finish();
      if (batch > 1 || round % 10 == 0) checkTree(mesh);
    }
    checkTree(mesh);
  }
}

TEST(Refit, ShrinksBackToTheFormerBoxes) {
  Built built = build(torus(20, 11), HD_MESH_DEFORMABLE);
  MeshView& mesh = built.memory.view;
  const std::vector<hd_bvh_node> before(mesh.nodes, mesh.nodes + mesh.node_count);
  const std::uint32_t here = mesh.deform.source_vertex[5];
  const float home[3] = {mesh.vertices[here][0], mesh.vertices[here][1], mesh.vertices[here][2]};
  ASSERT_EQ(moveVertex(mesh, 5, {50, 50, 50}), ErrorCode::kOk);
  EXPECT_EQ(*std::max_element(mesh.nodes[0].upper[0], mesh.nodes[0].upper[0] + mesh.nodes[0].used), 50.0f);
  ASSERT_EQ(moveVertex(mesh, 5, home), ErrorCode::kOk);
  EXPECT_EQ(std::memcmp(before.data(), mesh.nodes, before.size() * sizeof(hd_bvh_node)), 0);
}

TEST(Refit, RefusesWithoutChange) {
  Built built = build(cube(), HD_MESH_DEFORMABLE);
  MeshView& mesh = built.memory.view;
  const std::vector<hd_bvh_node> before(mesh.nodes, mesh.nodes + mesh.node_count);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(moveVertex(mesh, 0, {0, nan, 0}), ErrorCode::kInvalidArgument);
  EXPECT_EQ(moveVertex(mesh, 0, {0, 0, 101}), ErrorCode::kInvalidArgument);
  EXPECT_EQ(moveVertex(mesh, 8, {0, 0, 0}), ErrorCode::kNotFound);
  EXPECT_EQ(std::memcmp(before.data(), mesh.nodes, before.size() * sizeof(hd_bvh_node)), 0);
  Built rigid = build(cube());
  EXPECT_EQ(moveVertex(rigid.memory.view, 0, {0, 0, 0}), ErrorCode::kUnsupported);
}

}  // namespace
}  // namespace hapticd::test
