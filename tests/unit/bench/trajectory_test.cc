/** @file
 * Generators: what they say of the truth holds on the surface they run over.
 */
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/model/shapes.h"
#include "tools/haptic-bench/trajectory/generators.h"
#include "tools/haptic-bench/trajectory/geodesic.h"
#include "tools/haptic-bench/trajectory/registry.h"

namespace haptic_bench {
namespace {

using ::testing::HasSubstr;

TEST(Trajectories, PressedInTheyFeelTheForceAtTheStiffness) {
  const Model model = makeModel("sphere:radius=0.001");
  const Trajectory in = makeTrajectory("spiral:force=1,seconds=2", model, {2000});
  ASSERT_EQ(in.samples.size(), 2000u);
  EXPECT_DOUBLE_EQ(in.period_s(), 0.001);
  for (const Sample& s : in.samples) {
    ASSERT_NEAR(s.proxy.norm(), 0.001, 1e-15);
    ASSERT_NEAR(s.hip.norm(), 0.0005, 1e-15) << "1 N at 2000 N/m";
    ASSERT_LT((s.force - 2000 * (s.proxy - s.hip)).norm(), 1e-12);
    ASSERT_GT(s.force.dot(s.proxy), 0);
  }
  EXPECT_GT(in.start.norm(), 0.001);
}

TEST(Trajectories, FollowTheCurvesThatTheyPromise) {
  /** Of sample i of n, as a share of the way. */
  const auto share = [](std::size_t i, const Trajectory& in) {
    return (static_cast<double>(i) + 0.5) / static_cast<double>(in.samples.size());
  };
  const Trajectory around = makeTrajectory("spiral:turns=3,seconds=1", makeModel("sphere:radius=0.05"), {1000});
  for (std::size_t i = 0; i < around.samples.size(); ++i) {
    const double polar = EIGEN_PI * share(i, around), azimuth = 6 * polar;
    const Vec3 n(std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth), std::cos(polar));
    ASSERT_LT((around.samples[i].proxy - 0.05 * n).norm(), 1e-12) << i;
  }

  const Model flat = makeModel("plane");
  const Trajectory figure = makeTrajectory("lissajous:seconds=1", flat, {1000});
  for (std::size_t i = 0; i < figure.samples.size(); ++i) {
    const double phase = 2 * EIGEN_PI * share(i, figure);
    const Vec3 p(std::sin(3 * phase), std::sin(2 * phase), 0);
    ASSERT_LT((figure.samples[i].proxy - flat.half / 2 * p).norm(), 1e-12) << i;
  }

