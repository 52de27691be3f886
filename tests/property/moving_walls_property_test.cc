/** @file
 * Several objects that move against each other with the hand between them.
 */
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/support/for_seeds.h"
#include "tests/support/shape/test_mesh.h"
#include "tests/support/stepped/test_scene.h"

namespace hapticd {
namespace {

using test::TestMesh;
using test::TestScene;

constexpr double kHalf = 0.02;         // Of the room.
constexpr int kMoving = 600;           // Ticks in which the walls move,
constexpr int kAtRest = 60;            // and stand at home again.
constexpr double kMostPerTick = 9e-3;  // What is more is a teleport.

/** One of the six; all reach far over the room's edges, so that it stays closed however they move. */
struct Wall {
  Vec3 out;  ///< In the room's frame.
  Pose home;
  std::uint32_t id = 0;
  double pace = 0, phase = 0, far = 0;
  Vec3 tilt = Vec3::Zero();

  /** `much` of its sway, some time into it. */
  [[nodiscard]] Pose at(const Pose& room, double much, int tick) const {
    const double turn = pace * tick;
    const double in = far * (0.5 - 0.5 * std::cos(turn + phase) - 0.25 * std::sin(0.7 * turn));
    const Vec3 along = 0.003 * Vec3(std::sin(turn), std::cos(1.3 * turn), 0);
    const Vec3 by = along - out * out.dot(along) - in * out;
    return {home.p + much * (room.q * by), rotated(home.q, much * std::sin(turn) * tilt, 1)};
  }
};

/** Six walls that sway, slide and tilt, and squeeze the hand as they like; when all are at home, it is still inside. */
void aRoomOfMovingWallsIsNeverLeft(unsigned seed, int& touched) {
  Random random(seed);
  const double radius = random.once(2) ? 0 : std::exp(random.in(std::log(1e-4), std::log(5e-3)));
  TestScene t(radius);
  const double thick = std::pow(10, random.in(-4, -2.3)), farthest = random.once(2) ? 0.012 : 0.025;
  const int kind = random.below(3);  // Boxes, meshes of boxes, two-sided sheets.
  std::vector<TestMesh> meshes;
  meshes.reserve(6);
  Pose room;
  room.p = random.vector(0.05);
  room.q = random.turn();
  Wall walls[6];
  for (int i = 0; i < 6; ++i) {
    Wall& w = walls[i];
    w.out = (i % 2 == 1 ? 1 : -1) * Vec3::Unit(i / 2);
    const double half = kind == 2 ? 0 : thick;
    w.home = room * Pose{(kHalf + half) * w.out, Quat::FromTwoVectors(Vec3::UnitZ(), w.out)};
    const double mu = random.once(2) ? random.in(0, 1.5) : 0, share = random.in(0.3, 1);
    const hd_material material = {random.in(100, 3000), 0, mu, share * mu};
    if (kind == 0) {
      w.id = t.add(ShapeKind::kBox, Vec3(0.08, 0.08, thick), w.home, material);
    } else {
      const auto flat = [](double, double) { return 0.0; };
      meshes.push_back(kind == 1 ? test::boxMesh(Vec3(0.08, 0.08, thick)) : test::heightMesh(0.08, 3, flat));
      const std::uint32_t sided = kind == 2 ? 0u + HD_OBJECT_TWO_SIDED : 0u;
      w.id = t.addMesh(meshes.back().view(), w.home, material, HD_OBJECT_ENABLED | sided);
    }
    w.pace = std::pow(10, random.in(-2.5, -0.5));
    w.phase = random.in(0, 6);
    w.far = random.in(0, farthest);
    if (random.once(2)) w.tilt = random.vector(0.05);
  }
  t.tick(room.p);
  Vec3 hand = Vec3::Zero(), aim = hand;
  double speed = 0.01;
  int contacts = 0;
  for (int i = 1; i <= kMoving + kAtRest; ++i) {
    const double much = i < kMoving ? std::min(1.0, 3 * std::sin(M_PI * i / kMoving)) : 0;
    for (const Wall& w : walls) {
      Pose X = w.at(room, much, i);
      const Vec3 from = t.scene->find(w.id)->X_WO.p, step = X.p - from;
      if (step.norm() > kMostPerTick) X.p = from + kMostPerTick * step.normalized();
      ASSERT_EQ(t.pose(w.id, X), ErrorCode::kOk);
    }
    if (random.once(20)) aim = random.vector(2 * kHalf);
    if (random.once(30)) speed = std::pow(10, random.in(-3, 0));
    hand += speed * (aim - hand);
    const bool done = i > kMoving + kAtRest - 20;
    const Vec3 hip = done ? room.p : room * hand;
    const SurfaceContact& c = t.tick(hip);
    contacts += c.object != 0;
    const double k = test::stiffnesses(*t.scene, c).stiffest;
    ASSERT_LE(c.force.norm(), k * (c.proxy - hip).norm() * (1 + 1e-9)) << "tick " << i;
    ASSERT_LT((c.proxy - room.p).norm(), 10 * kHalf) << "where planes that nearly coincide meet, tick " << i;
    if (i < kMoving + 20) continue;
    ASSERT_LT((room.inverse() * c.proxy).cwiseAbs().maxCoeff(), kHalf + 1e-8) << "tick " << i;
  }
  EXPECT_EQ(t.contact.object, 0u);
  EXPECT_LT((t.contact.proxy - room.p).norm(), 1e-12);
  touched += contacts > 2;
}

TEST(MovingWallsProperty, ARoomOfMovingWallsIsNeverLeft) {
  int touched = 0;
  forSeeds(60, [&](unsigned seed) { aRoomOfMovingWallsIsNeverLeft(seed, touched); });
  EXPECT_GT(touched, drawn(40));
  // Seeds of a soak: a hand caught between two walls of different friction, which never let it go.
  for (const unsigned seed : {846u, 7053u}) aRoomOfMovingWallsIsNeverLeft(seed, touched);
  // And hands that felt a spring of up to 86 m, to where two walls that nearly coincide meet.
  for (const unsigned seed : {107u, 203u, 321u}) aRoomOfMovingWallsIsNeverLeft(seed, touched);
}

}  // namespace
}  // namespace hapticd
