// A tool in a hole, over a slot and on a blade, each one mesh: several of its edges at once, and sharp ones.
#include <gtest/gtest.h>

#include <vector>

#include "tests/support/random.h"
#include "tests/support/shape/concave_mesh.h"
#include "tests/support/stepped/wandering_tool.h"

namespace hapticd {
namespace {

using test::TestMesh;
using test::Wandered;
using test::Wandering;

constexpr double kWide = 0.05;  ///< Half a ground [m].
constexpr unsigned kSeeds = 2;

/** What of a shape may be in another: places on its ridges, or edges, and balls in it. */
class Features {
 public:
  explicit Features(const Shape& shape) : shape_(shape) {
    if (shape.kind != ShapeKind::kMesh) {
      test::onSurface(shape, [&](const Vec3& x, double radius) { feature_.push_back({x, radius}); });
      return;
    }
    for (std::uint32_t t = 0; t < shape.mesh->triangle_count; ++t) {
      for (int corner = 0; corner < 3; ++corner) addRidge(t, corner);
    }
  }
  /** How deep the deepest is in the other shape. */
  [[nodiscard]] double depthIn(const Features& other, const Pose& X_OS) const {
    double deepest = 0;
    for (const auto& [x, radius] : feature_)
      deepest = std::max(deepest, radius - test::signedGap(other.shape_, X_OS * x));
    return deepest;
  }

 private:
  void addRidge(std::uint32_t t, int corner) {
    constexpr int kPlaces = 50;
    const MeshView& mesh = *shape_.mesh;
    const std::uint32_t across = mesh.neighbours[t][corner];
    const Vec3 from = mesh.vertex(t, corner), to = mesh.vertex(t, (corner + 1) % 3);
    const Vec3 beyond = (mesh.vertex(across, 0) + mesh.vertex(across, 1) + mesh.vertex(across, 2)) / 3 - from;
    const Vec3 out = (to - from).cross(mesh.vertex(t, (corner + 2) % 3) - from).normalized();
    if (across < t || out.dot(beyond) > -1e-6) return;
    for (int i = 0; i <= kPlaces; ++i) feature_.push_back({from + i * (to - from) / kPlaces, 0});
  }

