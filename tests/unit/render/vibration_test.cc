#include "rt/render/surface/vibration.h"

#include <gtest/gtest.h>

#include "tests/support/shape/test_surface.h"

namespace hapticd {
namespace {

using test::TestVibration;

VibrationModel model(double speed, double force, double power, std::initializer_list<double> reflection) {
  VibrationModel m{speed, force, power, {}};
  std::copy(reflection.begin(), reflection.end(), m.reflection.begin());
  return m;
}

/** Four corners of speed and force, two triangles. */
TestVibration square() {
  TestVibration t;
  t.models = {model(0.01, 0.5, 1, {-0.9, 0.3}), model(0.2, 0.5, 4, {-0.5}), model(0.01, 2, 2, {0.2, 0.7}),
              model(0.2, 2, 8, {-0.3, 0.9, -0.4})};
  t.triangles = {{0, 1, 2}, {1, 3, 2}};
  t.finish();
  return t;
}

/** Autocorrelation at the lags 0, 1, ... of what is heard at one speed and force. */
std::vector<double> heard(const VibrationView& view, double speed, double force, int lags) {
  constexpr int kSamples = 400'000;
  Vibration vibration(7);
  std::vector<double> y(kSamples), r(static_cast<std::size_t>(lags));
  for (int i = 0; i < 2000; ++i) (void)vibration.step(view, speed, force);
  for (double& x : y) x = vibration.step(view, speed, force);
  for (std::size_t k = 0; k < r.size(); ++k) {
    for (std::size_t i = k; i < y.size(); ++i) r[k] += y[i] * y[i - k] / kSamples;
  }
  return r;
}

TEST(Vibration, SoundsAsTheModelSays) {
  // Second order, by the Yule-Walker equations: a1 = k1 (1 + k2), a2 = k2.
  const double k1 = -0.9, k2 = 0.3, power = 1;
  const double a1 = k1 * (1 + k2), r1 = -a1 / (1 + k2), r2 = -a1 * r1 - k2;
  const TestVibration t = square();
  const std::vector<double> r = heard(t.view.vibration, 0.01, 0.5, 3);
  EXPECT_NEAR(r[0], power, 0.03);
  EXPECT_NEAR(r[1], power * r1, 0.03);
  EXPECT_NEAR(r[2], power * r2, 0.03);
}

TEST(Vibration, PowerIsLinearBetweenTheModels) {
  const TestVibration t = square();
  EXPECT_NEAR(heard(t.view.vibration, 0.2, 2, 1)[0], 8, 0.3);
  EXPECT_NEAR(heard(t.view.vibration, 0.105, 0.5, 1)[0], 2.5, 0.1) << "half way along the lower edge";
  EXPECT_NEAR(heard(t.view.vibration, 0.105, 1.25, 1)[0], 3, 0.1) << "the middle of the diagonal";
  EXPECT_NEAR(heard(t.view.vibration, 5, 50, 1)[0], 8, 0.3) << "beyond the fastest and heaviest it stays";
}

TEST(Vibration, OutsideOfAllTrianglesTheNearestOneSounds) {
  // Two triangles in opposite corners of the plane; between them no model was recorded.
  TestVibration t;
  t.models = {model(0.01, 0.5, 1, {}), model(0.05, 0.5, 1, {}), model(0.01, 0.9, 1, {}),
              model(0.2, 2, 9, {}),    model(0.16, 2, 9, {}),   model(0.2, 1.6, 9, {})};
  t.triangles = {{0, 1, 2}, {3, 4, 5}};
  t.finish();
  EXPECT_NEAR(heard(t.view.vibration, 0.16, 1.7, 1)[0], 9, 0.3);
  EXPECT_NEAR(heard(t.view.vibration, 0.04, 0.8, 1)[0], 1, 0.03);
}

/** Amplitude that is heard there, of white noise: of what another with the same noise makes of unit power. */
double amplitude(const VibrationView& view, double speed, double force) {
  TestVibration unit;
  for (const auto& [v, f] : {std::pair{0.0, 0.0}, {1.0, 0.0}, {0.0, 10.0}}) unit.models.push_back(model(v, f, 1, {}));
  unit.triangles = {{0, 1, 2}};
  unit.finish();
  return Vibration(1).step(view, speed, force) / Vibration(1).step(unit.view.vibration, speed, force);
}

/** Models that leave out corners of the plane, some of them loud: round the edge of all that was recorded. */
TEST(Vibration, BeyondTheTrianglesNothingJumps) {
  const double place[6][2] = {{0.81, 0.81}, {0.52, 0.29}, {0.05, 0.38}, {0.41, 0.05}, {0.05, 1}, {0.65, 0.23}};
  TestVibration t;
  for (int i = 0; i < 6; ++i)
    t.models.push_back(model(0.3 * place[i][0], 3 * place[i][1], i == 3 || i == 5 ? 9 : 1, {}));
  t.triangles = {{0, 1, 4}, {0, 1, 5}, {1, 2, 3}, {1, 2, 4}, {1, 3, 5}};
  t.finish();
  const VibrationView& view = t.view.vibration;
  for (const VibrationModel& m : t.models) EXPECT_NEAR(amplitude(view, m.speed, m.force), std::sqrt(m.power), 1e-9);
  constexpr int kSteps = 4000;
  const auto on = [&](int side, double part) {
    const double s = view.most_speed - view.least_speed, f = view.most_force - view.least_force;
    const double x[4] = {part, 1, 1 - part, 0}, y[4] = {0, part, 1, 1 - part};
    return amplitude(view, view.least_speed + s * x[side], view.least_force + f * y[side]);
  };
  double last = on(0, 0);
  for (int i = 1; i <= 4 * kSteps; ++i) {
    const double now = on((i - 1) / kSteps, 1.0 * ((i - 1) % kSteps + 1) / kSteps);
    ASSERT_NEAR(now, last, 0.02) << i;
    last = now;
  }
}

TEST(Vibration, FadesToSilenceWithoutMotionOrForce) {
  const TestVibration t = square();
  EXPECT_NEAR(heard(t.view.vibration, 0.005, 0.5, 1)[0], 0.25, 0.01) << "half as loud at half the least speed";
  EXPECT_NEAR(heard(t.view.vibration, 0.01, 0.1, 1)[0], 0.04, 0.002) << "and a fifth at a fifth of the least force";
  Vibration vibration;
  for (int i = 0; i < 100; ++i) {
    (void)vibration.step(t.view.vibration, 0.1, 1);
    EXPECT_EQ(vibration.step(t.view.vibration, 0, 1), 0);
    EXPECT_EQ(vibration.step(t.view.vibration, 0.1, 0), 0);
  }
}

TEST(Vibration, SameSeedSameBitsOtherSeedOtherNoise) {
  const TestVibration t = square();
  Vibration a(1), b(1), c(2);
  int different = 0;
  for (int i = 0; i < 1000; ++i) {
    const double x = a.step(t.view.vibration, 0.1, 1);
    ASSERT_EQ(x, b.step(t.view.vibration, 0.1, 1));
    different += x != c.step(t.view.vibration, 0.1, 1);
  }
  EXPECT_GT(different, 900);
}

/** Models at the edge of stability, changing every tick: the lattice stays bounded. */
TEST(Vibration, StaysBoundedHoweverTheModelsChange) {
  TestVibration t = square();
  for (std::size_t i = 0; i < t.models.size(); ++i) t.models[i].reflection.fill(i % 2 == 0 ? 0.999 : -0.999);
  t.finish();
  Vibration vibration;
  double most = 0;
  for (int i = 0; i < 200'000; ++i) {
    const double y = vibration.step(t.view.vibration, 0.01 + 0.19 * (i % 7) / 6, 0.5 + 1.5 * (i % 11) / 10);
    ASSERT_TRUE(std::isfinite(y));
    most = std::max(most, std::abs(y));
  }
  EXPECT_LT(most, 100 * std::sqrt(8.0));
}

}  // namespace
}  // namespace hapticd
