/** @file
 * Meshes as bad as they come, and hands that do not care: rough rooms with thin walls, needles, vertices that move.
 */
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <vector>

#include "tests/support/for_seeds.h"
#include "tests/support/shape/brute_distance.h"
#include "tests/support/shape/test_mesh.h"
#include "tests/support/stepped/test_scene.h"

namespace hapticd {
namespace {

using test::kTick;
using test::TestMesh;
using test::TestScene;
using test::windingNumber;

/** A hand that goes for one aim after the other, now slowly, now at once. */
class AimingHand {
 public:
  AimingHand(Random& random, double size) : random_(random), size_(size) {}
  const Vec3& next() {
    if (random_.once(20)) aim_ = random_.vector(size_);
    if (random_.once(30)) speed_ = std::pow(10, random_.in(-3, 0));
    x_ += speed_ * (aim_ - x_);
    return x_;
  }

 private:
  Random& random_;
  double size_, speed_ = 0.01;
  Vec3 x_ = Vec3::Zero(), aim_ = Vec3::Zero();
};

/** Whether x is inside, by more than rounding. */
bool isInside(const MeshView& mesh, const Vec3& x, double size) {
  if (windingNumber(mesh, x) < 0.5) return false;
  return test::distanceTo(mesh, x) > 3e-7 * size;
}

hd_material anyMaterial(Random& random) {
  const double mu = random.once(2) ? random.in(0, 1.5) : 0;
  return {random.in(100, 3000), 0, mu, mu * random.in(0.3, 1)};
}

double anyRadius(Random& random, double least, double most) {
  return random.once(2) ? 0 : std::exp(random.in(std::log(least), std::log(most)));
}

/**
 * Seen from the middle every vertex goes in or out by its own: the mesh stays one that does not pass itself, and away
 * from the middle there is always room for a ball.
 */
void aMovingSurfaceSwallowsNobody(unsigned seed, std::uint32_t sided, int& touched) {
  Random random(seed);
  const double size = 0.03;
  TestMesh mesh = test::sphereMesh(size, 3 + random.below(6u));
  const std::vector<std::array<float, 3>> round = mesh.vertices;
  TestScene t;
  const hd_material material = anyMaterial(random);
  const std::uint32_t id =
      t.addMesh(mesh.deformableView(), {random.vector(0.05), random.turn()}, material, HD_OBJECT_ENABLED | sided);
  const double radius = anyRadius(random, 1e-4, 5e-3);
  t.proxy.setRadius(radius);
  const double most = std::pow(10, random.in(-3, -0.5)), often = std::pow(10, random.in(0, 1.5));
  AimingHand hand(random, 1.2 * size);
  t.tick(Vec3(0, 0, 0.5));
  const Pose X = t.scene->find(id)->X_WO;
  std::vector<double> by(round.size(), 1.0);
  int contacts = 0;
  for (int i = 0; i < 300; ++i) {
    std::vector<hd_vertex_move> moves;
    for (std::uint32_t v = 0; v < round.size(); ++v) {
      if (!random.once(often)) continue;
      by[v] = std::clamp(by[v] + random.in(-most, most), 0.5, 1.5);
      const auto f = static_cast<float>(by[v]);
      moves.push_back({v, {f * round[v][0], f * round[v][1], f * round[v][2]}});
    }
    ASSERT_EQ(t.moveVertices(id, moves), ErrorCode::kOk);
    const SurfaceContact& c = t.tick(X * hand.next());
    contacts += c.object != 0;
    const MeshView& now = *t.scene->find(id)->shape.mesh;
    const Vec3 x = X.inverse() * c.proxy;
    ASSERT_FALSE(isInside(now, x, size)) << "tick " << i;
    if (radius > 0) {
      ASSERT_GT(test::distanceTo(now, x), radius * (1 - 1e-6) - 1e-9 * size) << "tick " << i;
    }
  }
  touched += contacts > 2;
}

/**
 * The same of vertices that go round an axis, those of one height together: so what sticks to them is taken along, and
 * each triangle is sheared and turned.
 */
void aTwistedSurfaceSwallowsNobody(unsigned seed, std::uint32_t sided, int& taken) {
  Random random(seed);
  const double size = 0.03;
  TestMesh mesh = test::sphereMesh(size, 3 + random.below(6u));
  const std::vector<std::array<float, 3>> round = mesh.vertices;
  TestScene t;
  const double mu = random.in(0.2, 2);
  const std::uint32_t id = t.addMesh(mesh.deformableView(), {random.vector(0.05), random.turn()},
                                     {1000, 0, mu, mu * random.in(0.3, 1)}, HD_OBJECT_ENABLED | sided);
  const double radius = anyRadius(random, 1e-4, 5e-3);
  t.proxy.setRadius(radius);
  const double in_out = random.once(2) ? 0 : std::pow(10, random.in(-4, -1.5)), shear = std::pow(10, random.in(-4, -1)),
               turn = random.in(-1, 1) * std::pow(10, random.in(-3, -1));
  AimingHand hand(random, 1.2 * size);
  t.tick(Vec3(0, 0, 0.5));
  const Pose X = t.scene->find(id)->X_WO;
  std::vector<double> by(round.size(), 1.0);
  std::map<float, double> twist;  // By height.
  double all = 0, most = 0;
  for (int i = 0; i < 300; ++i) {
    all += turn;
    for (auto& [height, angle] : twist) angle = std::clamp(angle + random.in(-shear, shear), -0.25, 0.25);
    std::vector<hd_vertex_move> moves;
    for (std::uint32_t v = 0; v < round.size(); ++v) {
      by[v] = std::clamp(by[v] + random.in(-in_out, in_out), 0.7, 1.3);
      const Vec3 at = by[v] * (Eigen::AngleAxisd(all + twist[round[v][2]], Vec3::UnitZ()) *
                               Vec3(round[v][0], round[v][1], round[v][2]));
      moves.push_back({v, {static_cast<float>(at.x()), static_cast<float>(at.y()), static_cast<float>(at.z())}});
    }
    ASSERT_EQ(t.moveVertices(id, moves), ErrorCode::kOk);
    const Vec3 hip = X * hand.next();
    const SurfaceContact& c = t.tick(hip);
    most = std::max(most, std::abs(c.normal.cross(c.proxy - hip).norm()));
    const MeshView& now = *t.scene->find(id)->shape.mesh;
    const Vec3 x = X.inverse() * c.proxy;
    ASSERT_FALSE(isInside(now, x, size)) << "tick " << i;
    if (radius > 0) {
      ASSERT_GT(test::distanceTo(now, x), radius * (1 - 1e-6) - 1e-9 * size) << "tick " << i;
    }
  }
  taken += most > 1e-3;
}

/** A hollow ball, rough inside and outside, whose wall is thinner than its triangles are large; it may spin. */
void aRoughRoomIsNeverLeft(unsigned seed) {
  Random random(seed);
  const double size = 0.02;
  const std::uint32_t stacks = 4 + random.below(8u);
  TestMesh mesh = test::sphereMesh(size, stacks);
  const double rough = random.in(0, 0.3), thick = std::pow(10, random.in(-3, -1));
  const auto count = static_cast<std::uint32_t>(mesh.vertices.size()),
             faces = static_cast<std::uint32_t>(mesh.triangles.size());
  for (std::uint32_t v = 0; v < count; ++v) {
    const double inner = 1 - random.in(0, rough), outer = inner * (1 + thick);
    const std::array<float, 3> at = mesh.vertices[v];
    mesh.vertices.push_back(at);
    for (int i = 0; i < 3; ++i) {
      mesh.vertices[v][i] = static_cast<float>(outer * at[i]);
      mesh.vertices[count + v][i] = static_cast<float>(inner * at[i]);
    }
  }
  for (std::uint32_t f = 0; f < faces; ++f) {
    const auto t = mesh.triangles[f];
    mesh.addTriangle(count + t[0], count + t[2], count + t[1]);
  }
  TestMesh inside = test::sphereMesh(size, stacks);
  for (std::uint32_t v = 0; v < count; ++v) inside.vertices[v] = mesh.vertices[count + v];
  const MeshView room = *inside.view();
  const double radius = anyRadius(random, 1e-5, 3e-3);
  TestScene t(radius);
  const Vec3 spin = random.once(2) ? random.vector(20) : Vec3::Zero();
  const Pose home{random.vector(0.05), random.turn()};
  const std::uint32_t id = t.addMesh(mesh.view(), home, anyMaterial(random));
  t.tick(home.p);
  AimingHand hand(random, 1.3 * size);
  for (int i = 1; i <= 500; ++i) {
    const Pose X{home.p, spin.isZero() ? home.q : rotated(home.q, spin, kTick * i)};
    if (!spin.isZero()) {
      ASSERT_EQ(t.pose(id, X, Twist{Vec3::Zero(), spin}), ErrorCode::kOk);
    }
    t.tick(X * hand.next());
    const Vec3 x = t.scene->find(id)->X_WO.inverse() * t.contact.proxy;
    ASSERT_TRUE(windingNumber(room, x) > 0.5 || test::distanceTo(room, x) < 1e-9 * size) << "tick " << i;
  }
}

/** A ball squeezed by `squeeze`, with needles, doubled vertices, faces without area. */
TestMesh needles(Random& random, double size, Vec3& squeeze) {
  TestMesh mesh = test::sphereMesh(size, 3 + random.below(10u));
  const double deep = std::pow(10, random.in(-2.5, 0)), wide = std::pow(10, random.in(-2.5, 0));
  squeeze = Vec3(wide, deep, 1);
  for (auto& v : mesh.vertices) {
    const double f = random.once(3) ? 1 : random.in(0.8, 1.1);
    for (int i = 0; i < 3; ++i) v[i] = static_cast<float>(f * squeeze[i] * v[i]);
  }
  // Each face in so many gets a vertex on an edge: one of the two has no area, or nearly none.
  const auto faces = static_cast<std::uint32_t>(mesh.triangles.size());
  for (std::uint32_t f = 0; f < faces; ++f) {
    if (!random.once(4)) continue;
    const auto t = mesh.triangles[f];
    const auto at = [&](int k) { return Vec3(mesh.vertices[t[k]][0], mesh.vertices[t[k]][1], mesh.vertices[t[k]][2]); };
    const double s = random.once(3) ? 0 : random.in(0, 1);
    const std::uint32_t mid = mesh.addVertex((1 - s) * at(0) + s * at(1));
    mesh.triangles[f] = {t[0], mid, t[2]};
    mesh.addTriangle(mid, t[1], t[2]);
    mesh.addTriangle(t[0], t[1], mid);
  }
  return mesh;
}

void needlesHoldWhatTheyHold(unsigned seed, int& touched) {
  Random random(seed);
  const double size = 0.03;
  Vec3 squeeze;
  TestMesh mesh = needles(random, size, squeeze);
  const double radius = anyRadius(random, 1e-5, 3e-3);
  TestScene t(radius);
  MeshView* const view = mesh.view();
  const hd_material material = anyMaterial(random);
  const std::uint32_t id = t.addMesh(view, {random.vector(0.05), random.turn()}, material);
  t.tick(Vec3(0, 0, 0.5));
  const Pose X = t.scene->find(id)->X_WO;
  AimingHand hand(random, size);
  int contacts = 0;
  for (int i = 0; i < 300; ++i) {
    const Vec3 x = hand.next();
    const SurfaceContact& c = t.tick(X * Vec3(x.cwiseProduct(squeeze.cwiseMax(0.05))));
    const Vec3 y = X.inverse() * c.proxy;
    contacts += c.object != 0;
    ASSERT_FALSE(isInside(*view, y, size)) << "tick " << i;
    if (radius > 0) {
      ASSERT_GT(test::distanceTo(*view, y), radius * (1 - 1e-6) - 1e-9 * size) << "tick " << i;
    }
  }
  touched += contacts > 2;
}

/** On rough ground at rest the proxy comes no farther from where the hand now is: the spring gives what it was given.
 */
void roughGroundGivesNothing(unsigned seed, int& touched) {
  Random random(seed);
  const double rough = std::pow(10, random.in(-4, -2));
  const std::uint32_t fine = 6 + random.below(25u);
  TestMesh mesh = test::heightMesh(0.05, fine, [&](double, double) { return random.in(-rough, rough); });
  TestScene t(anyRadius(random, 1e-5, 3e-3));
  Pose X;  // So that the hand comes from behind too, round the border.
  X.p = random.vector(0.05);
  X.q = random.turn();
  t.addMesh(mesh.view(), X, anyMaterial(random));
  t.tick(Vec3(0, 0, 0.5));
  AimingHand hand(random, 0.04);
  int contacts = 0;
  for (int i = 0; i < 400; ++i) {
    const Vec3 before = t.contact.proxy, hip = X * Vec3(hand.next().cwiseProduct(Vec3(1, 1, 0.3)));
    const SurfaceContact& c = t.tick(hip);
    contacts += c.object != 0;
    ASSERT_LT((c.proxy - hip).norm(), 1.01 * (before - hip).norm() + 1e-9) << "tick " << i;
  }
  touched += contacts > 2;
}

/** The same of a point that rests where planes of needles meet, that nearly coincide. */
void needlesGiveNothing(unsigned seed) {
  Random random(seed);
  Vec3 squeeze;
  TestMesh mesh = needles(random, 0.03, squeeze);
  TestScene t;
  t.addMesh(mesh.view());
  t.tick(Vec3(0, 0, 0.5));
  AimingHand hand(random, 0.03);
  for (int i = 0; i < 400; ++i) {
    const Vec3 before = t.contact.proxy, hip = hand.next();
    const SurfaceContact& c = t.tick(hip);
    ASSERT_LT((c.proxy - hip).norm(), 1.01 * (before - hip).norm() + 1e-9) << "tick " << i;
  }
}

/** The same of balls and hands within solids with holes, which go around edges and borders all the time. */
void solidsWithHolesGiveNothing(unsigned seed, int& contacts) {
  Random random(seed);
  std::mt19937 engine(seed);
  TestMesh mesh = test::crumpled(engine, 3 + random.below(6u));
  const bool holes = random.once(2);
  std::erase_if(mesh.triangles, [&](const auto&) { return holes && random.once(6); });
  TestScene t(std::exp(random.in(std::log(1e-2), std::log(5e-1))));
  const double mu = random.once(3) ? random.in(0, 1) : 0;
  t.addMesh(mesh.view(), {}, {1000, 0, mu, 0.7 * mu});
  t.tick(Vec3(0, 0, 5));
  AimingHand hand(random, 1);
  for (int i = 0; i < 400; ++i) {
    const Vec3 before = t.contact.proxy, hip = hand.next();
    const SurfaceContact& c = t.tick(hip);
    contacts += c.object != 0;
    ASSERT_LE((c.proxy - hip).norm(), (1 + 1e-6) * (before - hip).norm() + 1e-9) << "tick " << i;
  }
}

/** Seeds of a soak. */
TEST(MeshProperty, NeedlesGiveNothing) { forEachSeed({59u, 1223u, 1419u, 1591u, 1963u}, needlesGiveNothing); }
/** First seeds of a soak in which what came after going around led away, or what friction brought along. */
TEST(MeshProperty, SolidsWithHolesGiveNothing) {
  int contacts = 0;
  forSeeds({53768u, 63971u, 242027u, 274822u, 117125u, 153309u, 182382u, 193202u, 230628u}, 150,
           [&](unsigned seed) { solidsWithHolesGiveNothing(seed, contacts); });
  EXPECT_GT(contacts, drawn(20000));
}
TEST(MeshProperty, RoughGroundGivesNothing) {
  int touched = 0;
  forSeeds(200, [&](unsigned seed) { roughGroundGivesNothing(seed, touched); });
  EXPECT_GT(touched, drawn(180));
}
/** First seeds of a soak in which a ball was taken along through what stood in its way. */
TEST(MeshProperty, AMovingSurfaceSwallowsNobody) {
  int touched = 0;
  forSeeds({40722u, 40806u, 41164u}, 60, [&](unsigned seed) { aMovingSurfaceSwallowsNobody(seed, 0, touched); });
  EXPECT_GT(touched, drawn(30));
}
/** First seeds of a soak in which a point lay in a crease, pushed by one face through the other by less than a hair. */
TEST(MeshProperty, AMovingSheetLetsNobodyThrough) {
  int touched = 0;
  forSeeds({40748u, 41948u, 43455u, 50674u, 52893u, 54153u, 54960u}, 60,
           [&](unsigned seed) { aMovingSurfaceSwallowsNobody(seed, HD_OBJECT_TWO_SIDED, touched); });
  EXPECT_GT(touched, drawn(30));
}
TEST(MeshProperty, ATwistedSurfaceSwallowsNobody) {
  int taken = 0;
  forSeeds(60, [&](unsigned seed) { aTwistedSurfaceSwallowsNobody(seed, 0, taken); });
  EXPECT_GT(taken, drawn(20));
}
TEST(MeshProperty, ATwistedSheetLetsNobodyThrough) {
  int taken = 0;
  forSeeds(60, [&](unsigned seed) { aTwistedSurfaceSwallowsNobody(seed, HD_OBJECT_TWO_SIDED, taken); });
  EXPECT_GT(taken, drawn(20));
}
TEST(MeshProperty, ARoughRoomIsNeverLeft) { forSeeds(60, aRoughRoomIsNeverLeft); }
/** Seeds of soaks: points lost beside needles whose planes were tipped; balls beside edges that faced any way, and at
 * doubled vertices. */
TEST(MeshProperty, NeedlesHoldWhatTheyHold) {
  int touched = 0;
  forSeeds({10431u, 10603u, 11337u, 12242u, 10224u, 10351u, 12845u, 57215u, 71710u}, 60,
           [&](unsigned seed) { needlesHoldWhatTheyHold(seed, touched); });
  EXPECT_GT(touched, drawn(30));
}

}  // namespace
}  // namespace hapticd