  struct Feature {
    Vec3 x;
    double radius;
  };
  Shape shape_;
  std::vector<Feature> feature_;
};

Shape shapeOf(TestMesh& mesh) {
  Shape shape;
  shape.kind = ShapeKind::kMesh;
  shape.mesh = mesh.view();
  return shape;
}

Wandered wanderOnMesh(const Shape& tool, TestMesh mesh, const Vec3& turn, const Wandering& wandering, Random& random) {
  const auto house = test::houseWithoutFloor();
  const Shape ground = shapeOf(mesh);
  house->meshes.publish(4, ground.mesh);
  if (tool.kind == ShapeKind::kMesh) {
    house->meshes.publish(3, tool.mesh);
    house->reshape(ShapeKind::kMesh, Vec3::Zero(), 3);
  } else {
    house->reshape(tool.kind, tool.size);
  }
  const Vec3 hand(0, 0, 0.11);
  house->aim(hand, turn);
  house->run(500);
  AddObject obstacle = test::object(test::kWall, ShapeKind::kMesh, Vec3::Zero(), Vec3::Zero());
  obstacle.shape.mesh = 4;
  obstacle.material = {1000, 0, 0, 0};
  house->send(CommandKind::kAddObject, obstacle);
  house->hold();
  const Features of_tool(tool), of_ground(ground);
  const auto depth = [&](const Pose& X_WT) {
    return std::max(of_tool.depthIn(of_ground, X_WT), of_ground.depthIn(of_tool, X_WT.inverse()));
  };
  return wanderOver(*house, depth, hand, turn, wandering, random);
}

/** The worst of several hands over a ground that is turned, as if they were. */
template <class MakeMesh>
Wandered wanderOn(const Shape& tool, const Vec3& turn, const MakeMesh& makeMesh, double height = 0,
                  unsigned seeds = kSeeds) {
  Wandered worst;
  for (unsigned seed = 1; seed <= seeds; ++seed) {
    Random random(seed);
    const Quat q = fromRotationVector(random.vector(0.2));
    const Wandering wandering{[&](int) { return Vec3(random.vector(0.03) + height * Vec3::UnitZ()); }};
    const Wandered now = wanderOnMesh(tool, makeMesh(q), turn, wandering, random);
    worst = {std::max(worst.deepest, now.deepest), std::max(worst.shaken, now.shaken)};
  }
  return worst;
}

const Vec3 kStanding = Vec3::Zero(), kLying(1.57, 0, 0);

TestMesh slot(const Quat& q) {
  return test::meshOfCells({{{-kWide, -0.0075, 0.0075, kWide}, {-kWide, kWide}, {-0.01, -0.005, 0.01}}}, q,
                           [](int i, int, int k) { return i != 1 || k == 0; });
}

TestMesh groove(const Quat& q) {
  return test::prismMesh({{0, 0}, {-kWide, kWide}, {-kWide, -0.03}, {kWide, -0.03}, {kWide, kWide}}, kWide, q);
}

/** Of 20 degrees. */
TestMesh blade(const Quat& q) {
  const double half = 0.07 * std::tan(EIGEN_PI / 18);
  return test::prismMesh({{-half, -0.06}, {half, -0.06}, {0, 0.01}}, kWide, q);
}

/** It was told of either edge of the slot in turn, and thrown from one to the other, 1.2 mm deep. */
TEST(ConcaveObstacle, ABallLiesOnBothEdgesOfASlot) {
  const Wandered ball = wanderOn({ShapeKind::kSphere, {0.01, 0, 0}}, kStanding, slot);
  EXPECT_LT(ball.deepest, 2e-5);
  EXPECT_LT(ball.shaken, 500);
}

/** Where two edges of the hole meet, neither was told: a corner of its peg sank in. */
TEST(ConcaveObstacle, APegGoesInAndOutOfAHole) {
  constexpr double kHole = 0.0102;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    Random random(seed);
    const Quat q = fromRotationVector(random.vector(0.2));
    TestMesh plate =
        test::meshOfCells({{{-kWide, -kHole, kHole, kWide}, {-kWide, -kHole, kHole, kWide}, {-0.02, 0.02}}}, q,
                          [](int i, int j, int) { return i != 1 || j != 1; });
    const Wandering wandering{[&](int leg) {
                                const double height = leg % 2 == 0 ? -0.01 : 0.06;
                                return Vec3(random.vector(0.003) + q * Vec3(0, 0, height));
                              },
                              0.0005};
    const Wandered peg = wanderOnMesh({ShapeKind::kBox, {0.01, 0.01, 0.03}}, plate, kStanding, wandering, random);
    EXPECT_LT(peg.deepest, 1e-4);
    EXPECT_LT(peg.shaken, 700);
  }
}

/** Faces that look apart by more than a right angle: what leaned beyond one of them went through the edge. */
TEST(ConcaveObstacle, ADiscLeansOverASharpEdge) {
  EXPECT_LT(wanderOn({ShapeKind::kCylinder, {0.03, 0.003, 0}}, kStanding, groove).deepest, 3e-4);
}

/** Two limbs. */
TestMesh angle() {
  return test::meshOfCells({{{-0.02, 0, 0.02}, {-0.01, 0.01}, {-0.02, 0, 0.02}}}, Quat::Identity(),
                           [](int i, int, int k) { return i == 0 || k == 1; });
}

/** An edge of the ground may be near to either limb, in two places; one was looked for, so the other sank in 2.4 mm. */
TEST(ConcaveObstacle, AnAngleTouchesAnEdgeWithBothLimbs) {
  TestMesh mesh = angle();
  const auto pyramid = [](const Quat& q) { return test::pyramidMesh(0.029, 0.01, -0.06, q); };
  EXPECT_LT(wanderOn(shapeOf(mesh), kStanding, pyramid, 0.01).deepest, 1e-4);
}

/** What is in the angle's corner touches both limbs at one place. */
TEST(ConcaveObstacle, AnAngleHangsOnABlade) {
  TestMesh mesh = angle();
  EXPECT_LT(wanderOn(shapeOf(mesh), kStanding, blade, 0.01).deepest, 1e-4);
}

/** A corner of the tool touches both sides of a groove. */
TEST(ConcaveObstacle, APegStandsOnItsCornerInAGroove) {
  TestMesh mesh = test::boxMesh({0.01, 0.01, 0.03});
  EXPECT_LT(wanderOn(shapeOf(mesh), kStanding, groove, 0.01, 6).deepest, 1e-4);
}

/** A cylinder that leans over a blade: the place where it is said to be lowest is beside that. */
TEST(ConcaveObstacle, ASpokeLiesAlongABlade) { EXPECT_LT(wanderOn(test::kSpoke, kLying, blade, 0, 6).deepest, 1e-4); }

}  // namespace
}  // namespace hapticd
