/** @file
 * Two solids in each other, of any kind: what parts them, and a point within both, against a search in all directions.
 */
#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <optional>

#include "rt/collide/feature.h"
#include "rt/collide/overlap.h"
#include "rt/collide/scene_contacts.h"
#include "tests/support/for_seeds.h"
#include "tests/support/random.h"
#include "tests/support/shape/overlap.h"
#include "tests/support/shape/test_mesh.h"

namespace hapticd {
namespace {

constexpr std::uint32_t kMeshWork = 100'000;  ///< Ample.

/** Two solids that are near to each other. */
struct NearPair {
  explicit NearPair(Random& random) {
    constexpr ShapeKind kKinds[] = {ShapeKind::kBox, ShapeKind::kCylinder, ShapeKind::kCapsule, ShapeKind::kSphere,
                                    ShapeKind::kMesh};
    const bool thin = random.once(3);
    for (std::size_t i = 0; i < 2; ++i) {
      Shape& s = shape[i];
      s = {kKinds[random.below(5)], {random.in(0.004, 0.02), random.in(0.004, 0.02), random.in(0.004, 0.02)}};
      if (thin) s.size[s.kind == ShapeKind::kCylinder ? 1 : 2] = random.in(0.0005, 0.002);
      mesh[i] = test::boxMesh(s.size);
      mesh[i].flags = HD_MESH_CLOSED;
      s.mesh = mesh[i].view();
      X[i] = {random.vector(i == 0 ? 0.1 : 0.02), random.turn()};
    }
    X[1].p += X[0].p;
  }
  [[nodiscard]] Solid solid(std::size_t i) const { return {shape[i], X[i]}; }
  [[nodiscard]] double overlap() const { return test::overlapOf(shape[0], X[0], shape[1], X[1]); }

