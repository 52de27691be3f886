#include "rt/render/model/model_force.h"

#include <gtest/gtest.h>

#include <numbers>

#include "tests/support/random.h"
#include "tests/support/seeds.h"
#include "tests/unit/render/model_rig.h"

namespace hapticd {
namespace {

void expectNear(const Vec3& got, const Vec3& want, double tolerance = 1e-12) {
  EXPECT_LT((got - want).norm(), tolerance) << got.transpose() << " instead of " << want.transpose();
}

TEST(ModelForce, PlaneIsASpringDamperThatNeverPulls) {
  LoneModel plane(modelOf(HD_MODEL_PLANE, 500, 4));
  expectNear(plane.at({0.1, -0.2, 0.001}), {0, 0, 0});
  expectNear(plane.at({0.1, -0.2, -0.002}), {0, 0, 1});
  expectNear(plane.at({0, 0, -0.002}, {5, 5, -0.1}), {0, 0, 1.4});
  expectNear(plane.at({0, 0, -0.002}, {0, 0, 0.1}), {0, 0, 0.6});
  expectNear(plane.at({0, 0, -0.002}, {0, 0, 1.0}), {0, 0, 0});
  expectNear(plane.at({0, 0, -0.002}, {0, 0, -5}), {0, 0, 2});
  expectNear(plane.at({0, 0, -1e-9}, {0, 0, -5}), {0, 0, 1e-6}, 1.1e-6);
}

TEST(ModelForce, SphereFromOutsideAndFromInside) {
  hd_local_model m = modelOf(HD_MODEL_SPHERE);
  m.origin[0] = 0.1;
  LoneModel ball(m);
  expectNear(ball.at({0.1, 0.019, 0}), {0, 0.5, 0});
  expectNear(ball.at({0.1, 0.021, 0}), {0, 0, 0});
  m.radius = -0.02;
  LoneModel shell(m);
  expectNear(shell.at({0.1, 0.021, 0}), {0, -0.5, 0});
  expectNear(shell.at({0.1, 0.019, 0}), {0, 0, 0});
  expectNear(shell.at({0.1, 0, 0}), {0, 0, 0});
}

TEST(ModelForce, SpringsPullBothWaysAndHaveALength) {
  LoneModel spring(modelOf(HD_MODEL_SPRING, 100, 2));
  expectNear(spring.at({0.01, 0.02, 0}), {-1, -2, 0});
  expectNear(spring.at({0, 0, 0}, {0.1, 0, 0}), {-0.2, 0, 0});
  hd_local_model m = modelOf(HD_MODEL_SPRING, 100, 0);
  m.radius = 0.03;
  LoneModel rod(m);
  expectNear(rod.at({0.05, 0, 0}), {-2, 0, 0});
  expectNear(rod.at({0, 0.02, 0}), {0, 1, 0});
  m.material.damping = 2;
  expectNear(LoneModel(m).at({0.05, 0, 0}, {0.1, 5, -3}), {-2.2, 0, 0});  // Along itself alone.
}

TEST(ModelForce, FieldIsLinearAndFadesAtItsRim) {
  hd_force_field f{};
  f.lease_ns = 1000 * kMs;
  f.radius = 0.01;
  f.x0[1] = 0.5;
  f.f0[2] = 1;
  f.jacobian[1] = 200;  // dFx/dy
  LoneModel field(f);
  expectNear(field.at({0, 0.5, 0}), {0, 0, 1});
  expectNear(field.at({0, 0.508, 0}), {1.6, 0, 1});
  expectNear(field.at({0, 0.509, 0}), {0.9, 0, 0.5});
  expectNear(field.at({0, 0.5100001, 0}), {0, 0, 0});
}

/** Largest |change of force| / |change of place| met on random walks through and about the model. */
double steepest(LoneModel model, double reach, unsigned seed) {
  std::uint32_t state = seedOf(seed);
  const auto random = [&state] {
    state = state * 1664525u + 1013904223u;
    return (state >> 8) * (2.0 / (1 << 24)) - 1;
  };
  double worst = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vec3 p = reach * Vec3(random(), random(), random());
    const Vec3 step = 1e-6 * Vec3(random(), random(), random());
    worst = std::max(worst, (model.at(p + step) - model.at(p)).norm() / step.norm());
  }
  return worst;
}

TEST(ModelForce, NothingJumpsAsTheToolMoves) {
  // Frictionless, at rest: a jump would show as a slope of its height over a micrometre.
  EXPECT_LT(steepest(LoneModel(modelOf(HD_MODEL_PLANE)), 0.01, 1), 501);
  EXPECT_LT(steepest(LoneModel(modelOf(HD_MODEL_SPHERE)), 0.021, 2), 500 * 11) << "steepest in the inner tenth";
  hd_local_model inside = modelOf(HD_MODEL_SPHERE);
  inside.radius = -0.01;
  EXPECT_LT(steepest(LoneModel(inside), 0.012, 3), 501);
  hd_local_model rod = modelOf(HD_MODEL_SPRING);
  rod.radius = 0.01;
  EXPECT_LT(steepest(LoneModel(rod), 0.012, 4), 500 * 11);
  hd_local_model box = modelOf(HD_MODEL_HALFSPACES);
  hd_local_model corner = modelOf(HD_MODEL_CORNER);
  for (int axis = 0; axis < 3; ++axis) {
    setHalfspace(box, Vec3::Unit(axis), 0.002);
    setHalfspace(box, -Vec3::Unit(axis), 0.002);
    setHalfspace(corner, Vec3::Unit(axis) + Vec3(0.1, 0.2, 0.3), 0.001 * axis);
  }
  EXPECT_LT(steepest(LoneModel(box), 0.003, 5), 500 * (1 + 2 * 3 * 0.002 / 0.5e-3));
  EXPECT_LT(steepest(LoneModel(corner), 0.005, 6), 501);
}

/** A plane with friction 0.8 / 0.5, 2 mm deep: static cone 1.6 mm, dynamic cone 1 mm. */
hd_local_model roughPlane() {
  hd_local_model m = modelOf(HD_MODEL_PLANE, 500);
  m.material.friction_static = 0.8;
  m.material.friction_dynamic = 0.5;
  return m;
}

TEST(ModelForce, FrictionSticksThenSlips) {
  LoneModel plane(roughPlane());
  const auto at = [&](double x_mm) { return plane.at({x_mm * 1e-3, 0, -0.002}); };
  expectNear(at(0), {0, 0, 1});
  expectNear(at(1.59), {-0.795, 0, 1});
  EXPECT_FALSE(plane.model.slips());
  expectNear(at(0.5), {-0.25, 0, 1});  // Sticking: back to the anchor is back to zero.
  expectNear(at(1.61), {-0.5, 0, 1});  // Out of the static cone: on the border of the dynamic one.
  EXPECT_TRUE(plane.model.slips());
  expectNear(at(2.61), {-0.5, 0, 1});  // Sliding: mu_d N, whatever the way.
  expectNear(at(2.60), {-0.495, 0, 1});
  EXPECT_FALSE(plane.model.slips()) << "inside the dynamic cone the slip ends";
  expectNear(at(3.20), {-0.795, 0, 1});  // The anchor stands at 1.61 mm, and the static cone counts again.
  EXPECT_FALSE(plane.model.slips());
}

TEST(ModelForce, AWithdrawingHandIsHeldByWhatDampingLeaves) {
  constexpr double kDamping = 10, kMu = 0.4, kTick = 1e-3;
  for (const double out : {0.0, 0.02, 0.05, 0.1, 0.5}) {
    hd_local_model m = modelOf(HD_MODEL_PLANE, 500, kDamping);
    m.material.friction_static = m.material.friction_dynamic = kMu;
    LoneModel plane(m);
    const Vec3 along(0.1, 0, 0);
    for (int i = 0; i < 200; ++i) (void)plane.at(Vec3(0, 0, -3e-3) + i * kTick * along, along);
    for (int i = 200; i < 205; ++i) {
      const double depth = 3e-3 - (i - 200) * kTick * out;
      const double normal = std::max(0.0, 500 * depth - kDamping * out);
      expectNear(plane.at(Vec3(0, 0, -depth) + i * kTick * along, along + Vec3(0, 0, out)), {-kMu * normal, 0, normal});
    }
  }
}

TEST(ModelForce, DampingAndFrictionTogetherGiveNothing) {
  Random random(seedOf(6));
  for (int round = 0; round < 80; ++round) {
    hd_local_model m = modelOf(HD_MODEL_PLANE, 500, random.in(2, 22));
    m.material.friction_static = random.in(0.2, 1);
    m.material.friction_dynamic = 0.7 * m.material.friction_static;
    LoneModel plane(m);
    // A closed path that wanders into the plane and out of it, also along it.
    Vec3 sine[4], cosine[4];
    for (int k = 0; k < 4; ++k) {
      sine[k] = random.vector(0.003 / (k + 1));
      cosine[k] = random.vector(0.003 / (k + 1));
    }
    constexpr int kTicks = 4000;
    double gained = 0, exchanged = 0;
    for (int i = 0; i < 2 * kTicks; ++i) {
      Vec3 p = Vec3::Zero(), v = Vec3::Zero();
      for (int k = 0; k < 4; ++k) {
        const double w = 2 * std::numbers::pi * (k + 1) / kTicks, phase = w * i;
        p += std::sin(phase) * sine[k] + std::cos(phase) * cosine[k];
        v += 1e3 * w * (std::cos(phase) * sine[k] - std::sin(phase) * cosine[k]);
      }
      const double part = 1e-3 * plane.at(p, v).dot(v);
      if (i < kTicks) continue;  // From round to round it is the same.
      gained += part;
      exchanged += std::abs(part);
    }
    EXPECT_LE(gained, 1e-3 * exchanged) << round;
  }
}

/** Where the normal turns as the hand moves, and so does what lies across it. */
TEST(ModelForce, NoWayRoundInsideTheConeGives) {
  hd_local_model ball = modelOf(HD_MODEL_SPHERE), shell = ball, ridge = modelOf(HD_MODEL_HALFSPACES), corner = ridge;
  corner.kind = HD_MODEL_CORNER;
  shell.radius = -ball.radius;
  store(Vec3(0, 0, -0.02), ball.origin);
  store(Vec3(0, 0, 0.02), shell.origin);
  for (const double side : {-0.3, 0.3}) {
    setHalfspace(ridge, {side, 0, 1}, 0);
    setHalfspace(corner, {side, 0, 1}, 0);
  }
  constexpr int kTicks = 4000;
  for (hd_local_model m : {ball, shell, ridge, corner}) {
    for (const double mu : {0.3, 0.8, 1.5}) {
      m.material.friction_static = m.material.friction_dynamic = mu;
      for (const double sense : {-1, 1}) {
        SCOPED_TRACE(testing::Message() << m.kind << ", radius " << m.radius << ", " << mu << ", " << sense);
        LoneModel model(m);
        (void)model.at({0, 0, -1e-6});
        double gained = 0, exchanged = 0, stored = 0;
        Vec3 last_p = Vec3::Zero(), last_f = last_p;
        for (int i = 0; i <= 3 * kTicks; ++i) {
          if (i == kTicks) {  // From here on it is another, that says the same.
            m.origin[1] = 1e-12;
            LoneModel next(m);
            next.model.inherit(model.model, {}, {});
            model = next;
          }
          const double turn = sense * 2 * std::numbers::pi * i / kTicks;
          const double depth = std::min(0.002, 1e-6 * i) - 0.0005 * std::cos(turn);
          const Vec3 p(0.6e-3 * std::min(mu, 1.0) * (1 + std::sin(turn)), 0, -depth);
          const ModelForce now = model.model.evaluate(p, Vec3::Zero(), {});
          const double part = 0.5 * (now.force + last_f).dot(p - last_p);
          if (i > kTicks) {
            gained += part;
            exchanged += std::abs(part);
            if (!model.model.slips()) {
              ASSERT_NEAR(now.stored - stored, -part, 1e-4 * std::abs(part) + 1e-12) << i;
            }
          }
          last_p = p;
          last_f = now.force;
          stored = now.stored;
        }
        EXPECT_LE(gained, 1e-4 * exchanged);
      }
    }
  }
}

TEST(ModelForce, AHandThatRestsWhileItSlidesDoesNotStick) {
  // Encoders let most ticks of a slow hand pass without a move; rounding must not end the slip there.
  for (int turn = 0; turn < 100; ++turn) {
    const Vec3 along(std::cos(turn), std::sin(turn), 0);
    LoneModel plane(roughPlane());
    (void)plane.at({0, 0, -0.002});
    for (int step = 0; step < 30; ++step) {
      for (int tick = 0; tick < 4; ++tick) {
        const Vec3 f = plane.at((0.002 + 5e-5 * step) * along - 0.002 * Vec3::UnitZ());
        ASSERT_TRUE(plane.model.slips()) << turn << " " << step << " " << tick;
        ASSERT_NEAR(f.dot(along), -0.5, 1e-6) << turn << " " << step << " " << tick;
      }
    }
  }
}

TEST(ModelForce, PlanesThatFollowAHollowDoNotStick) {
  // Each plane of a client at 30 Hz leans back against the way: what slipped finds itself inside the cone.
  constexpr double kRadius = 0.01, kDepth = 0.002;
  LocalModel model;
  int slips = 0;
  for (int i = 0; i < 1500; ++i) {
    const double a = -0.8 + 2e-5 * i / kRadius;
    const Vec3 out(std::sin(a), 0, -std::cos(a));
    if (i % 33 == 0) {
      hd_local_model m = roughPlane();
      store(Vec3(-out), m.normal);
      store(Vec3(kRadius * out), m.origin);
      LocalModel next;
      ASSERT_EQ(next.set(commandOf(m)), ErrorCode::kOk);
      if (i > 0) next.inherit(model, {}, {});
      model = next;
    }
    (void)model.evaluate((kRadius + kDepth) * out, Vec3::Zero(), {});
    if (slips > 0) {
      ASSERT_TRUE(model.slips()) << i;
    }
    slips += model.slips();
  }
  EXPECT_GT(slips, 1000);
}

/** A plane that a client lifts lifts the hand that sticks to the one before: what is handed on is the way across. */
TEST(ModelForce, AnAnchorThatIsHandedOnLiesOnTheNewSurface) {
  LocalModel model, lifted;
  ASSERT_EQ(model.set(commandOf(roughPlane())), ErrorCode::kOk);
  (void)model.evaluate({0, 0, -0.002}, Vec3::Zero(), {});
  expectNear(model.evaluate({0.001, 0, -0.002}, Vec3::Zero(), {}).force, {-0.5, 0, 1});
  hd_local_model m = roughPlane();
  m.origin[2] = 0.001;
  ASSERT_EQ(lifted.set(commandOf(m)), ErrorCode::kOk);
  lifted.inherit(model, {}, {});
  expectNear(lifted.evaluate({0.001, 0, -0.002}, Vec3::Zero(), {}).force, {-0.5, 0, 1.5});
  EXPECT_FALSE(lifted.slips());
  expectNear(lifted.evaluate({0.0005, 0, -0.002}, Vec3::Zero(), {}).force, {-0.25, 0, 1.5});
}

TEST(ModelForce, LeavingTheSurfaceForgetsTheAnchor) {
  LoneModel plane(roughPlane());
  (void)plane.at({0, 0, -0.002});
  (void)plane.at({0.001, 0, -0.002});
  (void)plane.at({0.001, 0, 0.001});
  expectNear(plane.at({0.001, 0, -0.002}), {0, 0, 1});
}

TEST(ModelForce, SlidingAroundABallFeelsFrictionAgainstTheMotion) {
  hd_local_model m = roughPlane();
  m.kind = HD_MODEL_SPHERE;
  m.radius = 0.02;
  LoneModel ball(m);
  for (int i = 0; i < 2000; ++i) {
    const double a = i * 1e-3;
    const Vec3 out(std::cos(a), std::sin(a), 0);
    const Vec3 along(-std::sin(a), std::cos(a), 0);
    const Vec3 f = ball.at(0.018 * out);
    ASSERT_NEAR(f.dot(out), 1, ball.model.slips() ? 1e-9 : 0.05);
    if (i > 200) {
      ASSERT_NEAR(f.dot(along), -0.5, 5e-3) << i;
    }
  }
}

TEST(ModelForce, AtAnEdgeTheFrictionConeClosesWithTheNormalForce) {
  hd_local_model m = roughPlane();
  m.kind = HD_MODEL_HALFSPACES;
  setHalfspace(m, Vec3::UnitX(), 0);
  setHalfspace(m, Vec3::UnitY(), 0);
  LoneModel wedge(m);
  const double depth = 0.002 - 0.5e-3 / 4;  // The fillet of solidDepth: half of each normal.
  const double normal = 500 * depth * std::sqrt(0.5);
  expectNear(wedge.at({-0.002, -0.002, 0}), {normal * std::sqrt(0.5), normal * std::sqrt(0.5), 0}, 1e-9);
  EXPECT_NEAR(wedge.at({-0.002, -0.002, 0.01}).z(), -0.5 * normal, 1e-9);
}

/** A hand that is pushed straight through, off the line of symmetry by `aside`. */
void passThrough(const hd_local_model& m, double reach, double aside) {
  LoneModel solid(m);
  hd_local_model smooth = m;
  smooth.material.friction_static = smooth.material.friction_dynamic = 0;
  double before = 0;
  const double mu = m.material.friction_static;
  for (double z = reach; z > -reach; z -= reach / 400.5) {
    const Vec3 p(aside, 0, z);
    LoneModel fresh(smooth);  // What has not come from anywhere.
    const double force = solid.at(p).z(), want = fresh.at(p).z();
    EXPECT_GT(force * z, -1e-9) << "it pulls at " << z << " of " << reach << ", mu " << mu << ", aside " << aside;
    if (mu == 0 || z < 0) {
      EXPECT_NEAR(force, want, 0.01 * m.material.stiffness * reach) << z << " " << aside;
    }
    EXPECT_LT(std::abs(force - before), 0.12 * m.material.stiffness * reach) << z << " " << aside;
    before = force;
  }
}

TEST(ModelForce, WhoIsPushedThroughIsNotPulledBack) {
  for (const double mu : {0.0, 0.3}) {
    for (const double aside : {0.0, 1e-9, 1e-6, 1e-5}) {
      hd_local_model ball = modelOf(HD_MODEL_SPHERE);
      ball.material.friction_static = ball.material.friction_dynamic = mu;
      passThrough(ball, ball.radius, aside);
      hd_local_model plate = modelOf(HD_MODEL_HALFSPACES);
      plate.material = ball.material;
      setHalfspace(plate, {0, 0, 1}, 0.002);
      setHalfspace(plate, {0, 0, -1}, 0.002);
      passThrough(plate, 0.002, aside);
    }
  }
}

TEST(ModelForce, AFrictionlessWedgeIsAsStiffInItsMiddleAsBeside) {
  hd_local_model wedge = modelOf(HD_MODEL_HALFSPACES);
  setHalfspace(wedge, {1, 0, 1}, 0);
  setHalfspace(wedge, {-1, 0, 1}, 0);
  LoneModel middle(wedge), beside(wedge);
  for (double depth = 0; depth < 0.01; depth += 1e-4)
    expectNear(middle.at({0, 0, -depth}), beside.at({1e-9, 0, -depth}), 1e-5);
}

TEST(ModelForce, ABallStoresWhatItsForceHasTaken) {
  LoneModel ball(modelOf(HD_MODEL_SPHERE));
  double taken = 0;
  constexpr double kStep = 1e-6;
  for (double z = 0.02; z > kStep; z -= kStep) {
    taken += kStep * ball.at({1e-9, 0, z - kStep / 2}).z();
    const ModelForce there = ball.model.evaluate({1e-9, 0, z - kStep}, Vec3::Zero(), {});
    EXPECT_NEAR(there.stored, taken, 1e-6) << z;
  }
}

TEST(ModelForce, MovesAlongWithItsFrame) {
  LocalModel model;
  ASSERT_EQ(model.set(commandOf(modelOf(HD_MODEL_PLANE, 500, 4))), ErrorCode::kOk);
  ModelFrame frame;
  frame.X_WF.p = {0, 0.02, 0.1};
  frame.X_WF.q = Quat(Eigen::AngleAxisd(M_PI / 2, Vec3::UnitY()));  // The plane's z is W's x.
  frame.V_WF.v = {0.2, 0, 0};
  const ModelForce f = model.evaluate({-0.002, 0.3, 0.1}, {0.2, 0, 0}, frame);
  expectNear(f.force, {1, 0, 0});  // No damping: the hand goes with the plane.
  expectNear(f.carried, {0.2, 0, 0});
  EXPECT_NEAR(f.stored, 0.5 * 500 * 4e-6, 1e-12);
  frame.V_WF.w = {0, 0, 1};
  const ModelForce turning = model.evaluate({-0.002, 0.05, 0.1}, {0.2, 0, 0}, frame);
  expectNear(turning.force, {1 + 4 * -0.03, 0, 0});  // The plane there moves at 0.17 m/s, the hand leaves it.
}

TEST(ModelForce, EdgesAreAsRoundAsTheClientSays) {
  // Two faces 0.05 rad apart, the tool 1 mm under their edge: half a radius of 0.1 mm is shared by two, a sharp edge
  // loses nothing, and where nothing is said it is the 0.5 mm of the header.
  const auto force = [](double radius) {
    hd_local_model ridge = modelOf(HD_MODEL_HALFSPACES, 1000);
    ridge.radius = radius;
    setHalfspace(ridge, {0.025, 0, 1}, 0);
    setHalfspace(ridge, {-0.025, 0, 1}, 0);
    return LoneModel(ridge).at({1e-7, 0, -0.001}).norm();
  };
  const double full = 1 / std::hypot(1, 0.025);
  EXPECT_NEAR(force(1e-9), full, 1e-5);
  EXPECT_NEAR(force(1e-4), (full - 0.025) / std::hypot(1, 0.025), 1e-5);
  EXPECT_NEAR(force(0), (full - 0.125) / std::hypot(1, 0.025), 1e-5);
}

/** A recording says a model anew; a client that then sends its own once more must find it there. */
TEST(ModelForce, SaidAnewItIsTheSameToTheBit) {
  Random random(7);
  for (int i = 0; i < 3000; ++i) {
    for (const auto kind : {HD_MODEL_PLANE, HD_MODEL_HALFSPACES, HD_MODEL_CORNER}) {
      hd_local_model m = modelOf(kind);
      const Vec3 n = random.vector(1).normalized();
      store(i % 2 == 0 ? n : Vec3(random.in(0.6, 1.9) * n), m.normal);
      if (kind != HD_MODEL_PLANE) setHalfspace(m, random.vector(1).normalized(), 1e-3);
      LocalModel model, again;
      ASSERT_EQ(model.set(commandOf(m)), ErrorCode::kOk);
      ASSERT_EQ(again.set(model.command()), ErrorCode::kOk);
      ASSERT_TRUE(again.isSame(model)) << kind << " " << i;
    }
  }
}

/** Within half and twice the length. */
TEST(ModelForce, NormalsOfAnyLengthAreMadeUnit) {
  for (const float length : {0.6F, 1.0F, 1.9F}) {
    hd_local_model plane = modelOf(HD_MODEL_PLANE), solid = modelOf(HD_MODEL_HALFSPACES);
    plane.normal[2] = length;
    solid.halfspace[solid.count++][2] = length;
    EXPECT_LT((LoneModel(plane).at({0, 0, -0.002}) - Vec3(0, 0, 1)).norm(), 1e-6) << length;
    EXPECT_LT((LoneModel(solid).at({0, 0, -0.002}) - Vec3(0, 0, 1)).norm(), 1e-6) << length;
  }
}

TEST(ModelForce, AFieldIsSaidAnewAndTheSameOnlyIfItIs) {
  hd_force_field f{};
  f.radius = 0.1;
  f.f0[0] = 2;
  f.lease_ns = 7;
  LocalModel model, again;
  ASSERT_EQ(model.set(commandOf(f)), ErrorCode::kOk);
  ASSERT_EQ(again.set(model.command()), ErrorCode::kOk);
  EXPECT_TRUE(again.isSame(model));
  EXPECT_EQ(again.lease_ns(), 7);
  EXPECT_EQ(again.evaluate(Vec3::Zero(), Vec3::Zero(), {}).active, Vec3(2, 0, 0));
  f.lease_ns = 9;
  ASSERT_EQ(again.set(commandOf(f)), ErrorCode::kOk);
  EXPECT_TRUE(again.isSame(model)) << "another lease is no other law";
  f.f0[0] = 3;
  ASSERT_EQ(again.set(commandOf(f)), ErrorCode::kOk);
  EXPECT_FALSE(again.isSame(model));
  EXPECT_FALSE(LocalModel().isSame(LocalModel())) << "none is no model";
  f.radius = 0;
  EXPECT_EQ(again.set(commandOf(f)), ErrorCode::kInvalidArgument);
  f.radius = 0.1;
  f.device = kMaxDevices;
  EXPECT_EQ(again.set(commandOf(f)), ErrorCode::kInvalidArgument);
}

TEST(ModelForce, RefusesWhatIsNoModel) {
  LocalModel model;
  hd_local_model m = modelOf(HD_MODEL_PLANE);
  m.normal[2] = 0;
  EXPECT_EQ(model.set(commandOf(m)), ErrorCode::kInvalidArgument);
  m = modelOf(HD_MODEL_HALFSPACES);
  EXPECT_EQ(model.set(commandOf(m)), ErrorCode::kInvalidArgument);
  m.count = HD_HALFSPACES + 1;
  EXPECT_EQ(model.set(commandOf(m)), ErrorCode::kInvalidArgument);
  m = modelOf(HD_MODEL_HALFSPACES);
  setHalfspace(m, {0, 0, 1}, 0);
  m.radius = -1e-3;
  EXPECT_EQ(model.set(commandOf(m)), ErrorCode::kInvalidArgument);
  m = modelOf(HD_MODEL_CORNER);
  while (m.count < HD_HALFSPACES) setHalfspace(m, {0, 0, 1}, 0);
  m.radius = -1;
  ASSERT_EQ(LocalModel().set(commandOf(m)), ErrorCode::kOk) << "as many as there are; a corner has no radius";
  ++m.count;
  EXPECT_EQ(model.set(commandOf(m)), ErrorCode::kInvalidArgument);
  m.count = 2;
  m.halfspace[1][2] = 0;
  EXPECT_EQ(model.set(commandOf(m)), ErrorCode::kInvalidArgument) << "one of them has no normal";
  m = modelOf(HD_MODEL_SPRING);
  m.radius = -1e-3;
  EXPECT_EQ(model.set(commandOf(m)), ErrorCode::kInvalidArgument);
  m = modelOf(HD_MODEL_SPHERE);
  m.radius = 0;
  EXPECT_EQ(model.set(commandOf(m)), ErrorCode::kInvalidArgument);
  m = modelOf(HD_MODEL_PLANE);
  m.device = kMaxDevices;
  EXPECT_EQ(model.set(commandOf(m)), ErrorCode::kInvalidArgument);
  m.device = 0;
  m.kind = 77;
  EXPECT_EQ(model.set(commandOf(m)), ErrorCode::kInvalidArgument);
  EXPECT_TRUE(model.none());
}

}  // namespace
}  // namespace hapticd
