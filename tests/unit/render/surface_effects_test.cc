#include "rt/render/surface/surface_effects.h"

#include <gtest/gtest.h>

#include <numbers>

#include "rt/base/rotation.h"
#include "rt/render/surface/relief.h"
#include "rt/render/surface/transient.h"
#include "tests/support/shape/test_mesh.h"
#include "tests/support/shape/test_surface.h"
#include "tests/support/stepped/test_scene.h"

namespace hapticd {
namespace {

using test::TestRelief;
using test::TestScene;
using test::TestVibration;

constexpr double kBlockStiffness = 1000;

/** A plane z = 0 with a surface, and a hand over it. */
struct Touch {
  TestScene scene;
  SurfaceEffects effects{3};
  SurfaceForces forces;
  std::uint32_t plane = 0;

  explicit Touch(const SurfaceParameters& surface, const TextureView* texture = nullptr,
                 const hd_material& material = {kBlockStiffness, 0, 0, 0}) {
    scene.table->publishTexture(0, texture);
    plane = scene.add(ShapeKind::kPlane, Vec3::Zero(), {}, material);
    EXPECT_EQ(scene.setSurface(plane, surface), ErrorCode::kOk);
  }
  const SurfaceForces& at(const Vec3& hip, const Vec3& v = Vec3::Zero()) {
    scene.tick(hip, v);
    return forces = effects.step(*scene.scene, scene.contact, scene.proxy.holding(), hip, v);
  }
  [[nodiscard]] Vec3 total() const { return scene.contact.force + forces.texture(); }
};

SurfaceParameters relief(double depth) {
  SurfaceParameters s{};
  s.relief = 1;
  s.relief_depth = depth;
  s.relief_size[0] = s.relief_size[1] = 0.02;
  return s;
}

TestRelief waves() {
  return {40, 40, [](auto x, auto y) { return 0.5 + 0.25 * std::sin(0.8 * x) + 0.25 * std::cos(0.5 * y + 0.3 * x); }};
}

TestVibration buzz() {
  TestVibration t;
  t.models = {{0.02, 0.2, 4, {}}, {0.3, 0.2, 9, {}}, {0.02, 3, 16, {}}};
  t.triangles = {{0, 1, 2}};
  t.finish();
  return t;
}

TEST(SurfaceEffects, APlainSurfaceAddsNothing) {
  Touch t(SurfaceParameters{});
  t.at({0, 0, 0.01});
  for (const double z : {0.001, -0.001, -0.01}) {
    t.at({0, 0, z}, {0.1, 0, -0.5});
    EXPECT_EQ(t.forces.texture(), Vec3::Zero());
    EXPECT_EQ(t.forces.transient, Vec3::Zero());
  }
}

TEST(SurfaceEffects, AnImpactIsFeltInItsOwnTickInProportionToItsSpeed) {
  double per_speed = 0;
  for (const double speed : {0.05, 0.1, 0.4}) {
    Touch t(test::ringing(10, 150, 0.01));
    t.at({0, 0, 1e-4}, {0, 0, -speed});
    EXPECT_EQ(t.forces.transient, Vec3::Zero()) << "not before";
    t.at({0, 0, -1e-4}, {0, 0, -speed});
    EXPECT_GT(t.forces.transient.z(), 0) << "out of the surface, at once";
    if (per_speed == 0) per_speed = t.forces.transient.z() / speed;
    EXPECT_NEAR(t.forces.transient.z() / speed, per_speed, 1e-9);
    double sum = 0;
    for (int i = 0; i < 300; ++i) sum += t.at({0, 0, -2e-4}).transient.norm();
    EXPECT_GT(sum, 0) << "it rings on";
    EXPECT_EQ(t.forces.transient, Vec3::Zero()) << "and dies out, though the contact lasts";
  }
}

/** A hand that slides over a floor hits a wall, rests in the corner, and comes back: one ring, of the wall's own speed.
 */
TEST(SurfaceEffects, AnotherObjectHitWhileSlidingIsAnImpactOnce) {
  const SurfaceParameters wall = test::ringing(10, 150, 0.01), floor = test::ringing(3, 150, 0.01);
  for (const double friction : {0.0, 0.4}) {
    for (const double radius : {0.0, 2e-3}) {
      Touch t(floor, nullptr, {kBlockStiffness, 0, friction, friction});
      t.scene.proxy.setRadius(radius);
      const Quat lean = fromRotationVector(-std::numbers::pi / 2 * Vec3::UnitY());
      const auto id = t.scene.add(ShapeKind::kPlane, Vec3::Zero(), {{0.01 + radius, 0, 0}, lean},
                                  {kBlockStiffness, 0, friction, friction});
      ASSERT_EQ(t.scene.setSurface(id, wall), ErrorCode::kOk);
      Transient ring;
      bool hit = false;
      const auto at = [&](double x, double depth, const Vec3& v) {
        t.at({x, 0, radius - depth}, v);
        if (!hit && x > 0.01 + friction * 1e-3) {  // The proxy is so far behind.
          hit = true;
          ring.strike(wall, 0.1, -Vec3::UnitX());
        }
        EXPECT_LT((t.forces.transient - ring.step()).norm(), 1e-9) << friction << " " << radius << " " << x;
      };
      at(0, -1e-3, Vec3::Zero());
      for (int i = 0; i < 120; ++i) at(1.001e-4 * i, 1e-3, {0.1, 0, 0});
      for (int i = 0; i < 300; ++i) at(0.012 + 2e-5 * (i % 3), 1e-3 + 2e-5 * (i % 2), {4e-3 * (i % 2), 0, 4e-3});
      for (int i = 0; i < 120; ++i) at(0.012 - 1.001e-4 * i, 1e-3, {-0.1, 0, 0});
      EXPECT_TRUE(hit);
    }
  }
}

/** Tiles of a floor are objects of their own: who slides from one to the next hits nothing. */
TEST(SurfaceEffects, SlidingFromTileToTileIsSilent) {
  Touch t(SurfaceParameters{});
  ASSERT_EQ(t.scene.remove(t.plane), ErrorCode::kOk);
  for (int i = 0; i < 4; ++i) {
    const auto id = t.scene.add(ShapeKind::kBox, Vec3(0.01, 0.01, 0.01), {{0.02 * i, 0, -0.01}, Quat::Identity()});
    ASSERT_EQ(t.scene.setSurface(id, test::ringing(20, 150, 0.01)), ErrorCode::kOk);
  }
  t.at({0, 0, 1e-3});
  t.at({0, 0, -1e-3});
  std::uint32_t last = 0;
  int crossed = 0;
  for (int i = 0; i < 600; ++i) {
    t.at({3.3e-5 + 1e-4 * i, 0, -1e-3}, {0.1, 0, 0});
    EXPECT_EQ(t.forces.transient, Vec3::Zero()) << i;
    if (t.scene.contact.object != last) ++crossed;
    last = t.scene.contact.object;
  }
  EXPECT_EQ(crossed, 4);
}

TEST(SurfaceEffects, AMovingSurfaceStrikesARestingHand) {
  Touch t(test::ringing(10, 150, 0.01));
  t.at({0, 0, 1e-4});
  t.scene.pose(t.plane, {}, {Vec3(0, 0, 0.2), Vec3::Zero()});
  t.at({0, 0, 1e-4});
  for (int i = 0; i < 3 && t.forces.transient.z() == 0; ++i) t.at({0, 0, 1e-4});
  const SurfaceParameters s = test::ringing(10, 150, 0.01);
  EXPECT_NEAR(t.forces.transient.z(), 10 * 0.2 * s.transient_first, 1e-9);
}

/** A sheet whose vertices a client moves 60 times a second. */
TEST(SurfaceEffects, ASheetThatIsMovedByItsVerticesStrikesWithItsSpeedAndBuzzes) {
  constexpr double kSpeed = 0.1;
  const TestVibration texture = buzz();
  test::TestMesh mesh = test::heightMesh(0.05, 8, [](double, double) { return 0.0; });
  Touch t(SurfaceParameters{}, &texture.view);
  ASSERT_EQ(t.scene.remove(t.plane), ErrorCode::kOk);
  const auto id = t.scene.addMesh(mesh.deformableView());
  SurfaceParameters s = test::ringing(10, 150, 0.01);
  s.vibration = 1;
  s.vibration_mass = 0.05;
  ASSERT_EQ(t.scene.setSurface(id, s), ErrorCode::kOk);
  const auto start = mesh.vertices;
  const Vec3 hip(0.0113, 0.0021, 0.005);
  double first = 0, most = 0;
  for (int i = 0; i < 100; ++i) {  // Up and aside.
    if (i % 17 == 0) {
      std::vector<hd_vertex_move> moves;
      for (std::uint32_t v = 0; v < start.size(); ++v) {
        const float way = static_cast<float>(kSpeed * 1e-3 * i);
        moves.push_back({v, {start[v][0] + way, start[v][1], start[v][2] + way}});
      }
      ASSERT_EQ(t.scene.moveVertices(id, moves), ErrorCode::kOk);
    }
    t.at(hip);
    if (first == 0) first = t.forces.transient.z();
    most = std::max(most, t.forces.texture().norm());
    ASSERT_NEAR(t.forces.texture().x(), 0, 1e-9) << "across the motion";
  }
  EXPECT_NEAR(first, 10 * kSpeed * s.transient_first, 1e-5);
  EXPECT_GT(most, 0.01);
}

/** In a corner each wall is lowered by its own relief and presses with its own stiffness, by whichever way it is come
 * to. */
TEST(SurfaceEffects, InACornerEachWallHasItsOwnRelief) {
  const TestRelief picture = waves();
  const double stiffness[2] = {kBlockStiffness, 3 * kBlockStiffness}, deep[2] = {5e-4, 2e-4};
  for (const bool both : {false, true}) {
    Touch t(relief(deep[0]), &picture.view, {stiffness[0], 0, 0, 0});
    const Quat lean = fromRotationVector(-std::numbers::pi / 2 * Vec3::UnitY());  // Its z is -x of the world.
    const auto wall = t.scene.add(ShapeKind::kPlane, Vec3::Zero(), {{0.01, 0, 0}, lean}, {stiffness[1], 0, 0, 0});
    if (both) {
      ASSERT_EQ(t.scene.setSurface(wall, relief(deep[1])), ErrorCode::kOk);
    }
    int in_corner = 0;
    for (int i = 0; i < 3000; ++i) {
      const Vec3 hip(0.01 + 1e-3 * std::sin(0.7 * i), 0.03 * std::cos(1.1 * i), 1e-3 * std::sin(0.31 * i));
      t.at(hip);
      Vec3 wanted = Vec3::Zero();
      if (hip.z() < 0) {
        const ReliefPoint r = reliefAt(picture.view.relief, relief(deep[0]), {hip.x(), hip.y(), 0}, Vec3::UnitZ());
        const double left = std::max(0.0, -hip.z() + r.height);
        wanted += stiffness[0] * left * (Vec3::UnitZ() - r.gradient);
      }
      if (hip.x() > 0.01) {
        const Vec3 foot = lean.conjugate() * Vec3(0, hip.y(), hip.z());
        ReliefPoint r;
        if (both) r = reliefAt(picture.view.relief, relief(deep[1]), foot, Vec3::UnitZ());
        const double left = std::max(0.0, hip.x() - 0.01 + r.height);
        wanted += stiffness[1] * left * (-Vec3::UnitX() - lean * r.gradient);
      }
      in_corner += hip.z() < 0 && hip.x() > 0.01;
      ASSERT_LT((t.total() - wanted).norm(), 1e-9) << i;
    }
    EXPECT_GT(in_corner, 500);
  }
}

/** In a groove a wall without stiffness bears what the other one leans on it; its relief adds nothing to that. */
TEST(SurfaceEffects, InAGrooveAWallWithoutStiffnessHasNoRelief) {
  const TestRelief picture = waves();
  for (const double half : {20.0, 30.0, 45.0, 60.0}) {
    for (const bool both : {false, true}) {
      const double lean = (90 - half) * std::numbers::pi / 180;
      TestScene scene;
      SurfaceEffects effects;
      scene.table->publishTexture(0, &picture.view);
      const auto wall = [&](double turn, double stiffness) {
        return scene.add(ShapeKind::kPlane, Vec3::Zero(), {Vec3::Zero(), fromRotationVector(turn * Vec3::UnitY())},
                         {stiffness, 0, 0, 0});
      };
      const std::uint32_t soft = wall(lean, 0), firm = wall(-lean, kBlockStiffness);
      ASSERT_EQ(scene.setSurface(soft, relief(1e-4)), ErrorCode::kOk);
      if (both) {
        ASSERT_EQ(scene.setSurface(firm, relief(1e-4)), ErrorCode::kOk);
      }
      scene.tick({0, 0, 0.02});
      for (int i = 1; i < 30; ++i) {
        const Vec3 hip(0, 0, -1e-4 * i);
        scene.tick(hip);
        ASSERT_EQ(scene.contact.parts, 2u);
        const Vec3 texture = effects.step(*scene.scene, scene.contact, {}, hip, Vec3::Zero()).texture();
        ASSERT_TRUE(isFinite(texture)) << half << " " << i;
        ASSERT_EQ(texture.isZero(0), !both);
      }
    }
  }
}

/** Total force = -gradient of k max(0, d + h)^2 / 2, by finite differences of that energy. */
TEST(SurfaceEffects, AReliefIsTheGradientOfItsEnergy) {
  const TestRelief picture = waves();
  const SurfaceParameters s = relief(5e-4);
  const auto energy = [&](const Vec3& hip) {
    const double left =
        std::max(0.0, -hip.z() + reliefAt(picture.view.relief, s, {hip.x(), hip.y(), 0}, Vec3::UnitZ()).height);
    return 0.5 * kBlockStiffness * left * left;
  };
  Touch t(s, &picture.view);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 hip(0.03 * std::sin(0.7 * i), 0.03 * std::cos(1.1 * i), -1e-5 * (i % 97) - 1e-6);
    t.at({hip.x(), hip.y(), 0.01});
    t.at(hip);
    Vec3 down;
    for (int axis = 0; axis < 3; ++axis) {
      const Vec3 e = 1e-8 * Vec3::Unit(axis);
      down[axis] = -(energy(hip + e) - energy(hip - e)) / 2e-8;
    }
    ASSERT_LT((t.total() - down).norm(), 2e-5) << i;
  }
}

/** Round a closed path in and out of the relief, at any speed: the work is that of rounding, halved with the step. */
TEST(SurfaceEffects, ATourOverAReliefCostsAndGivesNothing) {
  const TestRelief picture = waves();
  double before = 0;
  for (const int steps : {4000, 8000, 16000}) {
    Touch t(relief(5e-4), &picture.view);
    t.at({0, 0.005, 0.01});
    double work = 0, exchanged = 0;
    Vec3 last_x, last_f;
    for (int i = 0; i <= steps; ++i) {
      const double a = 2 * std::numbers::pi * i / steps;
      const Vec3 x(0.007 * std::sin(a), 0.005 * std::cos(2 * a), -5e-4 + 4e-4 * std::sin(3 * a));
      t.at(x);
      if (i > 0) {
        const double part = 0.5 * (t.total() + last_f).dot(x - last_x);
        work += part;
        exchanged += std::abs(part);
      }
      last_x = x;
      last_f = t.total();
    }
    EXPECT_GT(exchanged, 1e-4);
    EXPECT_LT(std::abs(work), 1e-4 * exchanged) << steps;
    before = work;
  }
  EXPECT_LT(std::abs(before), 1e-8);
}

/** Pressed hard or lightly, fast or slow: the same place gives the same force; and it never pulls. */
/** Whatever the body's motion: a hand that rests in its frame gets what the body is told to put in, and no more. */
TEST(SurfaceEffects, ACarriedReliefGivesWhatItIsChargedFor) {
  const TestRelief picture = waves();
  Touch t(relief(1e-3), &picture.view);
  const Twist V{Vec3(0.1, 0, -0.05), Vec3(8, -15, 4)};
  double aside = 0;
  for (int i = -10; i < 200; ++i) {
    const double time = i * test::kTick;
    const Pose X{time * V.v, Quat(Eigen::AngleAxisd(time * V.w.norm(), V.w.normalized()))};
    const Vec3 hip = X * Vec3(0.0113, 0.0021, i < 0 ? 0.001 : -0.003), v = V.v + V.w.cross(hip - X.p);
    t.scene.pose(t.plane, X, V);
    t.at(hip, v);
    const double charged = t.scene.contact.force.dot(t.scene.contact.velocity) + t.forces.carried.sum();
    ASSERT_NEAR(t.total().dot(v), charged, 1e-9) << i;
    aside = std::max(aside, t.forces.relief.cross(t.scene.contact.normal).norm());
  }
  EXPECT_GT(aside, 0.1);
}

/** Beside a wall too, and whether or not it rings: a sheet that its vertices raise to a hand above half its relief. */
TEST(SurfaceEffects, InACornerAReliefGoesWithTheVerticesBelowIt) {
  const TestRelief black(16, 16, [](auto, auto) { return 0.0; });
  for (const double gain : {0.0, 1e-9}) {
    TestScene scene;
    SurfaceEffects effects{3};
    scene.table->publishTexture(0, &black.view);
    test::TestMesh mesh = test::heightMesh(0.05, 1, [](double, double) { return 0.0; });
    const auto sheet = scene.addMesh(mesh.deformableView());
    const Quat lean = fromRotationVector(-std::numbers::pi / 2 * Vec3::UnitY());
    scene.add(ShapeKind::kPlane, Vec3::Zero(), {{0.01, 0, 0}, lean});
    SurfaceParameters s = gain > 0 ? test::ringing(gain, 150, 0.01) : SurfaceParameters{};
    s.relief = 1;
    s.relief_depth = 5e-4;
    s.relief_size[0] = s.relief_size[1] = 0.02;
    ASSERT_EQ(scene.setSurface(sheet, s), ErrorCode::kOk);
    scene.tick({0, 0, 0.001});
    for (int i = 1; i <= 20; ++i) {
      const double z = 1e-4 * i;
      std::vector<hd_vertex_move> moves;
      for (std::uint32_t v = 0; v < 4; ++v)
        moves.push_back({v, {mesh.vertices[v][0], mesh.vertices[v][1], static_cast<float>(z)}});
      ASSERT_EQ(scene.moveVertices(sheet, moves), ErrorCode::kOk);
      const Vec3 hip(std::min(0.011, 0.001 * i), 0, z - 0.001);
      scene.tick(hip);
      const SurfaceForces forces = effects.step(*scene.scene, scene.contact, scene.proxy.holding(), hip, Vec3::Zero());
      if (i < 15) continue;
      ASSERT_EQ(scene.contact.parts, 2u) << i;
      ASSERT_NEAR(forces.relief.z(), -0.5, 1e-5) << gain;
      ASSERT_NEAR(forces.carried.z(), -0.5 * 0.1, 1e-5) << gain;
    }
  }
}

TEST(SurfaceEffects, AReliefDependsOnPlaceAlone) {
  const TestRelief picture = waves();
  Touch slow(relief(5e-4), &picture.view), fast(relief(5e-4), &picture.view);
  const Vec3 hip(0.0031, 0.0022, -6e-4);
  slow.at({0, 0, 0.01});
  for (int i = 0; i <= 100; ++i) slow.at(Vec3(hip.x() * i / 100, hip.y() * i / 100, hip.z()));
  fast.at({0, 0, 0.01});
  fast.at(hip, {3, -2, -5});
  EXPECT_LT((slow.total() - fast.total()).norm(), 1e-9);
  for (int i = 0; i < 5000; ++i) {
    fast.at({0.02 * std::sin(0.01 * i), 0.02 * std::cos(0.017 * i), -1e-7 * i});
    ASSERT_GE(fast.total().z(), -1e-12) << i;
  }
}

TEST(SurfaceEffects, VibrationActsAcrossTheMotionAndWithoutItNotAtAll) {
  const TestVibration texture = buzz();
  SurfaceParameters s{};
  s.vibration = 1;
  s.vibration_mass = 0.05;
  Touch t(s, &texture.view);
  t.at({0, 0, 0.01});
  double sum = 0, most = 0;
  for (int i = 0; i < 3000; ++i) {
    const Vec3 v(0.1 * std::cos(0.01 * i), 0.1 * std::sin(0.01 * i), 0.02);
    t.at({0, 0, -1e-3}, v);
    ASSERT_NEAR(t.forces.texture().dot(v), 0, 1e-12) << "it does no work";
    ASSERT_EQ(t.forces.texture().z(), 0);
    sum += t.forces.texture().squaredNorm();
    most = std::max(most, t.forces.texture().norm());
  }
  EXPECT_GT(sum / 3000, 0.05 * 0.05 * 4);
  EXPECT_LE(most, kBlockStiffness * 1e-3) << "never more than the normal force";
  t.at({0, 0, -1e-3});
  EXPECT_EQ(t.forces.texture(), Vec3::Zero()) << "no motion";
  t.at({0, 0, 1e-3}, {0.1, 0, 0});
  EXPECT_EQ(t.forces.texture(), Vec3::Zero()) << "no contact";
}

/** Of the floor, which is hardly touched, however hard the hand leans on the wall beside it. */
/** A hand deep in a plate that turns goes along with it: another speed than the surface above it, but nothing slides.
 */
TEST(SurfaceEffects, WhoTurnsAlongDoesNotSlide) {
  const TestVibration texture = buzz();
  SurfaceParameters s{};
  s.vibration = 1;
  s.vibration_mass = 0.05;
  for (const auto& [slides, radius] : {std::pair{0.0, 0.0}, {0.04, 0.0}, {0.0, 1e-3}}) {
    Touch t(s, &texture.view);
    t.scene.proxy.setRadius(radius);
    const Twist V{Vec3::Zero(), Vec3(3, -20, 0)};
    double most = 0;
    for (int i = -10; i < 300; ++i) {
      const Pose X{Vec3::Zero(), Quat(Eigen::AngleAxisd(i * test::kTick * V.w.norm(), V.w.normalized()))};
      const Vec3 hip = X * Vec3(0.01 + slides * test::kTick * i, 0.002, i < 0 ? 0.002 : -0.002);
      t.scene.pose(t.plane, X, V);
      t.at(hip, V.w.cross(hip) + X.q * Vec3(slides, 0, 0));
      most = std::max(most, t.forces.vibration.norm());
    }
    EXPECT_EQ(most > 1e-6, slides > 0) << most;
  }
}

TEST(SurfaceEffects, InACornerAVibrationIsNoStrongerThanItsOwnSurfacePresses) {
  TestVibration texture = buzz();
  for (VibrationModel& m : texture.models) m.power = 1e4;
  texture.finish();
  SurfaceParameters s{};
  s.vibration = 1;
  s.vibration_mass = 0.05;
  Touch t(s, &texture.view);
  const Quat lean = fromRotationVector(-std::numbers::pi / 2 * Vec3::UnitY());
  t.scene.add(ShapeKind::kPlane, Vec3::Zero(), {{0.01, 0, 0}, lean}, {kBlockStiffness, 0, 0, 0});
  t.at({0, 0, 1e-3});
  for (int i = 0; i < 60; ++i) t.at({2.5e-4 * i, 0, -1e-4});
  double most = 0;
  for (int i = 0; i < 1000; ++i) {
    t.at({0.015, 1e-4 * i, -1e-4}, {0, 0.1, 0});
    ASSERT_EQ(t.scene.contact.object, t.plane);
    ASSERT_EQ(t.scene.contact.parts, 2u);
    most = std::max(most, t.forces.vibration.norm());
  }
  EXPECT_NEAR(most, kBlockStiffness * 1e-4, 1e-9) << "of 5.1 N in all";
}

/** What is felt begins at the ground of the hollow, 2 mm down: a hand above it hears no knock and no buzz. */
TEST(SurfaceEffects, AHollowOfAReliefIsSilent) {
  const TestRelief black(16, 16, [](auto, auto) { return 0.0; });
  const TestVibration texture = buzz();
  Touch t(SurfaceParameters{}, &black.view);
  t.scene.table->publishTexture(1, &texture.view);
  SurfaceParameters s = test::ringing(10, 150, 0.01);
  s.relief = 1;
  s.relief_depth = 2e-3;
  s.relief_size[0] = s.relief_size[1] = 0.02;
  s.vibration = 2;
  s.vibration_mass = 0.05;
  ASSERT_EQ(t.scene.setSurface(t.plane, s), ErrorCode::kOk);
  t.at({0, 0, 1e-3});
  for (int i = 0; i < 30; ++i) {
    t.at({0, 0, -5e-5 * i}, {0, 0, -0.05});
    ASSERT_LT(t.total().norm(), 1e-12) << i;
    ASSERT_EQ(t.forces.transient, Vec3::Zero()) << i;
  }
  for (int i = 0; i < 200; ++i) {
    t.at({2e-4 * i, 0, -1.5e-3}, {0.2, 0, 0});
    ASSERT_LT(t.total().norm(), 1e-12) << i;
    ASSERT_EQ(t.forces.transient, Vec3::Zero()) << i;
  }
  t.at({0.04, 0, -2.05e-3}, {0.2, 0, -0.05});
  EXPECT_NEAR(t.forces.transient.z(), 10 * 0.05 * s.transient_first, 1e-9) << "the ground knocks, once";
  double most = 0;
  for (int i = 0; i < 200; ++i) {
    t.at({2e-4 * i, 0, -2.05e-3}, {0.2, 0, 0});
    most = std::max(most, t.forces.texture().head<2>().norm());
  }
  EXPECT_GT(most, 0.01) << "and buzzes";
  EXPECT_LE(most, kBlockStiffness * 5e-5 * (1 + 1e-6)) << "never more than the normal force that is left";
}

TEST(SurfaceEffects, ATextureThatIsNotThereIsRefused) {
  const TestVibration vibration = buzz();
  TestScene t;
  const std::uint32_t plane = t.add(ShapeKind::kPlane, Vec3::Zero());
  SurfaceParameters s = relief(1e-3);
  EXPECT_EQ(t.setSurface(plane, s), ErrorCode::kNotFound);
  t.table->publishTexture(0, &vibration.view);
  EXPECT_EQ(t.setSurface(plane, s), ErrorCode::kNotFound) << "a vibration is no relief";
  s.relief = kMaxTextures + 1;
  EXPECT_EQ(t.setSurface(plane, s), ErrorCode::kNotFound);
  s = test::ringing(10, 150, 0.01);
  EXPECT_EQ(t.setSurface(plane + 1, s), ErrorCode::kNotFound);
  s.transient_decay = 1;
  EXPECT_EQ(t.setSurface(plane, s), ErrorCode::kInvalidArgument) << "it would never end";
  s = {};
  s.transient_gain = std::nan("");
  EXPECT_EQ(t.setSurface(plane, s), ErrorCode::kInvalidArgument);
}

}  // namespace
}  // namespace hapticd
