/** @file
 * Random scenes and hands: what must hold of the proxy whatever comes. A failure names its seed.
 */
#include <gtest/gtest.h>

#include "tests/support/for_seeds.h"
#include "tests/support/shape/brute_distance.h"
#include "tests/support/shape/test_mesh.h"
#include "tests/support/stepped/test_scene.h"
#include "tests/support/stepped/wandering_hand.h"

namespace hapticd {
namespace {

using test::kTick;
using test::TestMesh;
using test::TestScene;
using test::WanderingHand;

/** Solid angle of a closed mesh seen from x, over 4 pi: 1 inside, 0 outside (van Oosterom and Strackee 1983). */
double winding(const MeshView& mesh, const Vec3& x) {
  double sum = 0;
  for (std::uint32_t t = 0; t < mesh.triangle_count; ++t) {
    const Vec3 a = mesh.vertex(t, 0) - x, b = mesh.vertex(t, 1) - x, c = mesh.vertex(t, 2) - x;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    sum += 2 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return sum / (4 * M_PI);
}

/** How far x is inside the solid; at most about 0 outside. */
double depthIn(const SceneObject& o, const Vec3& x_W) {
  const Vec3 x = o.X_WO.inverse() * x_W;
  const Vec3& s = o.shape.size;
  switch (o.shape.kind) {
    case ShapeKind::kPlane:
      return -x.z();
    case ShapeKind::kSphere:
      return s.x() - x.norm();
    case ShapeKind::kBox:
      return (s - x.cwiseAbs()).minCoeff();
    case ShapeKind::kCapsule:
      return s.x() - (x - Vec3(0, 0, std::clamp(x.z(), -s.y(), s.y()))).norm();
    case ShapeKind::kCylinder:
      return std::min(s.x() - x.head<2>().norm(), s.y() - std::abs(x.z()));
    case ShapeKind::kMesh: {
      // A little out of every surface that is near, so that the winding number is decided.
      if (winding(*o.shape.mesh, x) < 0.9) return 0;
      for (int i = 0; i < 20; ++i) {
        const Vec3 u = Vec3(std::sin(1.0 + i), std::sin(2.0 + 3 * i), std::cos(5.0 * i)).normalized();
        if (winding(*o.shape.mesh, x + 1e-8 * u) < 0.5) return 0;
      }
      return 1;
    }
    default:
      return 0;
  }
}

/** A closed bumpy ball: not convex. */
TestMesh bumpyBall(double radius, std::uint32_t stacks, Random& random) {
  TestMesh mesh = test::sphereMesh(radius, stacks);
  mesh.scale([&] { return random.in(0.7, 1.1); });
  return mesh;
}

hd_material randomMaterial(Random& random) {
  const double mu = random.below(2) ? random.in(0, 1.2) : 0;
  return {random.in(100, 3000), 0, mu, mu * random.in(0.3, 1)};
}

struct MeshWorld {
  TestScene t;
  std::vector<TestMesh> meshes;
  std::vector<std::uint32_t> ids;
};

/** Solids anywhere, overlapping as they like; or each alone in its own cell. */
void fill(MeshWorld& w, Random& random, bool apart) {
  w.meshes.reserve(8);
  int cell = 0;
  for (int i = 0; i < 6; ++i, ++cell) {
    const Vec3 center = apart ? Vec3(0.1 * (cell % 3 - 1), 0.1 * (cell / 3) - 0.05, 0) : Vec3(random.vector(0.05));
    const Pose X{center, random.turn()};
    const hd_material material = randomMaterial(random);
    const double a = random.in(0.005, 0.03), b = random.in(0.005, 0.03), c = random.in(0.0001, 0.02);
    switch (random.below(7)) {
      case 0:
        w.ids.push_back(w.t.add(ShapeKind::kSphere, Vec3(a, 0, 0), X, material));
        break;
      case 1:
        w.ids.push_back(w.t.add(ShapeKind::kBox, Vec3(a, b, c), X, material));
        break;
      case 2:
        w.ids.push_back(w.t.add(ShapeKind::kCapsule, Vec3(c, b, 0), X, material));
        break;
      case 3:
        w.ids.push_back(w.t.add(ShapeKind::kCylinder, Vec3(a, c, 0), X, material));
        break;
      case 4:
        w.meshes.push_back(test::boxMesh(Vec3(a, b, c)));
        w.ids.push_back(w.t.addMesh(w.meshes.back().view(), X, material));
        break;
      case 5:
        w.meshes.push_back(bumpyBall(a, 6, random));
        w.ids.push_back(w.t.addMesh(w.meshes.back().view(), X, material));
        break;
      default:
        w.meshes.push_back(test::sphereMesh(b, 9));
        w.ids.push_back(w.t.addMesh(w.meshes.back().view(), X, material));
    }
  }
  if (!apart) w.ids.push_back(w.t.add(ShapeKind::kPlane, Vec3::Zero(), {Vec3(0, 0, -0.05), Quat::Identity()}));
}

/** The ball about the proxy and the object have no more in common than rounding. */
void expectBallOutside(const MeshWorld& w, const Vec3& proxy, double radius, int tick) {
  for (std::size_t k = 0; k < w.ids.size(); ++k) {
    const SceneObject& o = *w.t.scene->find(w.ids[k]);
    const Vec3 x = o.X_WO.inverse() * proxy;
    const double distance =
        o.shape.kind == ShapeKind::kMesh ? test::distanceTo(*o.shape.mesh, x) : test::distanceTo(o.shape, x);
    ASSERT_GT(distance, radius * (1 - 1e-6) - 1e-9) << "tick " << tick << " object " << k;
  }
}

/** The first tick starts outside of everything. */
void expectOutside(const MeshWorld& w, const Vec3& proxy, int tick) {
  for (std::size_t k = 0; k < w.ids.size(); ++k) {
    ASSERT_LT(depthIn(*w.t.scene->find(w.ids[k]), proxy), 1e-9) << "tick " << tick << " object " << k;
  }
}

void neverEntersSolidsAtRest(std::uint32_t seed, int& touched) {
  Random random(seed);
  MeshWorld w;
  fill(w, random, false);
  WanderingHand hand(random, 0.07);
  Vec3 hip = Vec3(0, 0, 0.5);
  w.t.tick(hip);
  std::uint32_t most = 0;
  int contacts = 0;
  for (int i = 0; i < 1500; ++i) {
    hip = hand.next();
    const SurfaceContact& c = w.t.tick(hip);
    ASSERT_NO_FATAL_FAILURE(expectOutside(w, c.proxy, i));
    ASSERT_TRUE(test::pressesAsItCan(*w.t.scene, c, hip)) << i;
    ASSERT_GE(c.force.dot(c.normal), 0);
    if (!c.object) {
      ASSERT_EQ(c.proxy, hip) << i;
    }
    most = std::max(most, c.work);
    contacts += c.object != 0;
  }
  EXPECT_LT(most, 20000u);
  touched += contacts > 2;
}

/** Without friction the normal leads from the hand to the proxy, in every corner, however the tick ended. */
void theNormalLeadsToTheProxy(std::uint32_t seed, bool ball, int& contacts) {
  Random random(seed);
  MeshWorld w;
  fill(w, random, false);
  for (const auto id : w.ids) w.t.material(id, {1000, 0, 0, 0});
  if (ball) w.t.proxy.setRadius(std::pow(10.0, random.in(-4, -2)));
  WanderingHand hand(random, 0.07);
  w.t.tick(Vec3(0, 0, 0.5));
  for (int i = 0; i < 400; ++i) {
    const Vec3 hip = hand.next();
    const SurfaceContact& c = w.t.tick(hip);
    const double distance = (c.proxy - hip).norm();
    contacts += c.object != 0;
    if (c.object != 0) {
      ASSERT_GE(c.depth, distance - 1e-4 * distance) << "tick " << i;
    }
  }
}

void aBallNeverEntersSolids(std::uint32_t seed) {
  Random random(seed);
  MeshWorld w;
  fill(w, random, false);
  const double radius = std::pow(10.0, random.in(-4, -2));
  w.t.proxy.setRadius(radius);
  WanderingHand hand(random, 0.07);
  w.t.tick(Vec3(0, 0, 0.5));
  std::uint32_t most = 0;
  for (int i = 0; i < 400; ++i) {
    const Vec3 hip = hand.next();
    const SurfaceContact& c = w.t.tick(hip);
    ASSERT_NO_FATAL_FAILURE(expectOutside(w, c.proxy, i));
    ASSERT_NO_FATAL_FAILURE(expectBallOutside(w, c.proxy, radius, i));
    ASSERT_TRUE(test::pressesAsItCan(*w.t.scene, c, hip)) << i;
    most = std::max(most, c.work);
  }
  EXPECT_LE(most, ProxyRenderer::kMaxWork);
}

void neverEntersSolidsInMotion(std::uint32_t seed, bool ball, int ticks, int& touched) {
  Random random(seed);
  MeshWorld w;
  fill(w, random, true);
  const double radius = ball ? std::pow(10.0, random.in(-4, -2)) : 0;
  w.t.proxy.setRadius(radius);
  std::vector<Pose> home;
  w.t.scene->advance(kTick);
  for (const auto id : w.ids) home.push_back(w.t.scene->find(id)->X_WO);
  std::vector<Vec3> spin;
  std::vector<double> phase;
  for (std::size_t k = 0; k < w.ids.size(); ++k) {
    spin.push_back(random.vector(30));
    phase.push_back(random.in(0, 6));
  }
  std::vector<Vec3> centers;
  for (const Pose& X : home) centers.push_back(X.p);
  WanderingHand hand(random, 0.02, centers);
  Vec3 hip = Vec3(0, 0, 0.5);
  w.t.tick(hip);
  int contacts = 0;
  for (int i = 1; i < ticks; ++i) {
    for (std::size_t k = 0; k < w.ids.size(); ++k) {
      const Pose& at = home[k];  // Each within its own cell: they never squeeze the hand between them.
      const Vec3 sway = 0.004 * Vec3(std::sin(0.2 * i + phase[k]), std::cos(0.13 * i), std::sin(0.31 * i));
      const Pose X{at.p + sway, rotated(at.q, spin[k], kTick * i)};
      ASSERT_EQ(w.t.pose(w.ids[k], X, k % 2 ? Twist{} : Twist{Vec3::Zero(), spin[k]}), ErrorCode::kOk);
    }
    hip = hand.next();
    const SurfaceContact& c = w.t.tick(hip);
    ASSERT_NO_FATAL_FAILURE(expectOutside(w, c.proxy, i));
    if (ball) {
      ASSERT_NO_FATAL_FAILURE(expectBallOutside(w, c.proxy, radius, i));
    }
    ASSERT_TRUE(test::pressesAsItCan(*w.t.scene, c, hip)) << i;
    contacts += c.object != 0;
  }
  touched += contacts > 2;
}

void sameInputsSameBits(std::uint32_t seed) {
  const auto run = [&] {
    Random random(seed);
    MeshWorld w;
    fill(w, random, false);
    WanderingHand hand(random, 0.07);
    w.t.tick(Vec3(0, 0, 0.5));
    std::vector<double> trace;
    for (int i = 0; i < 400; ++i) {
      if (i == 100) w.t.pose(w.ids[0], {}, {random.vector(0.1), random.vector(3)});
      const SurfaceContact& c = w.t.tick(hand.next(), random.vector(0.1));
      trace.insert(trace.end(), {c.force.x(), c.force.y(), c.force.z(), c.proxy.x(), c.depth, double(c.work)});
    }
    return trace;
  };
  EXPECT_EQ(run(), run());
}

/** Exactly the same by powers of two; by others in so many of 1200 ticks. */
void scaledProxies(std::uint32_t seed, int& same) {
  const auto run = [&](double scale) {
    Random random(seed);
    TestScene t;
    static std::vector<TestMesh> meshes;
    meshes.clear();
    meshes.reserve(2);
    meshes.push_back(bumpyBall(0.03, 8, random));
    meshes[0].scale([&] { return scale; });
    const Pose X{scale * random.vector(0.02), random.turn()};
    t.addMesh(meshes[0].view(), X, {1000, 0, 0, 0});
    t.add(ShapeKind::kBox, scale * Vec3(0.05, 0.05, 0.01), {scale * Vec3(0, 0, -0.04), Quat::Identity()},
          {1000, 0, 0, 0});
    t.add(ShapeKind::kCapsule, scale * Vec3(0.01, 0.03, 0), {scale * Vec3(0.03, 0, 0), Quat::Identity()},
          {1000, 0, 0, 0});
    if (seed % 3 == 0) t.proxy.setRadius(scale * 0.0007 * (seed % 31));
    WanderingHand hand(random, 0.08);
    t.tick(scale * Vec3(0, 0, 0.5));
    std::vector<Vec3> proxies;
    for (int i = 0; i < 600; ++i) proxies.push_back(t.tick(scale * hand.next()).proxy / scale);
    return proxies;
  };
  const auto one = run(1);
  for (const double scale : {0x1p-10, 0x1p10}) {
    const auto other = run(scale);
    for (std::size_t i = 0; i < one.size(); ++i) ASSERT_EQ(one[i], other[i]) << scale << " tick " << i;
  }
  for (const double scale : {1e-3, 1e3}) {
    const auto other = run(scale);
    for (std::size_t i = 0; i < one.size(); ++i) same += (one[i] - other[i]).norm() < 1e-7;
  }
}

/** A short free way from the proxy, a hair off the surface, that leads nearer to the hip: there must be none. */
bool canComeNearer(const SceneObject& o, const SurfaceContact& contact, double radius, const Vec3& hip,
                   Random& random) {
  const double distance = (contact.proxy - hip).norm(), hair = 1e-9 * distance;
  const Vec3 from = contact.proxy + hair * contact.normal;
  const Vec3 start = o.X_WO.inverse() * from;
  if (winding(*o.shape.mesh, start) > 0.5 || test::distanceTo(*o.shape.mesh, start) < radius)
    return false;  // Overhung.
  for (int i = 0; i < 200; ++i) {
    const Vec3 to = from + random.in(0, 1e-5) * distance * random.vector(1);
    if (!((to - hip).norm() < distance - 10 * hair)) continue;
    Sweep sweep;
    sweep.a = start;
    sweep.d = o.X_WO.inverse() * to - start;
    sweep.radius = radius;
    sweep.limit = ProxyRenderer::kMaxWork;
    SweepHit hit;
    if (sweepShape(o.shape, sweep, hit) == SweepResult::kNone) return true;
  }
  return false;
}

/** What slips lags by the dynamic cone of the contact that is told, in grooves too, however the tick ended. */
void whatSlipsIsInItsCone(std::uint32_t seed, int& slips) {
  Random random(seed);
  MeshWorld w;
  fill(w, random, false);
  const double mu = random.in(0.05, 1), dynamic = random.in(0.3, 1) * mu;
  for (const auto id : w.ids) w.t.material(id, {1000, 0, mu, dynamic});
  w.t.proxy.setRadius(std::pow(10.0, random.in(-3, -2)));
  WanderingHand hand(random, 0.07);
  w.t.tick(Vec3(0, 0, 0.5));
  for (int i = 0; i < 400; ++i) {
    const Vec3 hip = hand.next();
    const SurfaceContact& c = w.t.tick(hip);
    if (!c.slip || c.depth < 1e-4) continue;
    const Vec3 spring = c.proxy - hip;
    const double press = spring.dot(c.normal);
    ASSERT_LE((spring - press * c.normal).norm(), dynamic * press * (1 + 2e-3) + 1e-9) << "tick " << i;
    ++slips;
  }
}

/**
 * Where nothing moves that it touches the proxy could stay: whatever it does instead brings it no farther from the
 * hand. A ground a metre below may move.
 */
void theSpringGainsNothing(std::uint32_t seed, bool ground_moves, int& contacts) {
  Random random(seed);
  MeshWorld w;
  fill(w, random, false);
  w.t.proxy.setRadius(seed % 2 == 0 ? 0 : std::pow(10.0, random.in(-4, -2)));
  WanderingHand hand(random, 0.07);
  w.t.tick(Vec3(0, 0, 0.5));
  const Vec3 below(0, 0, -1);
  const std::uint32_t ground = ground_moves ? w.t.add(ShapeKind::kPlane, Vec3::Zero(), {below, Quat::Identity()}) : 0u;
  for (int i = 0; i < 400; ++i) {
    const Vec3 from = w.t.contact.proxy, hip = hand.next();
    if (ground_moves) w.t.pose(ground, {below + Vec3(0, 1e-4 * (i % 2), 0), Quat::Identity()});
    ASSERT_LT((w.t.tick(hip).proxy - hip).norm(), (from - hip).norm() * (1 + 1e-6) + 1e-9) << "tick " << i;
    contacts += w.t.contact.object != 0;
  }
}

/** Of 60 hands that come to rest deep in a bumpy ball: how many proxies could come nearer. Each third is a point. */
int notAsNearAsTheyCanBe(std::uint32_t seed, int& rested) {
  Random random(seed);
  TestScene t;
  TestMesh mesh = bumpyBall(0.03, 10, random);
  const std::uint32_t id = t.addMesh(mesh.view(), {random.vector(0.02), random.turn()}, {1000, 0, 0, 0});
  const double radius = seed % 3 == 0 ? 0 : random.in(0.0002, 0.005);
  t.proxy.setRadius(radius);
  t.tick(Vec3(0, 0, 0.5));
  WanderingHand hand(random, 0.04);
  int count = 0;
  for (int rest = 0; rest < 60; ++rest) {
    Vec3 hip = t.contact.proxy;
    for (int i = random.below(40); i >= 0; --i) t.tick(hip = hand.next());
    for (int i = 0; i < 30; ++i) t.tick(hip);
    if (t.contact.object == 0 || (t.contact.proxy - hip).norm() < 1e-3) continue;
    ++rested;
    count += canComeNearer(*t.scene->find(id), t.contact, radius, hip, random) ? 1 : 0;
  }
  return count;
}

/** But for the few balls that come nearer by ever less, or wait in a nook of faces, edges and vertices. */
TEST(ProxyProperty, AProxyAtRestIsAsNearAsItCanBe) {
  int rested[2] = {}, count[2] = {};  // Points, balls.
  for (const unsigned seed : seeds(60)) {
    const int kind = seed % 3 == 0 ? 0 : 1;
    count[kind] += notAsNearAsTheyCanBe(seed, rested[kind]);
  }
  EXPECT_GT(rested[0], drawn(250));
  EXPECT_GT(rested[1], drawn(600));
  EXPECT_LE(count[0], rested[0] / 1000);
  EXPECT_LT(count[1], rested[1] / 200);
}

/** Seeds of soaks: points at a vertex, and balls held by planes drawn out beyond their triangles. */
TEST(ProxyProperty, ProxiesThatOnceWaitedForNothingComeNearer) {
  int rested = 0;
  for (const unsigned seed : {53058u, 60060u, 82u, 53042u, 53104u, 53135u, 70294u})
    EXPECT_EQ(notAsNearAsTheyCanBe(seed, rested), 0) << seed;
}

TEST(ProxyProperty, WhatSlipsIsInItsCone) {
  int slips = 0;
  forSeeds(200, [&](unsigned seed) { whatSlipsIsInItsCone(seed, slips); });
  EXPECT_GT(slips, drawn(10000));
  // Seeds of soaks: in a groove the contact was told of one wall alone; ticks that met too much, or had swept enough.
  for (const unsigned seed : {69u, 1100u, 5002u, 6081u, 7088u, 8111u}) whatSlipsIsInItsCone(seed, slips);
  for (const unsigned seed : {108276u, 108313u, 696034u, 696117u, 865004u, 865173u, 891075u, 891176u, 891130u})
    whatSlipsIsInItsCone(seed, slips);
}
TEST(ProxyProperty, AtRestTheSpringGainsNothing) {
  int contacts = 0;
  forSeeds(200, [&](unsigned seed) { theSpringGainsNothing(seed, seed % 4 < 2, contacts); });
  EXPECT_GT(contacts, drawn(10000));
  // Seeds of a soak: what interrupted a way over its highest point left the proxy up there.
  for (const unsigned seed : {1025u, 4035u, 7046u, 18053u, 19012u, 28100u})
    theSpringGainsNothing(seed, false, contacts);
  // While something else moved, another solid stood in the way back: 5 cm away at once.
  theSpringGainsNothing(986, true, contacts);
}
TEST(ProxyProperty, NeverEntersSolidsAtRest) {
  int touched = 0;
  forSeeds(60, [&](unsigned seed) { neverEntersSolidsAtRest(seed, touched); });
  EXPECT_GT(touched, drawn(45));
}
TEST(ProxyProperty, TheNormalLeadsFromTheHandToTheProxy) {
  int contacts = 0;
  forSeeds(300, [&](unsigned seed) { theNormalLeadsToTheProxy(seed, seed % 2 == 0, contacts); });
  EXPECT_GT(contacts, drawn(10000));
  // Seeds of a soak: ticks whose sweeps were used up, or that met too much, told of the surface looked at last.
  for (const unsigned seed : {307166u, 677018u, 677065u, 677172u, 677177u, 686085u, 686239u, 600064u, 604987u})
    theNormalLeadsToTheProxy(seed, false, contacts);
  for (const unsigned seed : {600391u, 600548u, 600862u, 603758u, 604517u})
    theNormalLeadsToTheProxy(seed, true, contacts);
}
TEST(ProxyProperty, ABallNeverEntersSolids) { forSeeds(30, aBallNeverEntersSolids); }
TEST(ProxyProperty, NeverEntersSolidsInMotion) {
  int touched = 0;
  forSeeds(40, [&](unsigned seed) { neverEntersSolidsInMotion(seed, false, 1500, touched); });
  EXPECT_GT(touched, drawn(30));
  neverEntersSolidsInMotion(5047024, false, 300, touched);  // Once left without its hair above a way that grazed.
}
TEST(ProxyProperty, ABallNeverEntersSolidsInMotion) {
  int touched = 0;
  forSeeds(30, [&](unsigned seed) { neverEntersSolidsInMotion(seed, true, 400, touched); });
  EXPECT_GT(touched, drawn(20));
}
TEST(ProxyProperty, SameInputsSameBits) { forSeeds(10, sameInputsSameBits); }
/** Where two ways are equally good, such as out of an unstable balance, rounding may choose. */
TEST(ProxyProperty, ScaledScenesGiveScaledProxies) {
  constexpr int kSeeds = 30;
  int same = 0;
  forSeeds(kSeeds, [&](std::uint32_t seed) { scaledProxies(seed, same); });
  EXPECT_GT(same, drawn(1200 * kSeeds * 99 / 100));
  scaledProxies(7396020, same);  // Once led round by a point 10^12 m away, where two planes nearly coincide.
}

}  // namespace
}  // namespace hapticd