  std::array<Shape, 2> shape;
  std::array<test::TestMesh, 2> mesh;
  std::array<Pose, 2> X;
};

TEST(OverlapProperty, TheWayPartsThemAndIsNearlyTheLeast) {
  int longer = 0, little_longer = 0, looked = 0;
  forSeeds(800, [&](unsigned seed) {
    Random random(seed);
    const NearPair pair(random);
    const double least = pair.overlap();
    const Parting parting = leastParting(pair.solid(0), pair.solid(1));
    EXPECT_NEAR(parting.n.norm(), 1, 1e-9);
    EXPECT_GT(parting.way, least - 1e-6);
    ++looked;
    longer += parting.way > 1.1 * std::abs(least) + 1e-4;
    little_longer += least > 1e-4 && parting.way > 1.01 * least;
    const auto isFlat = [](const Shape& s) { return s.kind == ShapeKind::kBox || s.kind == ShapeKind::kMesh; };
    if (least > 0 && isFlat(pair.shape[0]) && isFlat(pair.shape[1])) {
      EXPECT_LT(parting.way, least + 1e-7) << "of two boxes it is the least";
    }
    const double way = test::overlapAlong(parting.n, pair.shape[0], pair.X[0], pair.shape[1], pair.X[1]);
    EXPECT_NEAR(parting.way, way, 1e-7) << "meshes are of floats";
    EXPECT_NEAR(parting.first + parting.second - parting.n.dot(pair.X[1].p - pair.X[0].p), way, 1e-7);
  });
  EXPECT_LE(longer, looked / 20);
  EXPECT_LE(little_longer, looked / 8);
}

TEST(OverlapProperty, BallsPartAlongTheirMiddlesAndThroughTheNearestFace) {
  forSeeds(100, [](unsigned seed) {
    Random random(seed);
    const double r = random.in(0.004, 0.02), other = random.in(0.004, 0.02);
    const Shape ball{ShapeKind::kSphere, {r, 0, 0}}, second{ShapeKind::kSphere, {other, 0, 0}};
    const Pose X = random.pose(0.1);
    const Vec3 to = random.vector(0.01);
    const Parting balls = leastParting({ball, X}, {second, {X.p + to, random.turn()}});
    EXPECT_NEAR(balls.way, r + other - to.norm(), 1e-12);
    EXPECT_LT((balls.n - to.normalized()).norm(), 1e-9);
    EXPECT_EQ(balls.first, r);
    EXPECT_EQ(balls.second, other);
    EXPECT_NEAR(leastParting({ball, X}, {second, X}).way, r + other, 1e-12) << "of one middle, any way";

    const Vec3 half(random.in(0.02, 0.04), random.in(0.02, 0.04), random.in(0.02, 0.04));
    const Vec3 at(random.vector(1).cwiseProduct(half));
    int face = 0;
    const double deep = (half - at.cwiseAbs()).minCoeff(&face);
    const Shape box{ShapeKind::kBox, half};
    const Parting out = leastParting({box, X}, {ball, {X * at, random.turn()}});
    EXPECT_NEAR(out.way, deep + r, 1e-8);
    EXPECT_NEAR((X.q.conjugate() * out.n)[face], std::copysign(1, at[face]), 1e-6);
  });
}

/** As flat a mesh as a box; it is that box wherever it has its origin. */
TEST(OverlapProperty, AMeshIsTheBoxAboutIt) {
  forSeeds(100, [](unsigned seed) {
    Random random(seed);
    const NearPair pair(random);
    const Vec3 half(random.in(0.004, 0.02), random.in(0.004, 0.02), random.in(0.004, 0.02)), off = random.vector(0.05);
    test::TestMesh made = test::boxMesh(half, off);
    const Shape box{ShapeKind::kBox, half};
    Shape mesh{ShapeKind::kMesh, Vec3::Zero()};
    mesh.mesh = made.view();
    const Pose& X = pair.X[0];
    const Solid aside{mesh, X * Pose{-off, Quat::Identity()}};
    EXPECT_LT((middleOf(aside) - X.p).norm(), 1e-8);
    const Parting one = leastParting({box, X}, pair.solid(1)), same = leastParting(aside, pair.solid(1));
    EXPECT_NEAR(one.way, same.way, 1e-7);
  });
}

TEST(OverlapProperty, APointWithinBothIsFoundWhereTheyAreInEachOther) {
  int deep = 0, apart = 0;
  forSeeds({1265, 2407, 34111, 41006, 97781}, 600, [&](unsigned seed) {
    Random random(seed);
    const NearPair pair(random);
    const double overlap = pair.overlap();
    std::uint32_t work = 0;
    const bool found = findWithin(pair.solid(0), pair.solid(1), kMeshWork, work);
    deep += overlap > 2e-4;
    apart += overlap < 1.9 * kWithin;
    if (overlap > 2e-4) {
      EXPECT_TRUE(found) << overlap;
    }
    if (overlap < 1.9 * kWithin) {
      EXPECT_FALSE(found) << overlap;
    }
  });
  EXPECT_GT(deep, 100);
  EXPECT_GT(apart, drawn(100));
}

TEST(OverlapProperty, OfAMeshWithoutRoomForWorkNothingIsFound) {
  Random random(1);
  NearPair pair(random);
  pair.shape[0].kind = pair.shape[1].kind = ShapeKind::kMesh;
  pair.X[1].p = pair.X[0].p + Vec3(0.001, 0.002, 0.003);
  std::uint32_t needed = 0;
  EXPECT_TRUE(findWithin(pair.solid(0), pair.solid(1), kMeshWork, needed));
  ASSERT_GT(needed, 1u);
  constexpr std::uint32_t kDone = 10, kOver = 16;  // Before, and what one look may go beyond it.
  for (std::uint32_t limit = 0; 2 * limit < needed; ++limit) {
    std::uint32_t work = kDone;
    EXPECT_FALSE(findWithin(pair.solid(0), pair.solid(1), limit + kDone, work)) << limit;
    EXPECT_LT(work, limit + kDone + kOver);
  }
  std::uint32_t work = kDone;
  EXPECT_TRUE(findWithin(pair.solid(0), pair.solid(1), needed + kDone, work));
  EXPECT_EQ(work, needed + kDone);
}

/** Two bodies, and what each is told of the other. */
class TwoThatAsk {
 public:
  /** The way out that one of them is told, back into the world; none: it is told points alone. */
  std::optional<Touch> wayOut(const NearPair& pair, std::size_t asks) {
    const std::size_t other = 1 - asks;
    CollideRequest::Held held;
    held.object = makeObjectId(kFirstSlot + static_cast<std::uint32_t>(asks), 1);
    held.shape = pair.shape[asks];
    held.shape.number = ++number_;
    held.X_WO = pair.X[asks];
    held.put = true;
    held.count = 1;
    held.obstacle[0] = {kFirstSlot + static_cast<std::uint32_t>(other), pair.shape[other], pair.X[other], {}};
    ContactModel model;
    DetectorReport report;
    contacts_->find(held, 0.003, {400'000, 0, nullptr}, model, report);
    for (std::uint32_t i = 0; i < model.count; ++i) {
      if (model.point[i].feature() == kWayOut) return model.touch(i, held.X_WO, held.X_WO.p, pair.X[other], {});
    }
    return {};
  }

 private:
  static constexpr std::uint32_t kFirstSlot = 20;
  std::uint64_t number_ = 0;
  std::unique_ptr<SceneContacts> contacts_ = std::make_unique<SceneContacts>(1);
};

/** Whichever way is as short as another, as in one place or along a diagonal: each would else go the same way. */
TEST(OverlapProperty, TwoInEachOtherAreToldOppositeWays) {
  TwoThatAsk bodies;
  int told = 0;
  forSeeds(200, [&](unsigned seed) {
    Random random(seed);
    NearPair pair(random);
    if (!random.once(3)) {
      pair.shape[1].kind = pair.shape[0].kind;
      pair.shape[1].size = pair.shape[0].size;
      pair.shape[1].mesh = pair.shape[0].mesh;
      pair.X[1].p = pair.X[0].p;
      if (random.once(2)) pair.X[1] = pair.X[0];
    }
    const std::optional<Touch> first = bodies.wayOut(pair, 0), second = bodies.wayOut(pair, 1);
    ASSERT_EQ(first.has_value(), second.has_value());
    if (!first) return;
    ++told;
    EXPECT_LT((first->n + second->n).norm(), 1e-5) << "the planes are of floats";
    EXPECT_NEAR(first->gap, second->gap, 1e-6);
    EXPECT_LT(first->gap, -1e-4);
  });
  EXPECT_GT(told, drawn(200) / 2);
}

}  // namespace
}  // namespace hapticd
