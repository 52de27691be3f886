// A ground of several obstacles: a tool slides over the seams between them, lies on several, and in their corners.
#include <gtest/gtest.h>

#include <vector>

#include "tests/support/random.h"
#include "tests/support/stepped/wandering_tool.h"

namespace hapticd {
namespace {

using test::kBrick;
using test::kTub;
using test::Placed;
using Parts = std::vector<Placed>;

const Shape kPlug{ShapeKind::kBox, {0.01, 0.01, 0.03}}, kSaucer{ShapeKind::kCylinder, {0.03, 0.003, 0}};
constexpr double kTop = 0.01;  ///< Of slab and tiles [m].

Shape box(double x, double y, double z) { return {ShapeKind::kBox, {x, y, z}}; }
Placed at(const Shape& shape, const Vec3& p) { return {shape, {p, Quat::Identity()}}; }

/** Nine tiles, 20 mm from each to the next, that overlap by so much. */
Parts tiles(double overlap) {
  Parts ground;
  const double half = 0.01 + overlap / 2;
  for (const double x : {-0.02, 0.0, 0.02}) {
    for (const double y : {-0.02, 0.0, 0.02}) ground.push_back(at(box(half, half, kTop), {x, y, 0}));
  }
  return ground;
}

Parts stairs() {
  Parts ground;
  for (int i = 0; i < 5; ++i) ground.push_back(at(box(0.0055, 0.03, 0.03), {0.01 * (i - 2), 0, 0.004 * i - 0.03}));
  return ground;
}

/** As if the hand's wandering were turned instead. */
Parts turned(Parts ground, Random& random) {
  const Pose X_WG{Vec3::Zero(), fromRotationVector(random.vector(0.2))};
  for (Placed& part : ground) part.X_WP = X_WG * part.X_WP;
  return ground;
}

double shaken(const Shape& tool, const Parts& ground, const std::vector<unsigned>& hands = {1, 2}) {
  double sum = 0;
  for (const unsigned seed : hands) {
    Random random(seed);
    sum += test::wander(tool, turned(ground, random), {0, 0, 0.11}, Vec3::Zero(), random).shaken;
  }
  return sum;
}

/** Beside edges of tiles, of which nothing stands out, it was caught: nine times as much as on the slab. */
TEST(SideBySide, ATubSlidesOverTilesAsOverASlab) {
  const double slab = shaken(kTub, {at(box(0.03, 0.03, kTop), Vec3::Zero())});
  EXPECT_LT(shaken(kTub, tiles(0)), 4 * slab);
  EXPECT_LT(shaken(kTub, tiles(0.002)), 4 * slab);
}

/** Hands differ: 1 to 12 make 75 to 506. */
TEST(SideBySide, APlugSlidesOverTiles) { EXPECT_LT(shaken(kPlug, tiles(0), {1, 3}), 550); }

/** The disc at a cylinder's end whose middle was right over an edge was told 2 mm deep, and thrown. */
TEST(SideBySide, ATubOnStairsIsNotThrown) { EXPECT_LT(shaken(kTub, stairs()), 2000); }

/** How deep it gets. */
double sunk(const Shape& tool, const Parts& ground, const Vec3& hand, const std::vector<unsigned>& hands = {1, 2}) {
  double deepest = 0;
  for (const unsigned seed : hands) {
    Random random(seed);
    deepest = std::max(deepest, test::wander(tool, turned(ground, random), hand, Vec3::Zero(), random).deepest);
  }
  return deepest;
}

/** Two boards: what turns about an edge of one came down on the other's, 0.3 mm deep. */
TEST(SideBySide, ABrickAcrossAGapLiesOnBothSides) {
  const Parts boards{at(box(0.02, 0.04, 0.01), {0.0275, 0, 0}), at(box(0.02, 0.04, 0.01), {-0.0275, 0, 0})};
  EXPECT_LT(sunk(kBrick, boards, {0, 0, 0.11}), 1e-4);
}

/** So many points of it are near a wall that some of its corners were forgotten. Hands 4 and 8 press it 0.9 mm deep. */
TEST(SideBySide, NothingSinksIntoTheWallsOfARoomsCorner) {
  const Parts room{at(box(0.06, 0.06, 0.03), {0, 0, -0.03}), at(box(0.03, 0.06, 0.06), {0.04, 0, 0}),
                   at(box(0.06, 0.03, 0.06), {0, 0.04, 0})};
  EXPECT_LT(sunk(kBrick, room, {0, 0, 0.11}, {1, 3}), 1e-4);
  EXPECT_LT(sunk(kSaucer, room, {0, 0, 0.11}), 2e-4);
}

/** What was lowest made room for what comes down fast on the other side, and went 0.8 mm into the floor. */
TEST(SideBySide, ASaucerThatSlapsDownLiesOnAllOfItsRim) {
  const Parts room{at(box(0.06, 0.06, 0.03), {0, 0, -0.03}), at(box(0.03, 0.06, 0.06), {0.04, 0, 0}),
                   at(box(0.06, 0.03, 0.06), {0, 0.04, 0})};
  EXPECT_LT(sunk(kSaucer, room, {0, 0, 0.11}, {6, 15, 21, 30}), 2e-4);
}

/** Where a wall stands on a floor each is in the other's way, and each holds. */
TEST(SideBySide, WallAndFloorThatMeetInAnEdgeBothHold) {
  const Parts room{at(box(0.03, 0.06, 0.03), {-0.03, 0, -0.03}), at(box(0.03, 0.06, 0.03), {0.03, 0, 0.03})};
  EXPECT_LT(sunk(kBrick, room, {-0.03, 0, 0.09}), 1e-4);
  EXPECT_LT(sunk({ShapeKind::kSphere, {0.005, 0, 0}}, room, {-0.03, 0, 0.09}), 1e-4);
}

}  // namespace
}  // namespace hapticd
