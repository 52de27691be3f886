/** @file
 * What a tool is told of an obstacle that it hardly touches, of any kind, against the nearest places of convex bodies.
 */
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "rt/collide/scene_contacts.h"
#include "rt/collide/tool_points.h"
#include "rt/geometry/nearest/nearest.h"
#include "tests/support/for_seeds.h"
#include "tests/support/random.h"
#include "tests/support/shape/test_mesh.h"

namespace hapticd {
namespace {

/** A convex body of some millimetres to centimetres. */
struct ConvexBody {
  explicit ConvexBody(Random& random) {
    const double size = std::pow(10, random.in(-2.2, -1.3));
    const auto length = [&] { return size * random.in(0.4, 1.5); };
    const int kind = random.below(6);
    for (double& x : shape.size) x = length();
    if (kind < 4) {
      shape.kind = std::array{ShapeKind::kSphere, ShapeKind::kCapsule, ShapeKind::kCylinder, ShapeKind::kBox}[kind];
      return;
    }
    mesh = kind == 4 ? test::boxMesh(shape.size) : test::sphereMesh(shape.size.x(), 5 + random.below(8u));
    mesh.flags = HD_MESH_CLOSED;
    shape.kind = ShapeKind::kMesh;
    shape.mesh = mesh.view();
  }

  /** The point of the body nearest to x, in the world. */
  [[nodiscard]] Vec3 nearestTo(const Vec3& x) const {
    NearestQuery query;
    query.x = X_WO.inverse() * x;
    query.limit = 1'000'000;
    Nearest nearest;
    EXPECT_EQ(nearestOnShape(shape, query, nearest), NearestResult::kFound);
    return nearest.isInside(query.x) ? x : X_WO * nearest.point;
  }

  /** Of all of it the farthest along a direction of the world. */
  [[nodiscard]] double support(const Vec3& along) const {
    const Vec3 n = X_WO.q.conjugate() * along, size = shape.size;
    const double middle = along.dot(X_WO.p);
    switch (shape.kind) {
      case ShapeKind::kSphere:
        return middle + size.x();
      case ShapeKind::kCapsule:
        return middle + size.x() + size.y() * std::abs(n.z());
      case ShapeKind::kCylinder:
        return middle + size.x() * n.head<2>().norm() + size.y() * std::abs(n.z());
      case ShapeKind::kBox:
        return middle + size.dot(n.cwiseAbs());
      default: {
        double most = -INFINITY;
        for (const auto& v : mesh.vertices) most = std::max(most, n.dot(Vec3(v[0], v[1], v[2])));
        return middle + most;
      }
    }
  }

  /** Out of its faces, in the world; of a mantle in many directions. */
  [[nodiscard]] std::vector<Vec3> outOfFaces() const {
    std::vector<Vec3> all;
    const auto add = [&](const Vec3& n) { all.push_back(X_WO.q * n); };
    for (int i = shape.kind == ShapeKind::kCylinder ? 2 : 0; i < 3; ++i) {
      if (shape.kind != ShapeKind::kCylinder && shape.kind != ShapeKind::kBox) break;
      add(Vec3::Unit(i));
      add(-Vec3::Unit(i));
    }
    constexpr int kAround = 4096;
    for (int i = 0; shape.kind == ShapeKind::kCylinder && i < kAround; ++i) {
      const double turn = 2 * EIGEN_PI * i / kAround;
      add(Vec3(std::cos(turn), std::sin(turn), 0));
    }
    const auto at = [&](std::uint32_t v) {
      return Vec3(mesh.vertices[v][0], mesh.vertices[v][1], mesh.vertices[v][2]);
    };
    for (const auto& t : mesh.triangles) add((at(t[1]) - at(t[0])).cross(at(t[2]) - at(t[0])).normalized());
    return all;
  }

