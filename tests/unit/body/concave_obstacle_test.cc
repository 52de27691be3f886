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
constexpr int kSeeds = 2;

/** Where the tool's edges, or balls in it, are in the mesh, and the mesh's ridges in the tool. */
class DepthInMesh {
 public:
  DepthInMesh(const Shape& tool, MeshView* mesh) : tool_(tool) {
    ground_.kind = ShapeKind::kMesh;
    ground_.mesh = mesh;
    for (std::uint32_t t = 0; t < mesh->triangle_count; ++t) {
      for (int corner = 0; corner < 3; ++corner) addRidge(t, corner);
    }
  }
  double operator()(const Pose& X_WT) const {
    double deepest = 0;
    test::onSurface(tool_, [&](const Vec3& x, double radius) {
      deepest = std::max(deepest, radius - test::signedGap(ground_, X_WT * x));
    });
    for (const Vec3& x : ridge_) deepest = std::max(deepest, -test::signedGap(tool_, X_WT.inverse() * x));
    return deepest;
  }

 private:
  void addRidge(std::uint32_t t, int corner) {
    constexpr int kPlaces = 100;
    const MeshView& mesh = *ground_.mesh;
    const std::uint32_t across = mesh.neighbours[t][corner];
    const Vec3 from = mesh.vertex(t, corner), to = mesh.vertex(t, (corner + 1) % 3);
    const Vec3 beyond = (mesh.vertex(across, 0) + mesh.vertex(across, 1) + mesh.vertex(across, 2)) / 3 - from;
    const Vec3 out = (to - from).cross(mesh.vertex(t, (corner + 2) % 3) - from).normalized();
    if (across < t || out.dot(beyond) > -1e-6) return;
    for (int i = 0; i <= kPlaces; ++i) ridge_.push_back(from + i * (to - from) / kPlaces);
  }

  Shape tool_, ground_;
  std::vector<Vec3> ridge_;
};

Wandered wanderOnMesh(const Shape& tool, TestMesh mesh, const Vec3& turn, const Wandering& wandering, Random& random) {
  const auto house = test::houseWithoutFloor();
  MeshView* const view = mesh.view();
  house->meshes.publish(4, view);
  house->reshape(tool.kind, tool.size);
  const Vec3 hand(0, 0, 0.11);
  house->aim(hand, turn);
  house->run(500);
  AddObject ground = test::object(test::kWall, ShapeKind::kMesh, Vec3::Zero(), Vec3::Zero());
  ground.shape.mesh = 4;
  ground.material = {1000, 0, 0, 0};
  house->send(CommandKind::kAddObject, ground);
  house->hold();
  return wanderOver(*house, DepthInMesh(tool, view), hand, turn, wandering, random);
}

/** The worst of several hands over a ground that is turned, as if they were. */
template <class MakeMesh>
Wandered wanderOn(const Shape& tool, const Vec3& turn, const MakeMesh& makeMesh) {
  Wandered worst;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    Random random(seed);
    const Quat q = fromRotationVector(random.vector(0.2));
    const Wandered now = wanderOnMesh(tool, makeMesh(q), turn, test::anywhere(random), random);
    worst = {std::max(worst.deepest, now.deepest), std::max(worst.shaken, now.shaken)};
  }
  return worst;
}

const Vec3 kStanding = Vec3::Zero(), kLying(1.57, 0, 0);

TestMesh slot(const Quat& q) {
  return test::meshOfCells({{{-kWide, -0.0075, 0.0075, kWide}, {-kWide, kWide}, {-0.01, -0.005, 0.01}}}, q,
                           [](int i, int, int k) { return i != 1 || k == 0; });
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
  const auto groove = [](const Quat& q) {
    return test::prismMesh({{0, 0}, {-kWide, kWide}, {-kWide, -0.03}, {kWide, -0.03}, {kWide, kWide}}, kWide, q);
  };
  EXPECT_LT(wanderOn({ShapeKind::kCylinder, {0.03, 0.003, 0}}, kStanding, groove).deepest, 3e-4);
}

/** A cylinder that leans over a blade: the place where it is said to be lowest is beside that. */
TEST(ConcaveObstacle, ASpokeLiesAlongABlade) {
  const auto blade = [](const Quat& q) {
    const double half = 0.07 * std::tan(EIGEN_PI / 18);
    return test::prismMesh({{-half, -0.06}, {half, -0.06}, {0, 0.01}}, kWide, q);
  };
  EXPECT_LT(wanderOn(test::kSpoke, kLying, blade).deepest, 3e-4);
}

}  // namespace
}  // namespace hapticd
