#include "rt/cycle/velocity_estimator.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace hapticd {
namespace {

constexpr double kResolution = 1e-5, kRotationResolution = 1e-4;

DeviceSample sampleAt(std::int64_t t_ns, const Vec3& p) {
  DeviceSample s;
  s.t_ns = t_ns;
  s.p = p;
  s.fresh = true;
  return s;
}

Vec3 quantised(const Vec3& p) { return (p / kResolution).array().round().matrix() * kResolution; }

VelocityEstimator estimator() {
  VelocityEstimator e;
  e.setResolution(kResolution, kRotationResolution);
  return e;
}

TEST(VelocityEstimator, ConstantVelocityIsExactAfterTwoSamples) {
  VelocityEstimator e = estimator();
  const Vec3 v(0.1, -0.2, 0.05);
  EXPECT_TRUE(e.update(sampleAt(0, Vec3::Zero())).v.isZero(0));
  for (int i = 1; i < 40; ++i) {
    EXPECT_LT((e.update(sampleAt(i * 1'000'000, v * i * 1e-3)).v - v).norm(), 1e-12);
  }
}

TEST(VelocityEstimator, QuantisationNoiseFallsWithTheWindow) {
  // Slow motion: 3 mm/s is 0.3 counts a tick. A plain difference is wrong by up to 10 mm/s.
  VelocityEstimator e = estimator();
  double worst = 0;
  for (int i = 0; i < 2000; ++i) {
    const Twist v = e.update(sampleAt(i * 1'000'000, quantised({3e-3 * i * 1e-3, 0, 0})));
    if (i > 20) worst = std::max(worst, std::abs(v.v.x() - 3e-3));
  }
  EXPECT_LT(worst, kResolution / (15 * 1e-3) * 1.01) << "one count over the whole window";
}

TEST(VelocityEstimator, CountDitherAtRestIsAlmostSilent) {
  VelocityEstimator e = estimator();
  double worst = 0;
  for (int i = 0; i < 500; ++i) {
    const Twist v = e.update(sampleAt(i * 1'000'000, {(i * 7 % 3 == 0) ? kResolution : 0.0, 0, 0}));
    if (i > 20) worst = std::max(worst, v.v.norm());
  }
  EXPECT_LE(worst, kResolution / (15 * 1e-3) * 1.0001);
}

/** Readings a step apart differ by it but for their rounding, which is another at every place. */
TEST(VelocityEstimator, CountDitherIsAsSilentAtEveryPlace) {
  for (int place = -300; place < 300; ++place) {
    VelocityEstimator e = estimator();
    double worst = 0;
    for (int i = 0; i < 100; ++i) {
      const double at = kResolution * (37 * place + (i * 7 % 3 == 0 ? 1 : 0));
      const Twist v = e.update(sampleAt(i * 1'000'000, {at, 0, 0}));
      if (i > 20) worst = std::max(worst, v.v.norm());
    }
    EXPECT_LE(worst, kResolution / (15 * 1e-3) * 1.0001) << place;
  }
}

TEST(VelocityEstimator, FollowsASuddenStartWithinTwoSamples) {
  VelocityEstimator e = estimator();
  for (int i = 0; i < 50; ++i) (void)e.update(sampleAt(i * 1'000'000, Vec3::Zero()));
  (void)e.update(sampleAt(50'000'000, {0.2e-3, 0, 0}));
  const Twist v = e.update(sampleAt(51'000'000, {0.4e-3, 0, 0}));
  EXPECT_NEAR(v.v.x(), 0.2, 1e-9);
}

/** The slope of the longest window whose end-fit line passes all of the last samples within the resolution. */
double slopeByDefinition(const std::vector<double>& t, const std::vector<double>& y, double resolution) {
  double found = 0;
  const std::size_t last = y.size() - 1;
  for (std::size_t n = 1; n < 16 && n <= last; ++n) {
    const double slope = (y[last] - y[last - n]) / (t[last] - t[last - n]);
    bool fits = true;
    for (std::size_t j = last - n; j <= last; ++j)
      fits = fits && std::abs(y[last] + slope * (t[j] - t[last]) - y[j]) <= 1.001 * resolution;
    if (!fits) break;
    found = slope;
  }
  return found;
}

/** Each axis for itself; it turns, too, for a while each time. */
TEST(VelocityEstimator, AgreesWithTheDefinitionByBruteForce) {
  VelocityEstimator e = estimator();
  std::vector<double> y, angle, t;
  std::uint32_t state = 12345;
  double x = 0, turn = 0;
  for (int i = 0; i < 3000; ++i) {
    state = state * 1664525u + 1013904223u;
    x += ((state >> 8) % 1000) * 1e-7 * std::sin(i * 0.01);
    if (i / 23 % 2 == 1) turn += ((state >> 8) % 1000) * 1e-6;
    const std::int64_t t_ns = std::int64_t{i} * 1000000 + (state >> 20) % 200'000;
    y.push_back(std::round(x / kResolution) * kResolution);
    angle.push_back(std::round(turn / kRotationResolution) * kRotationResolution);
    t.push_back(static_cast<double>(t_ns) * 1e-9);
    DeviceSample sample = sampleAt(t_ns, {0, y.back(), 0});
    sample.q = Quat(Eigen::AngleAxisd(angle.back(), Vec3::UnitX()));
    const Twist got = e.update(sample);
    const double v = slopeByDefinition(t, y, kResolution), w = slopeByDefinition(t, angle, kRotationResolution);
    ASSERT_NEAR(got.v.y(), v, 1e-6 * (1 + std::abs(v))) << "sample " << i;
    ASSERT_NEAR(got.w.x(), w, 1e-6 * (1 + std::abs(w))) << "sample " << i;
  }
}

TEST(VelocityEstimator, AngularVelocityOfASteadyTurn) {
  VelocityEstimator e = estimator();
  const Vec3 w(0.4, -1.5, 0.8);
  Twist got;
  for (int i = 0; i < 100; ++i) {
    DeviceSample s = sampleAt(i * 1'000'000, Vec3::Zero());
    s.q = rotated(Quat(Eigen::AngleAxisd(2.0, Vec3(1, 2, 3).normalized())), w, i * 1e-3);
    if (i % 2 == 1) s.q.coeffs() = -s.q.coeffs();  // The same rotation.
    got = e.update(s);
  }
  EXPECT_LT((got.w - w).norm(), 1e-6);
}

TEST(VelocityEstimator, TheDevicesOwnVelocityWins) {
  VelocityEstimator e = estimator();
  DeviceSample s = sampleAt(0, Vec3::Zero());
  s.has_velocity = true;
  s.v = {1, 2, 3};
  s.w = {4, 5, 6};
  const Twist got = e.update(s);
  EXPECT_EQ(got.v, s.v);
  EXPECT_EQ(got.w, s.w);
  s.v = {3, 2, 1};
  EXPECT_EQ(e.update(s).v, s.v) << "of the same time, too";
  s.has_velocity = false;
  EXPECT_EQ(e.update(s).v, s.v) << "a reading that is no newer says nothing else";
}

TEST(VelocityEstimator, AResolutionThatIsNoneIsIgnored) {
  for (const double none : {0.0, -1.0, double{NAN}, double{INFINITY}}) {
    VelocityEstimator e = estimator(), other = estimator();
    other.setResolution(none, none);
    for (int i = 0; i < 100; ++i) {
      const int step = i * 7 % 3 == 0 ? 1 : 0;
      DeviceSample s = sampleAt(i * 1'000'000, {kResolution * step, 0, 0});
      s.q = Quat(Eigen::AngleAxisd(kRotationResolution * step, Vec3::UnitX()));
      const Twist expected = e.update(s), got = other.update(s);
      ASSERT_EQ(got.v, expected.v) << none << " at " << i;
      ASSERT_EQ(got.w, expected.w) << none << " at " << i;
    }
  }
}

/** Angles over the window of 1e-15 to 1e-10 rad, of which sines are all that is left. */
TEST(VelocityEstimator, TheSlowestTurnsAreTold) {
  for (const double w : {1e-13, 1e-10, 1e-8}) {
    VelocityEstimator e = estimator();
    Twist got;
    for (int i = 0; i < 40; ++i) {
      DeviceSample s = sampleAt(i * 1'000'000, Vec3::Zero());
      s.q = Quat(1, 0, 0.5 * w * i * 1e-3, 0);
      got = e.update(s);
    }
    EXPECT_NEAR(got.w.y(), w, 1e-6 * w);
  }
}

/** q and -q are one orientation. */
TEST(VelocityEstimator, AHandAtRestDoesNotTurnWhateverTheSignOfItsQuaternion) {
  VelocityEstimator e = estimator();
  for (int i = 0; i < 40; ++i) {
    DeviceSample s = sampleAt(i * 1'000'000, Vec3::Zero());
    if (i % 3 == 1) s.q.coeffs() = -s.q.coeffs();
    ASSERT_EQ(e.update(s).w, Vec3(0, 0, 0)) << i;
  }
}

TEST(VelocityEstimator, StaleRepeatedOrBrokenReadingsChangeNothing) {
  VelocityEstimator e = estimator();
  Twist before;
  for (int i = 0; i < 20; ++i) before = e.update(sampleAt(i * 1'000'000, {1e-4 * i, 0, 0}));
  DeviceSample stale = sampleAt(25'000'000, {9, 9, 9});
  stale.fresh = false;
  EXPECT_EQ(e.update(stale).v, before.v);
  EXPECT_EQ(e.update(sampleAt(19'000'000, {9, 9, 9})).v, before.v) << "same time";
  EXPECT_EQ(e.update(sampleAt(25'000'000, {std::nan(""), 0, 0})).v, before.v);
}

TEST(VelocityEstimator, AClockThatRunsBackwardsStartsAnew) {
  for (const int samples : {1, 2, 20, 40}) {
    for (const std::int64_t back_ns : {std::int64_t{1}, std::int64_t{500'000}, std::int64_t{5'000'000}}) {
      VelocityEstimator e = estimator();
      for (int i = 0; i < samples; ++i) (void)e.update(sampleAt(i * 1'000'000, {1e-4 * i, 0, 0}));
      const std::int64_t anew_ns = (samples - 1) * 1'000'000 - back_ns;
      EXPECT_TRUE(e.update(sampleAt(anew_ns, {9, 9, 9})).v.isZero(0)) << samples << " samples, " << back_ns << " ns";
      const Vec3 v = e.update(sampleAt(anew_ns + 1'000'000, {9, 9, 9.001})).v;
      EXPECT_NEAR(v.z(), 1, 1e-9);
      EXPECT_NEAR(v.x(), 0, 1e-9) << "of what was before nothing is left";
    }
  }
}

}  // namespace
}  // namespace hapticd
