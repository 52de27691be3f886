/** @file
 * Every vector path gives the same bits, and no rounding loses a box.
 */
#include "rt/geometry/tree/boxes.h"

#include <gtest/gtest.h>

#include <cstring>

#include "rt/geometry/nearest/nearest.h"
#include "rt/geometry/sweep/sweep.h"
#include "rt/geometry/tree/vicinity.h"
#include "tests/support/seeds.h"
#include "tests/support/shape/brute_distance.h"
#include "tests/support/shape/test_mesh.h"

namespace hapticd {
namespace {

using test::randomPoint;
using test::TestMesh;

/** Chooses a path for a scope. */
class OnPath {
 public:
  explicit OnPath(VectorPath path) : before_(vectorPath()), can_(choosePath(path)) {}
  ~OnPath() { choosePath(before_); }
  OnPath(const OnPath&) = delete;
  OnPath& operator=(const OnPath&) = delete;
  [[nodiscard]] bool can() const { return can_; }

 private:
  VectorPath before_;
  bool can_;
};

TEST(Boxes, ThePathCanBeChosen) {
  OnPath portable(VectorPath::kPortable);
  EXPECT_TRUE(portable.can());
  EXPECT_STREQ(nameOf(vectorPath()), "portable");
}

#if defined(__x86_64__)

TEST(Boxes, AllPathsAnswerAlikeToTheBit) {
  std::mt19937 random(seedOf(1));
  if (!OnPath(VectorPath::kAvx2).can()) GTEST_SKIP() << "no AVX2 here";
  for (int shape = 0; shape < 4; ++shape) {
    TestMesh mesh = test::crumpled(random, 12);
    const MeshView& view = *mesh.view();
    for (int i = 0; i < 3000; ++i) {
      Sweep sweep;
      sweep.a = randomPoint(random, 1.5);
      sweep.d = randomPoint(random, i % 3 == 0 ? 0.05 : 2);
      if (i % 5 == 0) sweep.d[i % 3] = 0;
      sweep.radius = i % 2 == 0 ? 0 : 0.05;
      sweep.two_sided = i % 4 < 2;
      sweep.limit = 1u << 30;
      NearestQuery query;
      query.x = sweep.a;
      query.limit = 1u << 30;
      SweepHit hit[2];
      Nearest nearest[2];
      std::uint32_t work[2];
      SweepResult result[2];
      for (const int k : {0, 1}) {
        OnPath path(k == 0 ? VectorPath::kPortable : VectorPath::kAvx2);
        Sweep s = sweep;
        NearestQuery q = query;
        result[k] = sweepMesh(view, s, hit[k]);
        ASSERT_EQ(nearestOnMesh(view, q, nearest[k]), NearestResult::kFound);
        work[k] = s.work + q.work;
      }
      ASSERT_EQ(result[0], result[1]);
      ASSERT_EQ(hit[0].t, hit[1].t);
      ASSERT_EQ(hit[0].feature, hit[1].feature);
      ASSERT_EQ(hit[0].normal, hit[1].normal);
      ASSERT_EQ(nearest[0].point, nearest[1].point);
      ASSERT_EQ(nearest[0].feature, nearest[1].feature);
      ASSERT_EQ(work[0], work[1]) << "not the same walk";
    }
  }
}

TEST(Boxes, EveryImplementationGivesTheSameKeys) {
  std::mt19937 random(seedOf(2));
  std::uniform_real_distribution<float> u(-1, 1);
  if (!OnPath(VectorPath::kAvx2).can()) GTEST_SKIP() << "no AVX2 here";
  for (int i = 0; i < 20000; ++i) {
    hd_bvh_node node{};
    node.used = 1 + random() % HD_BVH_WIDTH;
    BoxSweep sweep{};
    BoxPoint point{};
    for (int k = 0; k < 3; ++k) {
      for (std::uint32_t c = 0; c < node.used; ++c) {
        const float a = u(random), b = u(random);
        node.lower[k][c] = std::min(a, b);
        node.upper[k][c] = std::max(a, b);
      }
      sweep.upward[k] = random() % 2;
      sweep.inverse[k] =
          (sweep.upward[k] ? 1.0F : -1.0F) * (random() % 9 == 0 ? 1e30F : 1 / (0.01F + std::abs(u(random))));
      sweep.entry[k] = sweep.exit[k] = u(random);
      point.lower[k] = point.upper[k] = u(random);
    }
    float a[HD_BVH_WIDTH], b[HD_BVH_WIDTH];
    ASSERT_EQ(kPortableBoxTests.enter(node, sweep, 1, a), kAvx2BoxTests.enter(node, sweep, 1, b));
    ASSERT_EQ(std::memcmp(a, b, sizeof(float) * node.used), 0);
    ASSERT_EQ(kPortableBoxTests.approach(node, point, 0.3F, a), kAvx2BoxTests.approach(node, point, 0.3F, b));
    ASSERT_EQ(std::memcmp(a, b, sizeof(float) * node.used), 0);
  }
}

TEST(Boxes, AllPathsListTheSameTrianglesOfAVicinity) {
  std::mt19937 random(seedOf(3));
  if (!OnPath(VectorPath::kAvx2).can()) GTEST_SKIP() << "no AVX2 here";
  TestMesh mesh = test::crumpled(random, 24);
  const MeshView& view = *mesh.view();
  std::uniform_real_distribution<double> u(0, 1);
  int full = 0;
  std::uint32_t looked = 0, listed = 0;
  for (int i = 0; i < 300; ++i) {
    const double radius = std::pow(10.0, -2 + 1.5 * u(random));
    const Vec3 center = view.vertex(static_cast<std::uint32_t>(random() % view.triangle_count), 0);
    Vicinity vicinity[2];
    for (Vicinity& each : vicinity) {
      std::uint32_t work = 0;
      each.begin(view, center, center, radius);
      each.proceed(view, Vicinity::kMaxVisits, work);
    }
    if (vicinity[0].state() != Vicinity::State::kFull) continue;
    ++full;
    for (int j = 0; j < 20; ++j) {
      const Vec3 a = center + randomPoint(random, 0.5 * radius);
      const Vec3 b = j % 3 == 0 ? a : Vec3(a + randomPoint(random, 0.5 * radius));
      const double ball = j % 4 == 0 ? 0 : 0.3 * radius * u(random), behind = j % 2 == 0 ? 0 : 2 * radius;
      Vicinity::Reached reached[2];
      for (const int k : {0, 1}) {
        OnPath path(k == 0 ? VectorPath::kPortable : VectorPath::kAvx2);
        vicinity[k].reach(a, b, ball, behind, reached[k]);
      }
      ASSERT_EQ(reached[0].blocks, reached[1].blocks);
      ASSERT_EQ(reached[0].count, reached[1].count);
      for (std::uint32_t t = 0; t < reached[0].count; ++t) ASSERT_EQ(reached[0].triangle[t], reached[1].triangle[t]);
      looked += reached[0].blocks;
      listed += reached[0].count;
    }
  }
  EXPECT_GT(full, 200);
  EXPECT_GT(looked, 10000u);  // 31,000 to 35,000 at 8 seeds,
  EXPECT_GT(listed, 5000u);   // 9,000 to 10,200.
}

#endif

}  // namespace
}  // namespace hapticd
