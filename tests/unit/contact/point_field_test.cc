// Surface points against a distance field: closed forms, coherence, budget, thin walls, depth.
#include "rt/contact/point_field.h"

#include <gtest/gtest.h>

#include "tests/support/random.h"
#include "tests/support/shape/test_volume.h"
#include "tests/unit/contact/voxels.h"

namespace hapticd {
namespace {

using test::queryOf;
using test::TestVolume;

constexpr std::uint32_t kRoom = 1u << 16;

Pose at(double x, double y, double z) { return {Vec3(x, y, z), Quat::Identity()}; }

VolumeOptions fine(double spacing) {
  VolumeOptions options;
  options.point_spacing_m = spacing;
  return options;
}

TEST(PointField, OfASphereInAPlateIsPiTimesRadiusTimesDepthSquared) {
  const double radius = 0.01, depth = 0.002;
  const TestVolume ball = test::sphereVolume(radius, 0.0005, 100, fine(0.0002));
  const TestVolume plate = test::boxVolume({0.02, 0.02, 0.01}, 0.0005);
  PointFieldDetector detector(kRoom);
  ContactSet contacts;
  // Wherever the world's frame is.
  const Pose X_WB{{0.3, -0.2, 0.1}, Quat(0.5, 0.5, -0.5, 0.5)};
  detector.find(queryOf(ball, plate, X_WB * at(0.003, 0.001, 0.01 + radius - depth), X_WB), contacts);
  const double expected = EIGEN_PI * radius * depth * depth;
  const Vec3 force = X_WB.q.conjugate() * contacts.integral.force;
  EXPECT_NEAR(force.z(), expected, 0.02 * expected);
  EXPECT_LT(force.head<2>().norm(), 0.01 * expected);
  EXPECT_LT(contacts.integral.torque.norm(), 0.01 * expected * radius);  // About the ball's centre: none.
  EXPECT_NEAR(contacts.touching_area, 2 * EIGEN_PI * radius * depth, 0.03 * 2 * EIGEN_PI * radius * depth);
  EXPECT_NEAR(contacts.deepest, depth, 2e-5);
  ASSERT_GT(contacts.count, 0u);
  double area = 0;
  for (const Contact& c : contacts.contacts()) {
    area += c.area;
    EXPECT_NEAR((X_WB.q.conjugate() * c.n_W).z(), 1, 1e-3);
    EXPECT_LE(c.depth, contacts.deepest + 1e-9);
    EXPECT_NEAR((c.p_WB - c.p_WA - c.depth * c.n_W).norm(), 0, 1e-9);
  }
  EXPECT_NEAR(area, contacts.touching_area, 1e-9);
}

TEST(PointField, TellsHowFarApartAtLeast) {
  const TestVolume ball = test::sphereVolume(0.01, 0.0005);
  const TestVolume plate = test::boxVolume({0.02, 0.02, 0.01}, 0.0005);
  PointFieldDetector detector(kRoom);
  ContactSet contacts;
  for (const double gap : {0.002, 0.01, 0.1}) {
    detector.reset();  // What is left of the last query's bounds holds, but is not tight.
    detector.find(queryOf(ball, plate, at(0, 0, 0.02 + gap)), contacts);
    EXPECT_EQ(contacts.count, 0u);
    EXPECT_LE(contacts.report.distance_lower_bound, gap + 1e-6);
    EXPECT_GT(contacts.report.distance_lower_bound, gap > 0.005 ? 0.5 * gap - 0.002 : 0);
  }
}

TEST(PointField, FindsWhatIsNearerThanTheMargin) {
  const TestVolume ball = test::sphereVolume(0.01, 0.0005, 60);
  const TestVolume plate = test::boxVolume({0.02, 0.02, 0.01}, 0.0005);
  PointFieldDetector detector(kRoom);
  ContactSet contacts;
  DetectorQuery query = queryOf(ball, plate, at(0, 0, 0.02 + 0.0002));
  detector.find(query, contacts);
  EXPECT_EQ(contacts.count, 0u);
  query.margin = 0.0005;
  detector.find(query, contacts);
  ASSERT_GE(contacts.count, 1u);
  EXPECT_NEAR(contacts.deepest, -0.0002, 2e-5);
  EXPECT_EQ(contacts.integral.force.norm(), 0);
  for (const Contact& c : contacts.contacts()) {
    EXPECT_LE(c.depth, 0);
    EXPECT_NEAR(c.n_W.z(), 1, 1e-3);
  }
}

/** Everything but age and report. */
void expectSame(const ContactSet& a, const ContactSet& b) {
  ASSERT_EQ(a.count, b.count);
  EXPECT_EQ(a.integral.force, b.integral.force);
  EXPECT_EQ(a.integral.torque, b.integral.torque);
  EXPECT_EQ(a.touching_area, b.touching_area);
  EXPECT_EQ(a.deepest, b.deepest);
  EXPECT_EQ(a.report.touching, b.report.touching);
  for (std::uint32_t i = 0; i < a.count; ++i) {
    EXPECT_EQ(a.contact[i].p_WA, b.contact[i].p_WA);
    EXPECT_EQ(a.contact[i].n_W, b.contact[i].n_W);
    EXPECT_EQ(a.contact[i].depth, b.contact[i].depth);
    EXPECT_EQ(a.contact[i].feature_a, b.contact[i].feature_a);
  }
}

TEST(PointField, ResultsDoNotDependOnTheLastQueryHoweverFastItMoves) {
  const TestVolume torus = test::torusVolume(0.02, 0.006, 0.001, fine(0.0005));
  const TestVolume other = test::torusVolume(0.02, 0.006, 0.001);
  PointFieldDetector with(kRoom);
  PointFieldDetector without(kRoom, {.coherent = false});
  Random random(seedOf(3));
  Pose X = at(0.06, 0, 0);
  ContactSet a, b;
  std::uint64_t reused = 0, touching = 0;
  for (int i = 0; i < 3000; ++i) {
    // From nearly still to leaps, drawn back to the other body.
    const double step = std::pow(10.0, -6 + 2.2 * (1 + random.in(-1, 1)));
    const Vec3 back = -0.1 * step * X.p.normalized();
    X = {X.p + step * random.vector(1) + back, rotated(X.q, step * 30 * random.vector(1), 1)};
    DetectorQuery query = queryOf(torus, other, X);
    with.find(query, a);
    without.find(query, b);
    expectSame(a, b);
    reused += a.report.reused;
    touching += a.count > 0 ? 1 : 0;
    if (::testing::Test::HasFailure()) FAIL() << "at step " << i;
  }
  EXPECT_GT(reused, 100'000u);
  // A random walk: how often it touches is its own affair; 48 to 1612 times at 300 seeds.
  EXPECT_GT(touching, 10u);
  EXPECT_LT(touching, 2900u);
}

TEST(PointField, KeepsItsBudgetAndSaysWhatItDropped) {
  const TestVolume torus = test::torusVolume(0.02, 0.006, 0.001, fine(0.0004));
  const TestVolume plate = test::boxVolume({0.04, 0.04, 0.01}, 0.001);
  PointFieldDetector full(kRoom, {.coherent = false}), limited(kRoom, {.coherent = false});
  Random random(seedOf(5));
  ContactSet all, some;
  int exhausted = 0;
  for (int i = 0; i < 300; ++i) {
    DetectorQuery query =
        queryOf(torus, plate, at(0.01 * random.in(-1, 1), 0.01 * random.in(-1, 1), 0.0155 + 0.0015 * random.in(-1, 1)));
    query.a.X_WO_before.p.z() += 0.004 * std::max(0.0, random.in(-1, 1));  // Some with a way to sweep.
    full.find(query, all);
    query.budget.units = 1 + static_cast<std::uint32_t>(std::pow(10.0, 1.7 + 1.7 * random.in(-1, 1)));
    limited.find(query, some);
    EXPECT_LE(some.report.work, query.budget.units);
    if (some.report.exhausted) {
      ++exhausted;
    } else {
      expectSame(some, all);
    }
    if (some.report.dropped > 0) {
      EXPECT_GT(some.report.dropped_area, 0);
    }
    EXPECT_LE(some.report.dropped_area, torus.view.header->area * 1.0001);
  }
  // 274 to 291 at a hundred seeds: some were compared with `all`.
  EXPECT_GT(exhausted, 50);
  EXPECT_LT(exhausted, 300);
  // Half of what is needed still gives the force: each point stands for two.
  DetectorQuery query = queryOf(torus, plate, at(0, 0, 0.0145));
  full.find(query, all);
  query.budget.units = all.report.work / 2;
  limited.find(query, some);
  EXPECT_TRUE(some.report.exhausted);
  EXPECT_GT(some.report.coarsest, 0);
  EXPECT_EQ(some.report.dropped, 0u);
  EXPECT_NEAR(some.integral.force.z(), all.integral.force.z(), 0.1 * all.integral.force.z());
}

/** A half of a block broken along a rough face: the other half fits onto it at z = 0. */
test::TestMesh brokenHalf(bool upper) {
  constexpr std::uint32_t kSide = 40;
  const double half = 0.01, back = upper ? 0.005 : -0.005;
  const auto face = [](double x, double y) {
    return 0.0008 * std::sin(600 * x + 0.3) * std::cos(450 * y) + 0.0002 * std::sin(2100 * x) * std::sin(1900 * y + 1);
  };
  test::TestMesh m;
  for (const bool rough : {true, false}) {
    for (std::uint32_t i = 0; i <= kSide; ++i) {
      for (std::uint32_t j = 0; j <= kSide; ++j) {
        const double x = half * (2.0 * i / kSide - 1), y = half * (2.0 * j / kSide - 1);
        m.addVertex({x, y, rough ? face(x, y) : back});
      }
    }
  }
  const auto at = [&](bool rough, std::uint32_t i, std::uint32_t j) {
    return (rough ? 0 : (kSide + 1) * (kSide + 1)) + i * (kSide + 1) + j;
  };
  // Seen from above, then turned over for the upper half.
  const auto quad = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    upper ? m.addQuad(d, c, b, a) : m.addQuad(a, b, c, d);
  };
  for (std::uint32_t i = 0; i < kSide; ++i) {
    for (std::uint32_t j = 0; j < kSide; ++j) {
      quad(at(true, i, j), at(true, i + 1, j), at(true, i + 1, j + 1), at(true, i, j + 1));
      quad(at(false, i, j), at(false, i, j + 1), at(false, i + 1, j + 1), at(false, i + 1, j));
    }
    quad(at(false, i, 0), at(false, i + 1, 0), at(true, i + 1, 0), at(true, i, 0));
    quad(at(false, i + 1, kSide), at(false, i, kSide), at(true, i, kSide), at(true, i + 1, kSide));
    quad(at(false, 0, i + 1), at(false, 0, i), at(true, 0, i), at(true, 0, i + 1));
    quad(at(false, kSide, i), at(false, kSide, i + 1), at(true, kSide, i + 1), at(true, kSide, i));
  }
  m.flags = HD_MESH_CLOSED;
  return m;
}

TEST(PointField, AFifthOfTheWorkTellsOfAMatedFaceWhatAllOfItTells) {
  const TestVolume tool = test::volumeOfMesh(brokenHalf(true), 0.0005, fine(0.00015));
  const TestVolume base = test::volumeOfMesh(brokenHalf(false), 0.0005);
  PointFieldDetector full(kRoom), limited(kRoom);
  Random random(seedOf(11));
  ContactSet all, some;
  for (int i = 0; i < 200; ++i) {
    const Pose X{{1e-4 * random.in(-1, 1), 1e-4 * random.in(-1, 1), -1e-4 + 5e-5 * random.in(-1, 1)},
                 rotated(Quat::Identity(), 0.004 * random.vector(1), 1)};
    DetectorQuery query = queryOf(tool, base, X);
    full.find(query, all);
    ASSERT_GT(all.report.touching, 5000u);
    EXPECT_FALSE(all.report.exhausted);
    query.budget.units = all.report.work / 5;
    limited.find(query, some);
    EXPECT_LE(some.report.work, query.budget.units);
    EXPECT_GT(some.report.work, query.budget.units * 17 / 20);  // Nor is it wasted.
    EXPECT_TRUE(some.report.exhausted);
    EXPECT_GT(some.report.coarsest, 0);
    EXPECT_LE(some.report.coarsest, 0.002);
    // What is left out is told by area: none of it, or as much as is missing.
    EXPECT_EQ(some.report.dropped > 0, some.report.dropped_area > 0);
    EXPECT_NEAR(some.touching_area, all.touching_area, some.report.dropped_area + 0.05 * all.touching_area) << i;
    if (some.report.dropped > 0) continue;
    EXPECT_LE((some.integral.force - all.integral.force).norm(), 0.05 * all.integral.force.norm()) << i;
    EXPECT_LE((some.integral.torque - all.integral.torque).norm(), 0.05 * 0.01 * all.integral.force.norm()) << i;
    EXPECT_NEAR(some.deepest, all.deepest, 0.3 * all.deepest);
  }
}

TEST(PointField, WithFewerUnitsThanPatchesSomeStandForTheirNeighbours) {
  VolumeOptions options = fine(0.0001);
  options.patch_points = 24;
  const TestVolume tool = test::volumeOfMesh(brokenHalf(true), 0.00025, options);
  const TestVolume base = test::volumeOfMesh(brokenHalf(false), 0.0005);
  PointFieldDetector full(kRoom), limited(kRoom);
  Random random(seedOf(13));
  ContactSet all, some;
  for (int i = 0; i < 100; ++i) {
    const Pose X{{1e-4 * random.in(-1, 1), 1e-4 * random.in(-1, 1), -1e-4 + 5e-5 * random.in(-1, 1)},
                 rotated(Quat::Identity(), 0.004 * random.vector(1), 1)};
    DetectorQuery query = queryOf(tool, base, X);
    full.find(query, all);
    query.budget.units = all.report.work / 8;
    ASSERT_LT(query.budget.units * 24, all.report.touching);
    limited.find(query, some);
    EXPECT_LE(some.report.work, query.budget.units);
    EXPECT_GT(some.report.work, query.budget.units * 17 / 20);
    EXPECT_TRUE(some.report.exhausted);
    EXPECT_EQ(some.report.dropped, 0u);
    EXPECT_GT(some.report.coarsest, 0.0005);
    EXPECT_LE((some.integral.force - all.integral.force).norm(), 0.1 * all.integral.force.norm()) << i;
  }
}

/** Goes on by a microsecond each time it is read. */
class ReadClock final : public Clock {
 public:
  std::int64_t now() HD_RT override { return t_ns_ += 1000; }
  void sleepUntil(std::int64_t t_ns) HD_RT override { t_ns_ = t_ns; }

