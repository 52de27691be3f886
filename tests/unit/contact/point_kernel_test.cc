// The vector paths of the point kernel: the same bits on all, and what the scalar field says.
#include "rt/contact/point_kernel.h"

#include <gtest/gtest.h>

#include <cstring>

#include "rt/volume/distance.h"
#include "tests/support/random.h"
#include "tests/support/shape/test_volume.h"

namespace hapticd {
namespace {

using test::TestVolume;

/** What a query makes of two volumes, written down again. */
struct Tables {
  FieldTable field{};
  PointTable points{};
  Placement placement{};

  Tables(const VolumeView& a, const VolumeView& b, const Pose& X_BA) {
    const Mat3 R = X_BA.q.toRotationMatrix() / b.voxel;
    const Vec3 t = (X_BA.p - b.originPoint()) / b.voxel;
    for (int i = 0; i < 3; ++i) {
      field.cells[i] = b.cells[static_cast<std::size_t>(i)];
      field.top[i] = std::nextafter(8.0F * static_cast<float>(field.cells[i]), 0.0F);
      for (int j = 0; j < 3; ++j) placement.row[i][j] = static_cast<float>(R(i, j));
      placement.shift[i] = static_cast<float>(t[i]);
    }
    field.cell = b.cell;
    field.coarse = b.coarse;
    field.bricks = b.bricks;
    field.fine_step = b.fine_step / b.voxel;
    field.coarse_step = b.coarse_step / b.voxel;
    points = {a.point[0], a.point[1], a.point[2], a.area};
  }
};

PointSums cleared() {
  PointSums sums{};
  std::fill_n(sums.deepest, 16, -1e9F);
  return sums;
}

class PointKernels : public ::testing::Test {
 protected:
  PointKernels() : a_(test::torusVolume(0.02, 0.006, 0.001)), b_(test::sphereVolume(0.02, 0.001)) {}
  TestVolume a_, b_;
  float number(double low, double high) { return static_cast<float>(random_.in(low, high)); }
  Random random_{seedOf(7)};
};

TEST_F(PointKernels, GiveTheSameBitsOnEveryPath) {
  std::vector<const PointKernel*> others;
  const PointPath best = pointPath();
  for (const PointPath path : {PointPath::kAvx2, PointPath::kAvx512}) {
    if (!choosePointPath(path)) continue;
    others.push_back(&pointKernel());
  }
  ASSERT_TRUE(choosePointPath(best));
  std::uint32_t touching = 0;
  for (int i = 0; i < 300; ++i) {
    const Tables t(a_.view, b_.view, random_.pose(0.04));
    const std::uint32_t first = random_.below(a_.view.point_count),
                        count = std::min(1 + random_.below(a_.view.point_count) / 8, a_.view.point_count - first);
    const PointRange range{first, count, {20, 21, 22}, i % 3 == 0 ? 2.5F : 1.0F, i % 2 == 0 ? 0.0F : 0.7F};
    PointSums expected = cleared();
    const float nearest = kPortablePointKernel.run(t.field, t.points, t.placement, range, expected);
    touching += expected.touching;
    float reduced[PointSums::kCount + 1];
    kPortablePointKernel.reduce(expected, reduced);
    for (const PointKernel* kernel : others) {
      PointSums got = cleared();
      EXPECT_EQ(kernel->run(t.field, t.points, t.placement, range, got), nearest);
      ASSERT_EQ(std::memcmp(got.sum, expected.sum, sizeof got.sum), 0) << i;
      ASSERT_EQ(std::memcmp(got.deepest, expected.deepest, sizeof got.deepest), 0) << i;
      EXPECT_EQ(got.touching, expected.touching);
      float again[PointSums::kCount + 1];
      kernel->reduce(got, again);
      EXPECT_EQ(std::memcmp(again, reduced, sizeof again), 0);
    }
  }
  EXPECT_GT(touching, 1000u);
}

TEST_F(PointKernels, BoundAndExpireAreTheSameOnEveryPath) {
  alignas(64) float x[16], y[16], z[16], r[16], expected[16], got[16];
  const PointPath best = pointPath();
  for (int i = 0; i < 300; ++i) {
    const Tables t(a_.view, b_.view, random_.pose(0.04));
    for (int k = 0; k < 16; ++k) {
      x[k] = number(-0.1, 0.1);
      y[k] = number(-0.1, 0.1);
      z[k] = number(-0.1, 0.1);
      r[k] = std::abs(number(-0.1, 0.1)) * 30;
    }
    const PatchTable patches{x, y, z, r};
    kPortablePointKernel.bound(t.field, patches, t.placement, 0, expected);
    float left[16];
    std::copy_n(x, 16, left);
    const std::uint32_t gone = kPortablePointKernel.expire(left, r, 0.001F, 0.01F);
    for (const PointPath path : {PointPath::kAvx2, PointPath::kAvx512}) {
      if (!choosePointPath(path)) continue;
      pointKernel().bound(t.field, patches, t.placement, 0, got);
      EXPECT_EQ(std::memcmp(got, expected, sizeof got), 0);
      float other[16];
      std::copy_n(x, 16, other);
      EXPECT_EQ(pointKernel().expire(other, r, 0.001F, 0.01F), gone);
      EXPECT_EQ(std::memcmp(other, left, sizeof left), 0);
    }
  }
  ASSERT_TRUE(choosePointPath(best));
}

TEST_F(PointKernels, MeetIsTheSameOnEveryPathAndWhatOneByOneTells) {
  alignas(64) float x[64], y[64], z[64];
  const PointPath best = pointPath();
  std::uint64_t met = 0, all = 0;
  for (int i = 0; i < 500; ++i) {
    for (int k = 0; k < 64; ++k) {
      x[k] = number(-1, 1);
      y[k] = number(-1, 1);
      z[k] = number(-1, 1);
    }
    const float from[3] = {number(-1, 1), number(-1, 1), number(-1, 1)}, at[3] = {3 * number(-1, 1), 2, number(-1, 1)};
    const std::uint64_t mask = random_.bits() >> (i % 3 == 0 ? 32 : 0);
    const BallTable balls{x, y, z, 0.8F, i % 2 == 0 ? 1.0F : 0.0F};
    BallSums expected{};
    const std::uint64_t hits = kPortablePointKernel.meet(balls, from, at, mask, &expected);
    EXPECT_EQ(kPortablePointKernel.meet(balls, from, at, mask, nullptr), hits);
    double sum[4] = {};
    for (int k = 0; k < 64; ++k) {
      const bool hit = (hits >> k & 1) != 0;
      const double d = std::hypot(from[0] + x[k], from[1] + y[k], from[2] + z[k]);
      if (std::abs(d - balls.reach) > 1e-5) {
        EXPECT_EQ(hit, (mask >> k & 1) != 0 && d < balls.reach);
      }
      if (!hit) continue;
      const double overlap = balls.reach - d;
      sum[0] += overlap;
      sum[1] += overlap * (at[0] + balls.follow * x[k]);
      sum[2] += overlap * (at[1] + balls.follow * y[k]);
      sum[3] += overlap * (at[2] + balls.follow * z[k]);
    }
    float reduced[4];
    kPortablePointKernel.reduceBalls(expected, reduced);
    for (int s = 0; s < 4; ++s) EXPECT_NEAR(reduced[s], sum[s], 1e-4);
    met += static_cast<std::uint64_t>(__builtin_popcountll(hits));
    all += static_cast<std::uint64_t>(__builtin_popcountll(mask));
    for (const PointPath path : {PointPath::kAvx2, PointPath::kAvx512}) {
      if (!choosePointPath(path)) continue;
      BallSums got{};
      EXPECT_EQ(pointKernel().meet(balls, from, at, mask, &got), hits);
      EXPECT_EQ(std::memcmp(&got, &expected, sizeof got), 0);
      float again[4];
      pointKernel().reduceBalls(got, again);
      EXPECT_EQ(std::memcmp(again, reduced, sizeof again), 0);
    }
  }
  ASSERT_TRUE(choosePointPath(best));
  EXPECT_GT(met, all / 20);
  EXPECT_LT(met, all / 2);
}

TEST_F(PointKernels, NearIsTheSameOnEveryPathAndWhatOneByOneTells) {
  float x[64], y[64], z[64], r[64];
  const PointPath best = pointPath();
  std::uint32_t met = 0, all = 0;
  for (int i = 0; i < 500; ++i) {
    for (int k = 0; k < 64; ++k) {
      x[k] = number(-1, 1);
      y[k] = number(-1, 1);
      z[k] = number(-1, 1);
      r[k] = std::abs(number(-1, 1));
    }
    const float centre[3] = {number(-1, 1), number(-1, 1), number(-1, 1)}, radius = 0.3F;
    const std::uint32_t count = 1 + random_.below(64u);
    const std::uint64_t hits = kPortablePointKernel.near({x, y, z, r}, count, centre, radius);
    for (std::uint32_t k = 0; k < 64; ++k) {
      const double gap = std::hypot(x[k] - centre[0], y[k] - centre[1], z[k] - centre[2]) - r[k] - radius;
      if (k < count && std::abs(gap) < 1e-5) continue;
      EXPECT_EQ((hits >> k & 1) != 0, k < count && gap < 0);
      met += k < count && gap < 0 ? 1 : 0;
    }
    all += count;
    for (const PointPath path : {PointPath::kAvx2, PointPath::kAvx512}) {
      if (!choosePointPath(path)) continue;
      EXPECT_EQ(pointKernel().near({x, y, z, r}, count, centre, radius), hits);
    }
  }
  ASSERT_TRUE(choosePointPath(best));
  EXPECT_GT(met, all / 10);
  EXPECT_LT(met, all / 2);
}

TEST_F(PointKernels, MeetWindowIsTheSameOnEveryPathAndWhatOneByOneTells) {
  const PointPath best = pointPath();
  std::vector<std::uint32_t> row(kWindow * kWindow);
  std::vector<float> x(96), y(96), z(96);
  std::uint32_t pairs = 0;
  for (int i = 0; i < 30; ++i) {
    for (std::uint32_t& r : row) r = static_cast<std::uint32_t>(random_.bits() & random_.bits() & random_.bits());
    const std::uint32_t count = 1 + random_.below(50u);
    for (std::uint32_t k = 0; k < count; ++k) {
      x[k] = i % 5 == 0 ? std::round(number(2, 30)) : number(2, 30);
      y[k] = number(2, 30);
      z[k] = number(2, 30);
    }
    const VoxelWindow window{row.data(), x.data(), y.data(), z.data(), i % 2 == 0 ? 1.73F : 1.99F};
    WindowSums expected{};
    kPortablePointKernel.meetWindow(window, count, false, expected);
    double sum[4] = {};
    std::uint32_t most = 0, sure = 0, voxels = 0;
    for (std::uint32_t k = 0; k < count; ++k) {
      std::uint32_t own = 0;
      for (std::uint32_t b = 0; b < kWindow * kWindow * kWindow; ++b) {
        if ((row[b / kWindow] >> b % kWindow & 1) == 0) continue;
        const double d = std::hypot(b % kWindow + 0.5 - x[k], b / kWindow % kWindow + 0.5 - y[k],
                                    b / kWindow / kWindow + 0.5 - z[k]);
        most += d < window.reach + 1e-5 ? 1 : 0;
        sure += d < window.reach - 1e-5 ? 1 : 0;
        if (d > window.reach) continue;
        ++own;
        const double overlap = window.reach - d;
        sum[0] += overlap;
        sum[1] += overlap * x[k];
        sum[2] += overlap * y[k];
        sum[3] += overlap * z[k];
      }
      voxels += own > 0 ? 1 : 0;
    }
    EXPECT_GE(expected.pairs, sure);
    EXPECT_LE(expected.pairs, most);
    EXPECT_NEAR(expected.voxels, voxels, most - sure);
    pairs += sure;
    float reduced[4];
    kPortablePointKernel.reduceBalls(expected.balls, reduced);
    for (int s = 0; s < 4; ++s) EXPECT_NEAR(reduced[s], sum[s], 1e-5 * sum[s] + 1e-4);
    WindowSums one{};
    kPortablePointKernel.meetWindow(window, count, true, one);
    EXPECT_EQ(one.voxels, expected.voxels > 0 ? 1u : 0u);
    for (const PointPath path : {PointPath::kAvx2, PointPath::kAvx512}) {
      if (!choosePointPath(path)) continue;
      WindowSums got{};
      pointKernel().meetWindow(window, count, false, got);
      EXPECT_EQ(got.pairs, expected.pairs);
      EXPECT_EQ(got.voxels, expected.voxels);
      EXPECT_EQ(std::memcmp(&got.balls, &expected.balls, sizeof got.balls), 0);
    }
  }
  ASSERT_TRUE(choosePointPath(best));
  EXPECT_GT(pairs, 500u);
}

TEST_F(PointKernels, SumWhatTheScalarFieldSays) {
  for (int i = 0; i < 50; ++i) {
    const Pose X = random_.pose(0.03);
    const Tables t(a_.view, b_.view, X);
    const PointRange range{0, a_.view.point_count, {0, 0, 0}, 1, 0};
    PointSums sums = cleared();
    const float nearest = pointKernel().run(t.field, t.points, t.placement, range, sums);
    float got[PointSums::kCount + 1];
    pointKernel().reduce(sums, got);
    Vec3 force = Vec3::Zero();
    double area = 0, deepest = -1e9;
    std::uint32_t inside = 0, undecided = 0;
    for (std::uint32_t p = 0; p < a_.view.point_count; ++p) {
      const DistanceSample s = distanceAt(b_.view, X * a_.view.pointAt(p));
      if (std::abs(s.value) < 1e-7) ++undecided;
      if (s.value >= 0) continue;
      ++inside;
      force -= a_.view.area[p] * s.value * s.gradient;
      area += a_.view.area[p];
      deepest = std::max(deepest, -s.value);
    }
    const double voxel = b_.view.voxel;
    EXPECT_NEAR(sums.touching, inside, undecided);
    EXPECT_NEAR(got[PointSums::kArea], area, 1e-4 * area + 65536.0 * undecided);
    const Vec3 f = voxel * Vec3(got[PointSums::kForce], got[PointSums::kForce + 1], got[PointSums::kForce + 2]);
    EXPECT_LE((f - force).norm(), 1e-3 * force.norm() + 1e-3 * area * voxel);
    if (inside > 0) {
      EXPECT_NEAR(got[PointSums::kCount] * voxel, deepest, 1e-6);
    }
    EXPECT_GE(nearest * voxel, std::min(-deepest, 0.0) - 1e-6);  // What is deep without a brick says 0.
    if (inside > 0) {
      EXPECT_LE(nearest, 0);
    }
  }
}

TEST_F(PointKernels, BoundIsBelowEveryInterpolatedDistanceInTheBall) {
  int tight = 0;
  for (int i = 0; i < 400; ++i) {
    const Pose X = random_.pose(0.03);
    const Tables t(a_.view, b_.view, X);
    alignas(64) float x[16], y[16], z[16], r[16], bound[16];
    for (int k = 0; k < 16; ++k) {
      x[k] = static_cast<float>(0.03 * random_.in(-1, 1));
      y[k] = static_cast<float>(0.03 * random_.in(-1, 1));
      z[k] = static_cast<float>(0.03 * random_.in(-1, 1));
      r[k] = static_cast<float>(3 * std::abs(random_.in(-1, 1)));
    }
    pointKernel().bound(t.field, {x, y, z, r}, t.placement, 0, bound);
    for (int k = 0; k < 16; ++k) {
      for (int n = 0; n < 8; ++n) {
        const Vec3 away =
            Vec3(random_.in(-1, 1), random_.in(-1, 1), random_.in(-1, 1)).normalized() * (r[k] * b_.view.voxel);
        const Vec3 at = X * Vec3(x[k], y[k], z[k]) + away;
        const DistanceSample s = distanceAt(b_.view, at);
        if (!s.fine) continue;
        EXPECT_GE(s.value / b_.view.voxel, bound[k] - 1e-3);
        tight += bound[k] > 0 && s.value / b_.view.voxel < bound[k] + 8 ? 1 : 0;
      }
    }
  }
  EXPECT_GT(tight, 100);
}

}  // namespace
}  // namespace hapticd
