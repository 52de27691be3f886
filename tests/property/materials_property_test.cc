// Several objects hold a hand, each of a material of its own.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "rt/render/proxy/press.h"
#include "tests/support/for_seeds.h"
#include "tests/support/random.h"
#include "tests/support/shape/test_mesh.h"
#include "tests/support/stepped/test_scene.h"

namespace hapticd {
namespace {

constexpr double kReach = 3e-3;
constexpr double kHalfBox = 0.05;  // Of a box.

/** Planes through the origin, or faces of boxes there, of which the hand is above, with their materials. */
struct Walls {
  ShapeKind kind = ShapeKind::kPlane;
  test::TestMesh box = test::boxMesh(Vec3::Constant(kHalfBox));
  test::TestScene scene;
  std::vector<Vec3> normals;
  std::vector<double> stiffness;
  std::vector<std::uint32_t> ids;

  void add(const Vec3& n, const hd_material& material) {
    normals.push_back(n);
    stiffness.push_back(material.stiffness);
    const double below = kind == ShapeKind::kPlane ? 0 : kHalfBox;
    const Pose X{-below * n, Quat::FromTwoVectors(Vec3::UnitZ(), n)};
    ids.push_back(kind == ShapeKind::kMesh ? scene.addMesh(box.view(), X, material)
                                           : scene.add(kind, Vec3::Constant(below), X, material));
  }
  [[nodiscard]] double softest() const { return *std::ranges::min_element(stiffness); }
  [[nodiscard]] double stiffest() const { return *std::ranges::max_element(stiffness); }
};

double anyStiffness(Random& random) { return std::exp(random.in(std::log(50.0), std::log(5000.0))); }

/** A corner of two or three walls at right angles, anyhow turned. */
void addCorner(Walls& walls, Random& random, double friction, double dynamic) {
  const Quat turn = random.turn();
  const int count = 2 + random.below(2);
  for (int i = 0; i < count; ++i)
    walls.add(turn * Vec3::Unit(i), {anyStiffness(random), random.in(0, 5), friction, dynamic});
}

/** Each wall presses with its own k times its own depth, whichever the hand came to first; so does its energy count. */
TEST(MaterialsProperty, WallsAtRightAnglesPressAsIfAlone) {
  forSeeds(400, [&](std::uint32_t seed) {
    Random random(seed);
    Walls walls;
    addCorner(walls, random, 0, 0);
    walls.scene.proxy.setRadius(seed % 2 ? 2e-3 : 0);
    const double radius = walls.scene.proxy.radius();
    Vec3 corner = Vec3::Zero();  // Of all places that let it be, the lowest.
    for (const Vec3& n : walls.normals) corner += radius * n;
    walls.scene.tick(corner + kReach * walls.normals[0] + kReach * walls.normals[1]);
    for (int i = 0; i < 40; ++i) {
      const Vec3 hip = corner + random.vector(kReach);
      const SurfaceContact& contact = walls.scene.tick(hip);
      Vec3 force = Vec3::Zero();
      double stored = 0;
      for (std::size_t w = 0; w < walls.normals.size(); ++w) {
        const double depth = std::max(0.0, radius - walls.normals[w].dot(hip));
        force += walls.stiffness[w] * depth * walls.normals[w];
        stored += 0.5 * walls.stiffness[w] * depth * depth;
      }
      const Vec3 elastic = contact.force - contact.damping * contact.normal;
      ASSERT_LT((elastic - force).norm(), 1e-9);
      ASSERT_NEAR(contact.stored, stored, 1e-12);
    }
  });
}

/** Whatever is asked of any surfaces, also what they cannot account for: K up, its eigenvalues the stiffnesses. */
TEST(MaterialsProperty, NoSofterThanTheSoftestWhereverTheHandIs) {
  forSeeds(20000, [&](std::uint32_t seed) {
    Random random(seed);
    Pressing surface[kMaxPressing];
    const int count = 1 + random.below(kMaxPressing);
    double softest = 5000, stiffest = 0;
    for (int i = 0; i < count; ++i) {
      surface[i] = {random.vector(1).normalized(), random.below(4) == 0 && i > 0 ? 0.0 : random.in(0, kReach),
                    anyStiffness(random)};
      softest = std::min(softest, surface[i].stiffness);
      stiffest = std::max(stiffest, surface[i].stiffness);
    }
    const Vec3 up = random.vector(kReach);
    const Vec3 force = press({surface, static_cast<std::size_t>(count)}, up);
    ASSERT_GE(force.dot(up), softest * up.squaredNorm() * (1 - 1e-9));
    ASSERT_LE(force.norm(), stiffest * up.norm() * (1 + 1e-9));
  });
}

/** Whatever the angle: no softer than the softest, no stiffer than the stiffest, the same by every way, and no jump. */
TEST(MaterialsProperty, NoForceJumpsInACorner) {
  double steepest = 0;
  forSeeds(300, [&](std::uint32_t seed) {
    Random random(seed);
    Walls walls;
    const double between = random.in(0.2, 2.9);  // Of the normals: a wedge, a corner, a shallow valley.
    const Quat turn = random.turn();
    walls.add(turn * Vec3::UnitZ(), {anyStiffness(random), 0, 0, 0});
    walls.add(turn * Vec3(std::sin(between), 0, std::cos(between)), {anyStiffness(random), 0, 0, 0});
    const Vec3 out = (walls.normals[0] + walls.normals[1]).normalized();
    const double kStep = 1e-6;
    Vec3 x = kReach * out, last = Vec3::Zero();
    walls.scene.tick(x);
    for (int leg = 0; leg < 6; ++leg) {
      const Vec3 to = turn * Vec3(random.in(-kReach, kReach), 0, random.in(-kReach, kReach));
      const int steps = static_cast<int>((to - x).norm() / kStep) + 1;
      const Vec3 step = (to - x) / steps;
      for (int i = 0; i < steps; ++i) {
        const SurfaceContact& contact = walls.scene.tick(x += step);
        const Vec3 up = contact.proxy - x;
        ASSERT_GE(contact.force.dot(up), (walls.softest() * (1 - 1e-9)) * up.squaredNorm() - 1e-15);
        ASSERT_LE(contact.force.norm(), (walls.stiffest() * (1 + 1e-9)) * up.norm() + 1e-12);
        steepest = std::max(steepest, (contact.force - last).norm() / (walls.stiffest() * step.norm()));
        last = contact.force;
      }
      Walls other;  // Straight there.
      for (std::size_t w = 0; w < 2; ++w) other.add(walls.normals[w], {walls.stiffness[w], 0, 0, 0});
      other.scene.tick(kReach * out);
      other.scene.tick(x);
      ASSERT_LT((other.scene.tick(x).force - last).norm(), 1e-6);
    }
  });
  EXPECT_LT(steepest, 10) << "force per way, in the stiffest wall's stiffness";
}

/** Friction is in proportion to what the walls press with; a hand that goes away is never pulled. */
TEST(MaterialsProperty, FrictionInACornerStaysInItsCone) {
  forSeeds(300, [&](std::uint32_t seed) {
    Random random(seed);
    Walls walls;
    const double mu = random.in(0.1, 0.8);
    addCorner(walls, random, mu, 0.8 * mu);
    walls.scene.tick(kReach * (walls.normals[0] + walls.normals[1]));
    Vec3 hip = -1e-3 * (walls.normals[0] + walls.normals[1]);
    for (int i = 0; i < 300; ++i) {
      const Vec3 v = random.vector(0.1);
      const SurfaceContact& contact = walls.scene.tick(hip += 1e-3 * v, v);
      if (contact.object == 0) continue;
      const double along = contact.force.dot(contact.normal);
      const Vec3 across = contact.force - along * contact.normal;
      ASSERT_GE(along, -1e-12);
      ASSERT_LE(across.norm(), mu * along * (1 + 1e-6) + 1e-9);
    }
  });
}

/** Walls at right angles rub each with its own friction on its own force: of those forces the resultant. */
TEST(MaterialsProperty, EachWallRubsWithItsOwnFriction) {
  forSeeds(300, [&](std::uint32_t seed) {
    Random random(seed);
    Walls walls;
    walls.kind = std::array{ShapeKind::kPlane, ShapeKind::kBox, ShapeKind::kMesh}[seed % 3];
    const Quat turn = random.turn();
    Vec3 hip = Vec3::Zero();
    double still = 0, sliding = 0;
    std::vector<hd_material> rubs;
    for (int i = 0; i < 2; ++i) {
      const double mu = random.below(3) == 0 ? 0.0 : random.in(0.1, 1.0), depth = random.in(0.1e-3, kReach);
      const hd_material material{anyStiffness(random), 0, mu, random.in(0.5, 0.9) * mu};
      rubs.push_back(material);
      walls.add(turn * Vec3::Unit(i), {material.stiffness, 0, 0, 0});
      hip -= depth * walls.normals.back();
      still += std::pow(material.friction_static * material.stiffness * depth, 2);
      sliding += std::pow(material.friction_dynamic * material.stiffness * depth, 2);
    }
    walls.scene.tick(kReach * (walls.normals[0] + walls.normals[1]));
    for (int i = 0; i < 2; ++i) walls.scene.tick(hip);  // Both hold it, and then they rub.
    for (std::size_t w = 0; w < 2; ++w) walls.scene.material(walls.ids[w], rubs[w]);
    if (still == 0) return;
    const Vec3 along = turn * Vec3::UnitZ();
    const double step = 1e-6;
    double most = 0;
    bool slips = false;
    for (int i = 0; i < 20000 && !slips; ++i) {
      const SurfaceContact& contact = walls.scene.tick(hip += step * along);
      slips = contact.slip;
      if (!slips) most = -contact.force.dot(along);
    }
    ASSERT_TRUE(slips);
    ASSERT_NEAR(most, std::sqrt(still), 1e-9 + 2 * step * walls.stiffest());
    ASSERT_NEAR(-walls.scene.tick(hip += step * along).force.dot(along), std::sqrt(sliding),
                1e-5 * (1 + std::sqrt(sliding)));
  });
}

/** From one wall into the corner and out over the other one, as stiff but not as rough, rubbing all the way. */
TEST(MaterialsProperty, FrictionHardlyJumpsInACorner) {
  double jumps = 0;  // In all, of the force.
  forSeeds(300, [&](std::uint32_t seed) {
    Random random(seed);
    Walls walls;
    const double between = random.in(0.4, 2.2), stiffness = anyStiffness(random);
    const Quat turn = random.turn();
    const Vec3 first = turn * Vec3::UnitX(), second = turn * Vec3(std::cos(between), std::sin(between), 0);
    for (const Vec3& n : {first, second}) {
      const double mu = random.below(3) == 0 ? 0.0 : random.in(0.1, 0.8);
      walls.add(n, {stiffness, 0, mu, mu});
    }
    const Vec3 along = turn * Vec3::UnitZ();
    const Vec3 over_first = (second - second.dot(first) * first).normalized();
    const Vec3 over_second = (first - first.dot(second) * second).normalized();
    const double depth = random.in(0.3e-3, 1e-3);
    const Vec3 stop[] = {kReach * over_first - depth * first, -depth * (first + second).normalized(),
                         kReach * over_second - depth * second};
    walls.scene.tick(stop[0] + kReach * first);
    Vec3 x = stop[0], last = walls.scene.tick(x).force;
    constexpr int kSteps = 4000;
    for (int leg = 0; leg < 2; ++leg) {
      const Vec3 step = (stop[leg + 1] - stop[leg]) / kSteps + 2e-6 * along;
      for (int i = 0; i < kSteps; ++i) {
        const Vec3 force = walls.scene.tick(x += step).force;
        const double jump = (force - last).norm();
        if (jump > 10 * stiffness * step.norm()) jumps += jump / last.norm();
        last = force;
      }
    }
  });
  EXPECT_LT(jumps, 5);  // With the friction of the wall touched first it was 59.
}

/**
 * A hand in a corner that rubs on all walls and is as deep in each as it happens. Nothing jumps but by what slips; but
 * where the hand has left a wall, the proxy, which lags, comes back to it after the hand, and the force jumps by what
 * the wall is softer or harder than the others, for as much as the hand is behind it by then.
 */
void whatSticksIsStillPressed(std::uint32_t seed, int& came_late) {
  Random random(seed);
  Walls walls;
  const double mu = random.in(0.2, 0.8);
  addCorner(walls, random, 0, 0);
  Vec3 corner = Vec3::Zero();
  for (const Vec3& n : walls.normals) corner += n;
  walls.scene.tick(kReach * corner);
  Vec3 hip = -1e-3 * corner;
  walls.scene.tick(hip);  // All hold it, and then they rub; slip and stick make no difference.
  for (std::size_t w = 0; w < walls.ids.size(); ++w)
    walls.scene.material(walls.ids[w], {walls.stiffness[w], 0, mu, mu});
  walls.scene.tick(hip);
  Vec3 last = walls.scene.contact.force;
  std::vector<bool> left(walls.normals.size());
  for (int leg = 0; leg < 10; ++leg) {
    // One after the other: in which order operands are made differs from compiler to compiler.
    const Vec3 aside = 0.15e-3 * random.vector(1);
    const Vec3 to = aside - random.in(0.2e-3, 2e-3) * corner;
    const Vec3 step = (to - hip) / 1000;
    for (int i = 0; i < 1000; ++i) {
      const SurfaceContact& contact = walls.scene.tick(hip += step);
      double most = 2 * walls.stiffest() * step.norm();  // In 60 million ticks 1.06 times, where none came late.
      for (std::size_t w = 0; w < walls.normals.size(); ++w) {
        const double depth = -walls.normals[w].dot(hip);
        if (depth <= 0) {
          left[w] = true;
        } else if (left[w] && walls.normals[w].dot(contact.proxy) < 1e-9) {
          left[w] = false;
          most += (walls.stiffest() - walls.softest()) * depth;
          ++came_late;
        }
      }
      ASSERT_LT((contact.force - last).norm(), most) << leg << " " << i;
      last = contact.force;
    }
  }
}
TEST(MaterialsProperty, WhatSticksToOneWallIsStillPressedByTheOther) {
  int came_late = 0;
  forSeeds(100, [&](std::uint32_t seed) { whatSticksIsStillPressed(seed, came_late); });
  came_late = 0;  // Seed of a soak: 1 in 1000 does.
  whatSticksIsStillPressed(869016, came_late);
  EXPECT_EQ(came_late, 1);
}

/** A floor at rest and a wall that comes: what the wall gives is its own force times its own speed. */
TEST(MaterialsProperty, WhatAMovingWallGivesIsItsOwn) {
  forSeeds(200, [&](std::uint32_t seed) {
    Random random(seed);
    Walls walls;
    const Quat turn = random.turn();
    for (int i = 0; i < 2; ++i) walls.add(turn * Vec3::Unit(i), {anyStiffness(random), 0, 0, 0});
    const Vec3 hip = -1e-3 * walls.normals[0];
    walls.scene.tick(kReach * (walls.normals[0] + walls.normals[1]));
    walls.scene.tick(hip);
    const double speed = random.in(0.01, 0.5);
    double most = 0;
    for (int i = 1; i < 10; ++i) {
      Pose at = walls.scene.scene->find(walls.ids[1])->X_WO;
      at.p = 1e-3 * i * speed * walls.normals[1];
      walls.scene.pose(walls.ids[1], at, {speed * walls.normals[1], Vec3::Zero()});
      const SurfaceContact& contact = walls.scene.tick(hip);
      const double depth = (contact.proxy - hip).dot(walls.normals[1]);
      const double given = contact.force.dot(contact.velocity) + contact.apart.sum();
      const double moving = walls.scene.scene->find(walls.ids[1])->velocityAt(contact.point).dot(walls.normals[1]);
      ASSERT_NEAR(given, walls.stiffness[1] * depth * moving, 1e-9);
      most = std::max(most, given);
    }
    ASSERT_GT(most, 0);
  });
}

}  // namespace
}  // namespace hapticd