 private:
  std::int64_t t_ns_ = 0;
};

TEST(PointField, StopsAtItsDeadlineAndBeginsWithTheDeepest) {
  const TestVolume torus = test::torusVolume(0.02, 0.006, 0.001, fine(0.00015));
  const TestVolume plate = test::boxVolume({0.04, 0.04, 0.01}, 0.001);
  PointFieldDetector detector(kRoom, {.coherent = false});
  ContactSet all, some;
  DetectorQuery query = queryOf(torus, plate, {{0, 0, 0.0145}, Quat(Eigen::AngleAxisd(0.02, Vec3::UnitX()))});
  detector.find(query, all);
  ASSERT_GT(all.report.work, 1500u);
  ReadClock clock;
  query.budget.clock = &clock;
  query.budget.deadline_ns = 3500;  // Passed at the fourth reading.
  detector.find(query, some);
  EXPECT_TRUE(some.report.exhausted);
  EXPECT_GT(some.report.dropped, 0u);
  EXPECT_LT(some.report.work, all.report.work);
  EXPECT_GT(some.count, 0u);
  EXPECT_NEAR(some.deepest, all.deepest, 2e-5);
}

TEST(PointField, FirstOnlyTellsWhetherTheyTouch) {
  const TestVolume torus = test::torusVolume(0.02, 0.006, 0.001);
  PointFieldDetector every(kRoom), first(kRoom);
  Random random(seedOf(9));
  ContactSet a, b;
  std::uint64_t work = 0, most = 0;
  int touching = 0;
  for (int i = 0; i < 500; ++i) {
    DetectorQuery query = queryOf(torus, torus, {0.05 * random.vector(1), random.turn()});
    every.find(query, a);
    query.first_only = true;
    first.find(query, b);
    EXPECT_EQ(a.report.touching > 0, b.report.touching > 0);
    touching += a.report.touching > 0 ? 1 : 0;
    most += a.report.work;
    work += b.report.work;
  }
  EXPECT_LT(work, most);
  EXPECT_GT(touching, 50);
}

TEST(PointField, WhatWasLearntOfAVolumeSaysNothingOfTheNextAtItsAddress) {
  // A mesh is dropped, and the next one's view lies where its was: nearer, or with other voxels and of another tool.
  const TestVolume ball = test::sphereVolume(0.005, 0.0005), pea = test::sphereVolume(0.002, 0.0005);
  const TestVolume low = test::boxVolume({0.02, 0.02, 0.001}, 0.0005);
  const TestVolume high = test::boxVolume({0.02, 0.02, 0.006}, 0.001);
  TestVolume a, b;
  PointFieldDetector detector(kRoom);
  ContactSet contacts, fresh;
  const std::pair<const VolumeView*, const VolumeView*> pairs[] = {
      {&ball.view, &low.view}, {&ball.view, &high.view}, {&pea.view, &high.view}, {&ball.view, &high.view}};
  for (const auto& [tool, obstacle] : pairs) {
    a.view = *tool;
    b.view = *obstacle;
    const DetectorQuery query = queryOf(a, b, at(0.001, 0.002, 0.0095));
    detector.find(query, contacts);
    PointFieldDetector(kRoom).find(query, fresh);
    EXPECT_EQ(fresh.count > 0, tool == &ball.view && obstacle == &high.view);
    EXPECT_EQ(contacts.report.touching, fresh.report.touching);
    EXPECT_EQ(contacts.integral.force, fresh.integral.force);
  }
}

TEST(PointField, AWallThinnerThanAStepIsMet) {
  // 0.6 mm, at 1 m/s and 1 kHz.
  const TestVolume wall = test::boxVolume({0.01, 0.01, 0.0003}, 0.00025);
  const TestVolume ball = test::sphereVolume(0.001, 0.00025);
  PointFieldDetector swept(kRoom), plain(kRoom, {.swept = false});
  int without = 0;
  for (double start = 0.00143; start < 0.0024; start += 0.0001) {
    bool met = false;
    for (int tick = 0; tick < 5; ++tick) {
      DetectorQuery query = queryOf(ball, wall, at(0.0001, 0.0002, start - 0.001 * (tick + 1)));
      query.a.X_WO_before = at(0.0001, 0.0002, start - 0.001 * tick);
      ContactSet contacts, other;
      swept.find(query, contacts);
      plain.find(query, other);
      const double lowest = query.a.X_WO.p.z() - 0.001;
      if (lowest > 0.0003) continue;
      if (met) break;
      met = true;
      // The first tick past the face must push back up, and say how far.
      ASSERT_GT(contacts.count, 0u) << start << " " << tick;
      EXPECT_GT(contacts.integral.force.z(), 0) << start;
      double deepest = 0, up = 0;
      for (const Contact& c : contacts.contacts()) {
        deepest = std::max(deepest, c.depth);
        up = std::max(up, c.n_W.z());
      }
      EXPECT_GT(up, 0.9);
      EXPECT_GT(deepest, 0.5 * (0.0003 - lowest) - 0.00025) << start;
      if (other.count == 0 || other.integral.force.z() <= 0) ++without;
    }
    EXPECT_TRUE(met);
  }
  EXPECT_GT(without, 0);  // Else the test shows nothing.
}

TEST(PointField, DepthAndDirectionAreKnownFarInside) {
  const TestVolume block = test::boxVolume({0.04, 0.04, 0.02}, 0.001);
  const TestVolume ball = test::sphereVolume(0.002, 0.0005);
  PointFieldDetector detector(kRoom);
  ContactSet contacts;
  detector.find(queryOf(ball, block, at(0.01, 0.005, 0.008)), contacts);
  ASSERT_GT(contacts.count, 0u);
  EXPECT_NEAR(contacts.deepest, 0.014, 0.001);
  EXPECT_NEAR(contacts.integral.force.normalized().z(), 1, 0.01);
  // Every point of the ball is inside; their mean depth is the centre's.
  const double expected = ball.view.header->area * 0.012;
  EXPECT_NEAR(contacts.integral.force.z(), expected, 0.02 * expected);
}

TEST(PointField, RestingContactsGrowOlderAndPartingOnesAreDropped) {
  const TestVolume ball = test::sphereVolume(0.01, 0.0005);
  const TestVolume plate = test::boxVolume({0.02, 0.02, 0.01}, 0.0005);
  PointFieldDetector detector(kRoom);
  ContactSet contacts;
  DetectorQuery query = queryOf(ball, plate, at(0, 0, 0.02 - 0.0003));
  for (std::uint32_t i = 0; i < 10; ++i) {
    query.a.X_WO.p.z() += i % 2 == 0 ? 1e-7 : -1e-7;
    detector.find(query, contacts);
    ASSERT_GT(contacts.count, 0u);
    for (const Contact& c : contacts.contacts()) EXPECT_EQ(c.age, i);
  }
  query.period = 1e-3;
  query.a.V_WO.v.z() = 0.2;
  detector.find(query, contacts);
  EXPECT_GT(contacts.count, 0u);  // 0.2 mm until the next query: still inside.
  query.a.V_WO.v.z() = 0.5;
  detector.find(query, contacts);
  EXPECT_EQ(contacts.count, 0u);
  EXPECT_GT(contacts.integral.force.z(), 0);  // The field's force is what it is.
  detector.reset();
  query.a.V_WO.v.z() = 0;
  detector.find(query, contacts);
  for (const Contact& c : contacts.contacts()) EXPECT_EQ(c.age, 0u);
}

TEST(PointField, ContactsAreAsManyAsWantedAndKeepTheArea) {
  const TestVolume torus = test::torusVolume(0.02, 0.006, 0.001, fine(0.0005));
  const TestVolume plate = test::boxVolume({0.04, 0.04, 0.01}, 0.001);
  PointFieldDetector detector(kRoom);
  for (const std::uint32_t most : {6u, 12u, kMostClusters}) {
    DetectorQuery query = queryOf(torus, plate, at(0, 0, 0.0145));
    query.max_contacts = most;
    ContactSet contacts;
    detector.find(query, contacts);
    ASSERT_GT(contacts.count, 1u);
    EXPECT_LE(contacts.count, most);
    double area = 0;
    for (const Contact& c : contacts.contacts()) area += c.area;
    EXPECT_NEAR(area, contacts.touching_area, 1e-9);
  }
}

TEST(PointField, ATooLargeToolIsReportedDropped) {
  const TestVolume ball = test::sphereVolume(0.01, 0.0005);
  PointFieldDetector detector(2);
  ContactSet contacts;
  detector.find(queryOf(ball, ball, at(0, 0, 0)), contacts);
  EXPECT_EQ(contacts.count, 0u);
  EXPECT_TRUE(contacts.report.exhausted);
  EXPECT_GT(contacts.report.dropped, 0u);
}

}  // namespace
}  // namespace hapticd