  Shape shape;
  test::TestMesh mesh;
  Pose X_WO;
};

/** From the second to the first, where they are nearest, by going to and fro between them (von Neumann). */
Vec3 wayBetween(const ConvexBody& first, const ConvexBody& second) {
  constexpr int kMost = 20'000, kLookEvery = 20;
  Vec3 x = first.X_WO.p, way = Vec3::Zero();
  double last = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kMost; ++i) {
    const Vec3 y = second.nearestTo(x);
    x = first.nearestTo(y);
    way = x - y;
    if (i % kLookEvery > 0) continue;
    if (last - way.norm() < 1e-13) break;
    last = way.norm();
  }
  return way;
}

/** How far the first must go to be out, along that way or out of a face of either. */
double wayOut(const ConvexBody& first, const ConvexBody& second, const Vec3& out) {
  double least = second.support(out) + first.support(-out);
  for (const Vec3& n : second.outOfFaces()) least = std::min(least, second.support(n) + first.support(-n));
  for (const Vec3& n : first.outOfFaces()) least = std::min(least, second.support(-n) + first.support(n));
  return least;
}

/** Wherever its corners, edges and faces come on those of the obstacle. */
TEST(ContactsProperty, OfTwoThatAreInEachOtherByAHairATouchIsToldThatDeep) {
  constexpr double kHair = 2e-5;
  const auto contacts = std::make_unique<SceneContacts>(1);
  forSeeds(1000, [&](unsigned seed) {
    Random random(seed);
    ConvexBody tool(random), obstacle(random);
    tool.X_WO = random.pose(0.1);
    obstacle.X_WO = {tool.X_WO.p + 0.3 * random.vector(1).normalized(), random.turn()};
    const Vec3 way = wayBetween(tool, obstacle), out = way.normalized();
    tool.X_WO.p -= way + kHair * out;  // Along that way all of it goes in by no more than so far.

    CollideRequest::Held held;
    held.object = makeObjectId(9, 1);
    held.shape = tool.shape;
    held.shape.number = seed + 1;
    held.X_WO = tool.X_WO;
    held.count = 1;
    held.obstacle[0] = {7, obstacle.shape, obstacle.X_WO, {}};
    ContactModel model;
    DetectorReport report;
    contacts->find(held, 0.003, {400'000, 0, nullptr}, model, report);
    double deepest = -1;
    for (std::uint32_t i = 0; i < model.count; ++i) {
      deepest = std::max(deepest, -model.touch(i, tool.X_WO, tool.X_WO.p, obstacle.X_WO, {}).gap);
    }
    // A cylinder's rim is points 11 degrees apart: between two it is lower by half a hundredth of its radius. And what
    // a disc says is that deep in a plane, which what is round or edged leaves.
    const bool discs = tool.shape.kind == ShapeKind::kCylinder;
    const double between = discs ? 0.005 * tool.shape.size.x() : 0;
    if (!discs) {
      EXPECT_LT(deepest, 6 * kHair);  // One of 13,000 is told more than three times too deep.
    }
    EXPECT_GT(deepest, 0.5 * wayOut(tool, obstacle, out) - between) << model.count << " touches";
  });
}

/** Two blades across a bar, each between its points, of a mesh whose origin is so far from them. */
ContactModel bladesOn(const Shape& bar, const Pose& X_WB, double far) {
  test::TestMesh blades;
  blades.flags = HD_MESH_CLOSED;
  for (const double x : {-0.012, 0.012}) {
    const test::TestMesh blade = test::boxMesh({0.002, 0.02, 0.003}, {x + far, 0, 0.003});
    const auto first = static_cast<std::uint32_t>(blades.vertices.size());
    blades.vertices.insert(blades.vertices.end(), blade.vertices.begin(), blade.vertices.end());
    for (const auto& t : blade.triangles) blades.addTriangle(first + t[0], first + t[1], first + t[2]);
  }
  CollideRequest::Held held;
  held.object = makeObjectId(9, 1);
  held.shape.kind = ShapeKind::kMesh;
  held.shape.mesh = blades.view();
  held.X_WO.p = {-far, 0, -5e-6};
  held.count = 1;
  held.obstacle[0] = {7, bar, X_WB, {}};
  ContactModel model;
  DetectorReport report;
  std::make_unique<SceneContacts>(1)->find(held, 0.003, {400'000, 0, nullptr}, model, report);
  for (ContactModel::Point& point : model.point) point.p_A[0] -= static_cast<float>(far);
  return model;
}

/** As of what is drawn where it stands in a machine: both blades once lay on the bar as one, or on nothing. */
TEST(ContactsProperty, AToolMayHaveItsOriginFarFromIt) {
  test::TestMesh bar = test::boxMesh({0.3, 0.004, 0.004});
  const Shape box{ShapeKind::kBox, {0.3, 0.004, 0.004}}, pipe{ShapeKind::kCapsule, {0.005, 0.3, 0}};
  Shape mesh{ShapeKind::kMesh, Vec3::Zero()};
  mesh.mesh = bar.view();
  const Quat on_edge(Eigen::AngleAxisd(EIGEN_PI / 4, Vec3::UnitX()));
  const Quat along_x(Eigen::AngleAxisd(EIGEN_PI / 2, Vec3::UnitY()));
  const Vec3 edge(0, 0, -0.004 * std::sqrt(2)), mantle(0, 0, -0.005);
  for (const double far : {0.0, 0.1, 0.3, 1.0}) {
    for (const auto& [on, X_WB] :
         {std::pair{box, Pose{edge, on_edge}}, {mesh, {edge, on_edge}}, {pipe, {mantle, along_x}}}) {
      const ContactModel model = bladesOn(on, X_WB, far);
      int left = 0, right = 0;
      for (std::uint32_t i = 0; i < model.count; ++i) {
        const float x = model.point[i].p_A[0];
        left += std::abs(x + 0.012) < 0.0021;
        right += std::abs(x - 0.012) < 0.0021;
      }
      EXPECT_GT(left, 0) << far << " on " << static_cast<int>(on.kind);
      EXPECT_GT(right, 0) << far << " on " << static_cast<int>(on.kind);
    }
  }
}

/** A pyramid on its tip, which is its origin. */
test::TestMesh tipMesh(double size) {
  test::TestMesh m;
  m.addVertex(Vec3::Zero());
  for (const auto& [x, y] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) m.addVertex(size * Vec3(x, y, 2));
  for (std::uint32_t i = 0; i < 4; ++i) m.addTriangle(0, 1 + (i + 1) % 4, 1 + i);
  m.addQuad(1, 2, 3, 4);
  m.flags = HD_MESH_CLOSED;
  return m;
}

/** The edge asks within it, and from there a tip on the face is neither as far nor where the face says. */
TEST(ContactsProperty, ATipOnAFaceIsNotPushedOffAnEdgeBesideIt) {
  const Vec3 half(0.02, 0.02, 0.01);
  test::TestMesh tip = tipMesh(0.005), block = test::boxMesh(half);
  block.flags = HD_MESH_CLOSED;
  Shape box{ShapeKind::kBox, half}, mesh{ShapeKind::kMesh, Vec3::Zero()}, can{ShapeKind::kCylinder, {0.02, 0.01, 0}};
  mesh.mesh = block.view();
  CollideRequest::Held held;
  held.object = makeObjectId(9, 1);
  held.shape.kind = ShapeKind::kMesh;
  held.shape.mesh = tip.view();
  held.count = 1;
  for (const Shape& shape : {box, mesh, can}) {
    for (const double beside : {3e-5, 6e-5, 1e-4, 1.5e-4, 1.9e-4}) {
      for (const double above : {-5e-6, 5e-6}) {
        held.X_WO.p = {0.02 - beside, 0.0013, 0.01 + above};
        if (shape.kind == ShapeKind::kCylinder) held.X_WO.p.y() = 0;
        held.obstacle[0] = {7, shape, Pose{}, {}};
        ContactModel model;
        DetectorReport report;
        std::make_unique<SceneContacts>(1)->find(held, 0.003, {400'000, 0, nullptr}, model, report);
        ASSERT_GT(model.count, 0u);
        for (std::uint32_t i = 0; i < model.count; ++i) {
          EXPECT_GT(model.touch(i, held.X_WO, held.X_WO.p, Pose{}, {}).gap, above - 1e-6)
              << beside << " " << static_cast<int>(shape.kind);
        }
      }
    }
  }
}

/** One vertex of thousands, where the origin is: hardly ever one of those that are its points. */
TEST(ContactsProperty, ATipFarFromAToolsManyVerticesIsOfIt) {
  const auto handle = [](double x, double y) { return 0.1 - 1e-3 * std::cos(500 * x) * std::cos(500 * y); };
  test::TestMesh probe = test::heightMesh(0.02, 80, handle);
  const std::uint32_t tip = probe.addVertex(Vec3::Zero());
  for (const std::uint32_t v : {0u, 3000u, 6000u}) probe.addTriangle(tip, v, v + 1);
  Shape shape{ShapeKind::kMesh, Vec3::Zero()};
  shape.mesh = probe.view();
  ASSERT_GT(shape.mesh->vertex_count, 2 * ToolPoints::kMost);
  const auto points = std::make_unique<ToolPoints>();
  points->make(shape);
  for (const auto& v : probe.vertices)
    EXPECT_LE((Vec3(v[0], v[1], v[2]) - points->middle()).norm(), points->reach() * (1 + 1e-9));
}

}  // namespace
}  // namespace hapticd