  const Trajectory straight = makeTrajectory("reach:tremor=0,seconds=9,force=5", flat, {1000});
  for (std::size_t i = 0; i < straight.samples.size(); ++i) {
    const double t = std::fmod((static_cast<double>(i) + 0.5) / 1000, 4), tau = (t < 2 ? t : 4 - t) / 2;
    const double way = 10 * std::pow(tau, 3) - 15 * std::pow(tau, 4) + 6 * std::pow(tau, 5);  // Flash and Hogan 1985.
    ASSERT_LT((straight.samples[i].proxy - flat.half * (way - 0.5) * Vec3(1, 0.7, 0)).norm(), 1e-12) << i;
    ASSERT_EQ(straight.samples[i].force, Vec3(0, 0, 5));
  }
}

TEST(Trajectories, ThePressedHandLiesBehindItsPoint) {
  const Surface surface{500, 0, 0.6, 0.4, 0.01};
  // Climbing, straight up, and on: friction is against what lies along the surface.
  const std::vector<SurfaceSample> out{{0, Vec3(0, 0, 0), Vec3::UnitZ(), 2},
                                       {1, Vec3(0, 1, 1), Vec3::UnitZ(), 2},
                                       {2, Vec3(0, 1, 2), Vec3::UnitZ(), 3},
                                       {3, Vec3(1, 1, 2), Vec3::UnitZ(), 3}};
  const Vec3 forces[] = {{0, -0.8, 2}, {0, -0.8, 2}, {0, 0, 3}, {-1.2, 0, 3}};
  const Trajectory in = pressInto(out, surface);
  ASSERT_EQ(in.samples.size(), out.size());
  EXPECT_TRUE(in.force_known && in.proxy_known);
  for (std::size_t i = 0; i < out.size(); ++i) {
    EXPECT_EQ(in.samples[i].t_s, out[i].t_s);
    EXPECT_LT((in.samples[i].force - forces[i]).norm(), 1e-15) << i;
    EXPECT_LT((in.samples[i].proxy - out[i].point - Vec3(0, 0, 0.01)).norm(), 1e-15) << "a radius outside";
    EXPECT_LT((in.samples[i].proxy - in.samples[i].hip - forces[i] / 500).norm(), 1e-15) << i;
  }
  EXPECT_LT((in.start - Vec3(0, 0, 0.01 + 2.0 / 500)).norm(), 1e-15);
  EXPECT_EQ(pressInto({out[0]}, surface).samples[0].force, Vec3(0, 0, 2)) << "one alone slides nowhere";
  EXPECT_EQ(pressInto(out, {500}).samples[1].force, Vec3(0, 0, 2));
}

TEST(Trajectories, ThePeriodIsTheMiddleStep) {
  Trajectory way;
  for (const double t : {1.0, 2.0, 3.0, 13.0, 17.0, 18.5}) way.samples.emplace_back().t_s = t;
  EXPECT_EQ(way.period_s(), 1.5);
  way.samples.resize(2);
  EXPECT_EQ(way.period_s(), 1);
  way.samples.resize(1);
  EXPECT_EQ(way.period_s(), 1e-3);
}

TEST(Trajectories, FrictionDragsTheHandBehindAtTheAngleOfTheCone) {
  const Trajectory in = makeTrajectory("lissajous:seconds=4", makeModel("plane"), {1000, 0, 0.6, 0.4});
  for (std::size_t i = 1; i < in.samples.size(); ++i) {
    const Sample& s = in.samples[i];
    const Vec3 slide = s.proxy - in.samples[i - 1].proxy;
    ASSERT_NEAR(s.force.z(), 1, 1e-12);
    ASSERT_NEAR(s.force.dot(slide.normalized()), -0.4, 1e-9) << "against the motion";
    ASSERT_LT((s.force - 1000 * (s.proxy - s.hip)).norm(), 1e-12);
  }
}

TEST(Trajectories, OfOtherSpeedsMoveEvenly) {
  Trajectory way;  // 1 m/s, one sample missing.
  for (const int i : {0, 1, 2, 3, 4, 6, 7, 8, 9, 10, 11, 12}) {
    way.samples.push_back({5 + 0.001 * i, Vec3(0.001 * i, 0, 0), Vec3(0, 0.001 * i, 0), Vec3(0, 0, 0.001 * i)});
  }
  for (const double factor : {0.1, 0.7, 1.0, 1.5, 2.0, 2.5, 12.0, 13.0}) {
    const Trajectory made = atSpeed(way, factor);
    ASSERT_EQ(made.samples.size(), static_cast<std::size_t>(12 / factor + 1e-9) + 1) << factor;
    for (std::size_t i = 0; i < made.samples.size(); ++i) {
      const double at = 0.001 * factor * static_cast<double>(i);
      ASSERT_NEAR(made.samples[i].t_s, 0.001 * static_cast<double>(i), 1e-12);
      ASSERT_LT((made.samples[i].hip - Vec3(at, 0, 0)).norm(), 1e-9) << factor << " times, sample " << i;
      ASSERT_LT((made.samples[i].proxy - Vec3(0, at, 0)).norm(), 1e-9);
      ASSERT_LT((made.samples[i].force - Vec3(0, 0, at)).norm(), 1e-9);
    }
  }
}

TEST(Trajectories, BetweenSamplesOfWhichOneIsNotJudgedNothingIs) {
  Trajectory way;
  for (int i = 0; i < 6; ++i) way.samples.push_back({0.001 * i, Vec3(i, 0, 0), {}, {}, i != 3});
  const Trajectory made = atSpeed(way, 0.5);
  ASSERT_EQ(made.samples.size(), 11u);
  for (std::size_t i = 0; i < 11; ++i) EXPECT_EQ(made.samples[i].judged, i < 5 || i > 7) << i;
  EXPECT_EQ(atSpeed(way, 5 * (1 + 5e-7)).samples.back().hip, Vec3(5, 0, 0)) << "rounded to the last one";
}

TEST(Trajectories, FasterByWholeFactorsKeepsTheSamples) {
  Trajectory way = makeTrajectory("spiral:seconds=60", makeModel("sphere"), {1000});
  for (Sample& s : way.samples) s.t_s += 2000;  // Steps are rounded then.
  const Trajectory made = atSpeed(way, 3);
  ASSERT_EQ(made.samples.size(), 20000u);
  for (std::size_t i = 0; i < made.samples.size(); ++i) ASSERT_EQ(made.samples[i].hip, way.samples[3 * i].hip) << i;
}

TEST(Trajectories, FasterOverAGapOfYearsIsRefused) {
  Trajectory way;
  for (const double t : {0.0, 1e-6, 2e-6, 3e-6, 1e6}) way.samples.emplace_back().t_s = t;
  EXPECT_THROW((void)atSpeed(way, 2), Failure);
}

TEST(Trajectories, ProfileRunsByArcLength) {
  const Model model = makeModel("ridge:degrees=75");
  const Trajectory in = makeTrajectory("profile", model, {1000});
  const double angle = 75 * EIGEN_PI / 180, flank = 0.005 / std::sin(angle), foot = 0.005 / std::tan(angle);
  EXPECT_NEAR(in.duration_s(), (0.06 - 2 * foot + 2 * flank) / 0.02, 0.003);
  EXPECT_NEAR(in.samples.front().proxy.x(), -0.03, 2e-5);
  EXPECT_NEAR(in.samples.back().proxy.x(), 0.03, 4e-5);
  double top = 0;
  for (std::size_t i = 1; i < in.samples.size(); ++i) {
    const double step = (in.samples[i].proxy - in.samples[i - 1].proxy).norm();
    ASSERT_LT(step, 2.0000001e-5);  // Shorter only around a corner.
    const Vec3& p = in.samples[i].proxy;
    ASSERT_NEAR(p.z(), std::max(0.0, 0.005 - std::abs(p.x()) * std::tan(angle)), 1e-12);
    const double side = p.z() > 0 ? std::copysign(std::sin(angle), p.x()) : 0;
    ASSERT_LT((in.samples[i].force - Vec3(side, 0, std::sqrt(1 - side * side))).norm(), 1e-12) << "the face's normal";
    ASSERT_EQ(p.y(), 0.0123);
    top = std::max(top, in.samples[i].proxy.z());
  }
  EXPECT_NEAR(top, 0.005, 2e-5);
}

TEST(Trajectories, AWayThatIsShorterThanAStepIsNotLeft) {
  const Trajectory in = makeTrajectory("profile:speed=10,rate=1", makeModel("ridge"), {1000});
  ASSERT_EQ(in.samples.size(), 1u);
  EXPECT_NEAR(in.samples[0].proxy.x(), 0.03, 1e-12) << "its end";
  EXPECT_NEAR(makeTrajectory("spiral:seconds=0.01,rate=1", makeModel("sphere"), {1000}).samples[0].proxy.z(), -0.05,
              1e-12);
}

TEST(Trajectories, SwingStaysInTheBowlAndRests) {
  const Model model = makeModel("bowl");
  const Trajectory in = makeTrajectory("swing:seconds=3", model, {1000});
  double fastest = 0;
  const double most = 0.8 * model.half / 0.05;  // An angle from the bottom.
  for (std::size_t i = 0; i < in.samples.size(); ++i) {
    ASSERT_NEAR((in.samples[i].proxy - Vec3(0, 0, 0.05)).norm(), 0.05, 1e-12);
    const double angle = most * std::sin(std::min(1e-3 * (static_cast<double>(i) + 0.5), 2.7) * 0.1 / (0.05 * most));
    const Vec3 along(0.8, 0.6, 0);
    ASSERT_LT((in.samples[i].proxy - 0.05 * (std::sin(angle) * along + Vec3(0, 0, 1 - std::cos(angle)))).norm(), 1e-12);
    ASSERT_NEAR((in.samples[i].hip - Vec3(0, 0, 0.05)).norm(), 0.051, 1e-12) << "deeper, into the solid";
    if (i > 0) fastest = std::max(fastest, (in.samples[i].proxy - in.samples[i - 1].proxy).norm() * 1000);
  }
  EXPECT_NEAR(fastest, 0.1, 1e-3);
  EXPECT_EQ(in.samples[2990].hip, in.samples[2800].hip);
}

TEST(Trajectories, TremorHasItsAmplitudeAndBand) {
  const Model model = makeModel("plane");
  const Trajectory still = makeTrajectory("reach:tremor=0,force=5", model, {1000});
  const Trajectory shaken = makeTrajectory("reach:tremor=0.0002,seed=7,force=5", model, {1000});
  const Trajectory same = makeTrajectory("reach:tremor=0.0002,seed=7,force=5", model, {1000});
  double sum = 0, in_band = 0, at_all = 0;
  for (std::size_t i = 0; i < still.samples.size(); ++i) {
    const Vec3 shake = shaken.samples[i].hip - still.samples[i].hip;
    sum += shake.squaredNorm() / 3;
    ASSERT_EQ(shaken.samples[i].hip, same.samples[i].hip);
    ASSERT_NEAR(shaken.samples[i].force.z(), 5 - 1000 * shake.z(), 1e-9) << "deeper is more force";
  }
  const double n = static_cast<double>(still.samples.size());
  EXPECT_NEAR(std::sqrt(sum / n), 0.0002, 0.00002);
  for (int hz10 = 1; hz10 < 300; ++hz10) {  // A discrete Fourier transform of x, in tenths of a hertz: 10 s.
    double re = 0, im = 0;
    for (std::size_t i = 0; i < still.samples.size(); ++i) {
      const double x = shaken.samples[i].hip.x() - still.samples[i].hip.x();
      re += x * std::cos(2 * EIGEN_PI * hz10 / 10 * 0.001 * static_cast<double>(i));
      im += x * std::sin(2 * EIGEN_PI * hz10 / 10 * 0.001 * static_cast<double>(i));
    }
    (hz10 >= 78 && hz10 <= 122 ? in_band : at_all) += re * re + im * im;
  }
  EXPECT_GT(in_band, 20 * at_all);
}

TEST(Trajectories, ATremorThatLiftsTheHandOffLetsItHover) {
  const Model model = makeModel("plane");
  const Trajectory firm = makeTrajectory("reach:tremor=0.0005,force=100,seconds=4", model, {3000});
  const Trajectory light = makeTrajectory("reach:tremor=0.0005,force=0.3,seconds=4", model, {3000});
  int above = 0;
  for (std::size_t i = 0; i < light.samples.size(); ++i) {
    const Sample& s = light.samples[i];
    ASSERT_NEAR(s.hip.z(), firm.samples[i].hip.z() + 99.7 / 3000, 1e-12) << "the same tremor";
    if (s.hip.z() <= 0) continue;
    ++above;
    ASSERT_EQ(s.force, Vec3(Vec3::Zero()));
    ASSERT_EQ(s.proxy, s.hip);
  }
  EXPECT_GT(above, 1000);
}

// Beyond the plane nothing is felt, and the best algorithm was off by 58 N^2.
TEST(Trajectories, ATremorDoesNotLeaveThePlane) {
  EXPECT_THROW((void)makeTrajectory("reach:tremor=0.01,seconds=4", makeModel("plane:half=0.001"), {1000}), Failure);
  const Model plane = makeModel("plane:half=0.05");
  for (const Sample& s : makeTrajectory("reach:tremor=0.01,seconds=4", plane, {1000}).samples)
    ASSERT_LE(s.proxy.head<2>().cwiseAbs().maxCoeff(), plane.half);
}

TEST(Trajectories, RoundingTakesNoSample) {
  const Model model = makeModel("plane");
  for (const auto& [seconds, rate, samples] :
       {std::tuple{1.001, 1000, 1001u}, {8.2, 1000, 8200u}, {0.29, 100, 29u}, {0.2955, 1000, 295u}}) {
    const Pace pace{seconds, static_cast<double>(rate), 1};
    EXPECT_EQ(samplesIn(seconds, pace), samples);
    EXPECT_EQ(lissajous(model, pace).size(), samples);
  }
  EXPECT_EQ(samplesIn(kMaxSamples, {0, 1, 1}), static_cast<std::size_t>(kMaxSamples));
  EXPECT_THROW((void)samplesIn(kMaxSamples + 1, {0, 1, 1}), Failure);
}

TEST(Trajectories, AStrokeOverATwoSidedSheetHasTheNormalOfItsFacet) {
  Model sheet = plane(0.05, 3);
  const auto above = sheet.triangles;
  for (const auto& v : above) sheet.triangles.push_back({v[2], v[1], v[0]});
  for (const SurfaceSample& s : geodesic(sheet, {1, 1000, 1}, 0.1, 0.5, Vec3(0, 0, 1)))
    ASSERT_NEAR(std::abs(s.normal.z()), 1, 1e-12) << "the normals of its vertices cancel";
}

// The truth of a thin model was pressed through its middle without a word, where the exact nearest point is off by 1 N.
TEST(Trajectories, WhereAnotherSideIsNearerIsTold) {
  const auto told = [](const char* model, const char* way) {
    testing::internal::CaptureStderr();
    (void)makeTrajectory(way, makeModel(model), {1000});
    return testing::internal::GetCapturedStderr();
  };
  EXPECT_THAT(told("sphere:radius=0.0005", "geodesic:seconds=0.1,speed=0.01"),
              HasSubstr("at 100 of 100 samples another side of sphere:radius=0.0005 is nearer"));
  EXPECT_EQ(told("sphere:radius=0.01", "geodesic:seconds=0.1"), "");
  EXPECT_EQ(told("plane", "geodesic:seconds=0.1"), "");
}

TEST(Trajectories, FaultsAreNamed) {
  const Model model = makeModel("plane");
  for (const char* spec : {"spiral", "walk", "lissajous:force=-1", "lissajous:turns=3", "reach:seed=0.5"}) {
    EXPECT_THROW((void)makeTrajectory(spec, model, {1000}), Failure) << spec;
  }
  EXPECT_THROW((void)makeTrajectory("profile:length=0.2", makeModel("ridge"), {1000}), Failure) << "off the plane";
  EXPECT_THROW((void)makeTrajectory("profile:y=-0.06", makeModel("ridge"), {1000}), Failure) << "beside it";
  EXPECT_THROW((void)makeTrajectory("profile:length=0.001", makeModel("ridge"), {1000}), Failure) << "on the ridge";
}

}  // namespace
}  // namespace haptic_bench
