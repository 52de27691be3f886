// The sphere descent and the voxmap: that they find what there is, and as much as there is.
#include <gtest/gtest.h>

#include <memory>

#include "rt/contact/point_field.h"
#include "rt/contact/sphere_descent.h"
#include "rt/contact/voxmap.h"
#include "tests/support/random.h"
#include "tests/support/shape/test_volume.h"
#include "tests/unit/contact/voxels.h"

namespace hapticd {
namespace {

using test::queryOf, test::surfaceVoxels, test::TestVolume;

/** Whether a corner or the centre of one cube, turned or straight, lies well within the other. */
bool cornersMeet(const Vec3& p, const Quat& turn, double p_side, const Vec3& q, double q_side) {
  for (int i = 0; i < 9; ++i) {
    const Vec3 corner = i == 8 ? Vec3::Zero() : Vec3(i & 1 ? 0.5 : -0.5, i & 2 ? 0.5 : -0.5, i & 4 ? 0.5 : -0.5);
    const Vec3 in_q = p + turn * (p_side * corner) - q;
    const Vec3 in_p = turn.conjugate() * (q + q_side * corner - p);
    if (in_q.cwiseAbs().maxCoeff() < 0.4999 * q_side || in_p.cwiseAbs().maxCoeff() < 0.4999 * p_side) return true;
  }
  return false;
}

TEST(SphereDescent, FindsThePairsOfVoxelsThatTryingAllFinds) {
  for (const OctreeShape shape : {OctreeShape::kEight, OctreeShape::kMixed, OctreeShape::kSixtyFour}) {
    VolumeOptions options;
    options.octree = shape;
    const TestVolume torus = test::torusVolume(0.012, 0.004, 0.001, options);
    const TestVolume ball = test::sphereVolume(0.012, 0.00125, 24, options);
    const TestVolume coarse = test::sphereVolume(0.012, 0.002, 24, options);
    const std::pair<const VolumeView*, const VolumeView*> cases[] = {
        {&torus.view, &ball.view}, {&ball.view, &torus.view}, {&coarse.view, &torus.view}};
    for (const auto& [a, b] : cases) {
      const auto va = surfaceVoxels(*a), vb = surfaceVoxels(*b);
      // Voxels that overlap are found, for a node's sphere holds its voxels; only those whose spheres do are.
      const double sides = static_cast<double>(a->voxel) + b->voxel;
      const double reach = 0.5 * std::sqrt(3.0) * sides;
      Random random(seedOf(2));
      std::uint64_t total = 0;
      for (const bool tight : {true, false}) {
        SphereDescentDetector detector({.tight = tight});
        SphereDescentDetector stepping({.tight = tight, .threshold = 1e-30});  // Each side's steps one by one.
        ContactSet contacts, by_levels;
        std::uint64_t found = 0, meet = 0;
        for (int i = 0; i < 6; ++i) {
          const Pose X_WB = random.pose(0.5), X_BA = random.pose(0.02);
          std::uint32_t sure = 0, most = 0, edge = 0;
          for (const Vec3& p : va) {
            const Vec3 x = X_BA * p;
            for (const Vec3& q : vb) {
              if ((x - q).squaredNorm() > (reach + 1e-7) * (reach + 1e-7)) continue;
              ++most;
              edge += (x - q).norm() > reach - 1e-7 ? 1 : 0;  // Rounding decides.
              sure += cornersMeet(x, X_BA.q, a->voxel, q, b->voxel) ? 1 : 0;
            }
          }
          DetectorQuery query;
          query.a.volume = a;
          query.b.volume = b;
          query.a.X_WO = query.a.X_WO_before = X_WB * X_BA;
          query.b.X_WO = query.b.X_WO_before = X_WB;
          detector.find(query, contacts);
          const ContactSet free = contacts;
          query.budget.units = 1u << 30;  // More than enough, but asked for at each level.
          detector.find(query, contacts);
          EXPECT_EQ(contacts.report.touching, free.report.touching);
          EXPECT_EQ(contacts.report.work, free.report.work);
          EXPECT_EQ(contacts.integral.force, free.integral.force);
          stepping.find(query, by_levels);
          EXPECT_LE(by_levels.report.touching, contacts.report.touching + edge);
          EXPECT_GE(by_levels.report.touching, 0.98 * contacts.report.touching - 3);
          EXPECT_NEAR(contacts.touching_area, by_levels.touching_area, 0.02 * contacts.touching_area + 3e-6);
          // Force is area times depth: as for the area.
          EXPECT_LE((contacts.integral.force - by_levels.integral.force).norm(),
                    0.02 * by_levels.integral.force.norm() + 3e-6 * std::max(contacts.deepest, 0.0) + 1e-9);
          // A voxel's area counts once, however many it meets.
          EXPECT_LE(contacts.touching_area, a->header->area * 1.0001);
          for (const ContactSet* c : {&contacts, &by_levels}) {
            EXPECT_GE(c->report.touching, sure);
            EXPECT_LE(c->report.touching, most);
          }
          if (sure > 0) {
            EXPECT_GT(contacts.count, 0u);
          }
          if (most == 0) {
            EXPECT_EQ(contacts.count, 0u);
          }
          total += sure;
          found += by_levels.report.touching;
          meet += most;
        }
        // Of pairs whose spheres alone meet, all but those whose nodes do not: one per cent at most.
        EXPECT_GT(static_cast<double>(found), 0.99 * static_cast<double>(meet));
      }
      EXPECT_GT(total, 300u);
    }
  }
}

TEST(SphereDescent, OneTouchIsFoundEarlyAndNoneIsMissed) {
  const TestVolume torus = test::torusVolume(0.02, 0.006, 0.001);
  SphereDescentDetector detector;
  Random random(seedOf(17));
  ContactSet all, first;
  std::uint64_t work = 0, full = 0;
  int touching = 0, hidden = 0, apart = 0;
  for (int i = 0; i < 600 || (hidden < 4 && i < 3000); ++i) {  // One in 80 is hidden.
    DetectorQuery query = queryOf(torus, torus, random.pose(0.05));
    detector.find(query, all);
    query.first_only = true;
    detector.find(query, first);
    EXPECT_EQ(all.report.touching > 0, first.report.touching > 0) << i;
    if (all.report.touching == 0) {
      // In vain: the few were asked for nothing.
      EXPECT_GE(first.report.work, all.report.work);
      ++apart;
      continue;
    }
    ++touching;
    hidden += all.report.touching < 20 ? 1 : 0;
    work += first.report.work;
    full += all.report.work;
  }
  EXPECT_GT(touching, 100);
  EXPECT_GT(hidden, 3);
  EXPECT_GT(apart, 100);
  EXPECT_LT(5 * work, full);
}

TEST(SphereDescent, KeepsASmallBudgetToo) {
  // What is left at one level waits while the next is walked: it has been spent all the same.
  const TestVolume a = test::torusVolume(0.012, 0.004, 0.0008);
  for (const SphereLeaf leaf : {SphereLeaf::kSphere, SphereLeaf::kFieldValue}) {
    SphereDescentDetector detector({.leaf = leaf});
    ContactSet contacts;
    Random random(seedOf(7));
    int exhausted = 0;
    for (int i = 0; i < 2000; ++i) {
      DetectorQuery query = queryOf(a, a, random.pose(0.012));
      query.budget.units = 1 + random.below(60u);
      detector.find(query, contacts);
      ASSERT_LE(contacts.report.work, query.budget.units) << "query " << i;
      exhausted += contacts.report.exhausted ? 1 : 0;
    }
    EXPECT_GT(exhausted, 500);
  }
}

TEST(SphereDescent, KeepsItsBudgetWithTheMostImportantRefined) {
  VolumeOptions options;
  options.sensation = true;
  for (const SphereLeaf leaf : {SphereLeaf::kSphere, SphereLeaf::kFieldValue}) {
    for (const bool sensation : {false, true}) {
      options.sensation = sensation;
      const TestVolume a = test::torusVolume(0.012, 0.004, 0.0008, options);
      SphereDescentDetector detector({.leaf = leaf});
      ContactSet all, some;
      Random random(seedOf(6));
      int exhausted = 0;
      for (int i = 0; i < 60; ++i) {
        DetectorQuery query = queryOf(a, a, random.pose(0.012));
        detector.find(query, all);
        query.budget.units = 1 + static_cast<std::uint32_t>(std::pow(10.0, random.in(0, 5.5)));
        detector.find(query, some);
        EXPECT_LE(some.report.work, query.budget.units);
        EXPECT_LE(some.touching_area, 1.0001 * a.view.header->area);
        exhausted += some.report.exhausted ? 1 : 0;
        if (!some.report.exhausted) {
          // Another way of the same sums: of some pairs rounding decides, of all 2e-4 by 1e-7 m in half a voxel.
          EXPECT_LE(some.report.touching, 1.0002 * all.report.touching + 3);
          EXPECT_GE(some.report.touching, 0.98 * all.report.touching - 3);
        }
        if (some.report.exhausted && some.report.touching > 0) {
          EXPECT_GT(some.report.coarsest, 0);
        }
        if (some.report.exhausted && all.count > 0 && query.budget.units > 300) {
          EXPECT_GT(some.count, 0u);
        }
      }
      EXPECT_GT(exhausted, 10);
      EXPECT_LT(exhausted, 60);
    }
  }
}

TEST(SphereDescent, AThresholdLeavesFlatPartsCoarse) {
  VolumeOptions options;
  options.sensation = true;
  const TestVolume plate = test::boxVolume({0.016, 0.016, 0.004}, 0.0005, options);
  ContactSet fine, coarse;
  DetectorQuery query = queryOf(plate, plate, {{0, 0, 0.0079}, Quat::Identity()});
  SphereDescentDetector(SphereDescentOptions{}).find(query, fine);
  SphereDescentDetector({.threshold = 1e9}).find(query, coarse);  // More than any phi over any area here.
  EXPECT_GT(fine.count, 0u);
  EXPECT_GT(coarse.count, 0u);
  EXPECT_LT(coarse.report.work, fine.report.work / 4);
  EXPECT_GT(coarse.report.coarsest, fine.report.coarsest);
  EXPECT_FALSE(coarse.report.exhausted);
}

TEST(SphereDescent, DepthAndNormalAreTheFields) {
  const TestVolume ball = test::sphereVolume(0.01, 0.0005);
  const TestVolume plate = test::boxVolume({0.02, 0.02, 0.01}, 0.0005);
  for (const SphereLeaf leaf : {SphereLeaf::kSphere, SphereLeaf::kFieldValue}) {
    SphereDescentDetector detector({.leaf = leaf});
    ContactSet contacts;
    detector.find(queryOf(ball, plate, {{0, 0, 0.0198}, Quat::Identity()}), contacts);
    ASSERT_GT(contacts.count, 0u);
    for (const Contact& c : contacts.contacts()) EXPECT_NEAR(c.n_W.z(), 1, 0.01);
    EXPECT_NEAR(contacts.deepest, 0.0002, 0.0007);
    detector.find(queryOf(ball, plate, {{0, 0, 0.0215}, Quat::Identity()}), contacts);
    EXPECT_EQ(contacts.count, 0u);
  }
}

TEST(SphereDescent, ContactsOfARingOnAPlateStandAllAroundIt) {
  const double ring = 0.02, tube = 0.006, voxel = 0.001, depth = 0.002;
  const TestVolume torus = test::torusVolume(ring, tube, voxel);
  const TestVolume plate = test::boxVolume({0.04, 0.04, 0.01}, voxel);
  for (const double threshold : {0.0, 1e-30}) {
    SphereDescentDetector detector({.threshold = threshold});
    ContactSet contacts;
    detector.find(queryOf(torus, plate, {{0.001, 0.002, 0.016 - depth}, Quat::Identity()}), contacts);
    std::uint32_t quarters = 0;
    EXPECT_GE(contacts.count, 4u);
    for (const Contact& c : contacts.contacts()) {
      const Vec3 p = c.p_WA - Vec3(0.001, 0.002, 0);
      EXPECT_NEAR(p.head<2>().norm(), ring, 0.3 * ring);
      EXPECT_NEAR(c.p_WA.z(), 0.01 - depth / 2, 1.5 * voxel);
      EXPECT_NEAR(c.depth, depth / 2, 1.5 * voxel);
      quarters |= 1u << ((p.x() > 0 ? 1 : 0) + (p.y() > 0 ? 2 : 0));
    }
    EXPECT_EQ(quarters, 15u);
    EXPECT_LT(contacts.integral.torque.norm(), 0.1 * ring * contacts.integral.force.norm());
  }
}

TEST(SphereDescent, FindsNothingFarAwayOrNowhere) {
  const TestVolume small = test::sphereVolume(0.003, 0.001);  // All in one window.
  for (const SphereLeaf leaf : {SphereLeaf::kSphere, SphereLeaf::kFieldValue}) {
    SphereDescentDetector detector({.leaf = leaf});
    ContactSet contacts;
    for (const double x : {0.02, 1e3, 1e12, 1e30, static_cast<double>(NAN), static_cast<double>(INFINITY)}) {
      detector.find(queryOf(small, small, {{x, 0, 0}, Quat::Identity()}), contacts);
      EXPECT_EQ(contacts.count, 0u) << x;
      EXPECT_EQ(contacts.report.touching, 0u) << x;
    }
    detector.find(queryOf(small, small, {{0.004, 0, 0}, Quat::Identity()}), contacts);
    EXPECT_GT(contacts.count, 0u);
  }
}

TEST(EveryDetector, EndsSoonAfterADeadlineThatHasPassed) {
  VolumeOptions options;
  options.point_spacing_m = 0.0002;
  const TestVolume ball = test::sphereVolume(0.01, 0.0008, 60, options);
  const TestVolume plate = test::boxVolume({0.02, 0.02, 0.01}, 0.0008);
  ManualClock clock(10);
  std::vector<std::unique_ptr<Detector>> all;
  all.push_back(std::make_unique<PointFieldDetector>(10'000, PointFieldOptions{.coherent = false}));
  all.push_back(std::make_unique<SphereDescentDetector>());
  all.push_back(std::make_unique<SphereDescentDetector>(SphereDescentOptions{.leaf = SphereLeaf::kFieldValue}));
  all.push_back(std::make_unique<VoxmapDetector>());
  ContactSet full, late;
  for (const auto& detector : all) {
    DetectorQuery query = queryOf(ball, plate, {{0, 0, 0.012}, Quat::Identity()});
    query.a.X_WO_before.p.z() += 0.01;  // A way to sweep.
    detector->find(query, full);
    EXPECT_FALSE(full.report.exhausted) << detector->name();
    query.budget.clock = &clock;
    query.budget.deadline_ns = 10;
    detector->find(query, late);
    EXPECT_TRUE(late.report.exhausted) << detector->name();
    EXPECT_LE(late.report.work, 256 + full.report.work / 8) << detector->name();
    EXPECT_LT(late.report.work, full.report.work) << detector->name();
  }
}

TEST(Voxmap, KeepsASmallBudgetToo) {
  const TestVolume a = test::torusVolume(0.012, 0.004, 0.0008);
  VoxmapDetector detector;
  ContactSet contacts;
  Random random(seedOf(7));
  for (int i = 0; i < 300; ++i) {
    DetectorQuery query = queryOf(a, a, random.pose(0.012));
    detector.find(query, contacts);
    const std::uint32_t all = contacts.report.work;
    query.budget.units = 1 + random.below(60u);
    detector.find(query, contacts);
    ASSERT_LE(contacts.report.work, query.budget.units) << "query " << i;
    EXPECT_EQ(contacts.report.exhausted, contacts.report.work < all) << "query " << i;
    EXPECT_LE(contacts.report.dropped_area, 1.0001 * a.view.header->area);
  }
}

TEST(Voxmap, PointsInSurfaceVoxelsPushAlongTheirNormalsUpToHalfADiagonal) {
  const TestVolume ball = test::sphereVolume(0.01, 0.001, 60);
  const TestVolume plate = test::boxVolume({0.02, 0.02, 0.01}, 0.001);
  VoxmapDetector detector;
  ContactSet contacts;
  detector.find(queryOf(ball, plate, {{0, 0, 0.0225}, Quat::Identity()}), contacts);
  EXPECT_EQ(contacts.count, 0u);
  double before = 0;
  for (const double depth : {0.0008, 0.0016, 0.005}) {
    detector.find(queryOf(ball, plate, {{0.0002, 0.0001, 0.02 - depth}, Quat::Identity()}), contacts);
    ASSERT_GT(contacts.count, 0u) << depth;
    EXPECT_GT(contacts.integral.force.z(), before);
    before = contacts.integral.force.z();
    EXPECT_LE(contacts.deepest, 0.5 * std::sqrt(3.0) * 0.001 + 1e-9);
    EXPECT_LT(contacts.integral.force.head<2>().norm(), 0.2 * contacts.integral.force.z());
  }
}

}  // namespace
}  // namespace hapticd
