/** @file
 * Measured data with known truth: whatever the apparatus adds is taken away again.
 */
#include "tools/haptic-bench/measured/measured.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <random>

#include "tests/support/process/temporary_directory.h"
#include "tests/support/seeds.h"
#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/measured/guesses.h"
#include "tools/haptic-bench/measured/synthetic.h"
#include "tools/haptic-bench/model/shapes.h"
#include "tools/haptic-bench/trajectory/geodesic.h"
#include "tools/haptic-bench/trajectory/registry.h"

namespace haptic_bench {
namespace {

using hapticd::Quat;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

/** Without any symmetry. */
Model potato() {
  Model m = sphere(0.05, 40);
  for (auto& v : m.vertices) {
    const double x = v[0], y = v[1], z = v[2];
    v[0] = static_cast<float>(1.4 * x + 0.2 * y + 3 * z * z);
    v[1] = static_cast<float>(0.8 * y + 4 * x * z);
    v[2] = static_cast<float>(z + 5 * x * y);
  }
  m.name = "potato";
  return m;
}

/** All over it, pressing with a force that changes. */
std::vector<SurfaceSample> handling(const Model& m) {
  std::vector<SurfaceSample> out = geodesic(m, {10, 2000, 1}, 0.15, 0.9, Vec3(0, 0, 1));
  for (SurfaceSample& s : out) s.force = 1.5 + std::sin(3 * s.t_s);
  return out;
}

Apparatus apparatus() {
  Apparatus a;
  a.load = {Vec3(0.3, -0.2, 0.1), 0.4};
  a.X_OM = {Vec3(0.02, -0.01, 0.3), Quat(Eigen::AngleAxisd(0.2, Vec3(1, 2, -1).normalized()))};
  return a;
}

MeasuredOptions options() {
  MeasuredOptions o;
  o.merge.tip_S = Apparatus{}.tip_S;
  o.merge.free_s = 0.95;
  o.tip_radius = Apparatus{}.tip_radius;
  o.first_guess = {Vec3(-0.02 + 0.004, 0.01, -0.3 - 0.005), Quat::Identity()};  // 11 degrees and 6 mm off.
  return o;
}

TEST(Measured, LoadIsFoundInTheAir) {
  const Recording r = record(handling(potato()), apparatus());
  const ProbeLoad load = estimateLoad(r, 0.95);
  EXPECT_NEAR(load.weight, 0.4, 1e-3);
  EXPECT_LT((load.bias_S - Vec3(0.3, -0.2, 0.1)).norm(), 1e-3);
}

TEST(Measured, NothingHangsUpwards) {
  Recording r = record(handling(potato()), apparatus());
  Recording turned = r, pulling = r;
  for (PoseSample& p : turned.poses) p.X_OS.q = Quat(p.X_OS.q.x(), p.X_OS.q.y(), p.X_OS.q.z(), p.X_OS.q.w());
  for (ForceSample& f : pulling.forces) f.f_S = -f.f_S;
  EXPECT_THAT([&] { (void)estimateLoad(pulling, 0.95); }, ThrowsMessage<Failure>(HasSubstr("pull the probe upwards")));
  EXPECT_THAT([&] { (void)estimateLoad(turned, 0.95); }, ThrowsMessage<Failure>(HasSubstr("order w x y z")));
  for (ForceSample& f : pulling.forces) f.f_S *= 0.1;
  EXPECT_NEAR(estimateLoad(pulling, 0.95).weight, -0.04, 1e-3) << "as little may be chance";
}

TEST(Measured, RegistrationFindsTheTruePose) {
  const Model m = potato();
  const Apparatus a = apparatus();
  const Measured measured = onSurface(record(handling(m), a), options(), m);
  const Pose residual = measured.registration.X_MO * a.X_OM;
  EXPECT_EQ(measured.registration.freedoms, 6);
  EXPECT_LT(residual.p.norm(), 1e-4);
  EXPECT_LT(residual.q.angularDistance(Quat::Identity()), 2e-3);
  EXPECT_LT(measured.registration.rms, 5e-5) << "60 Hz between facets";
}

TEST(Measured, ForceAndContactComeBack) {
  const Model m = potato();
  const std::vector<SurfaceSample> truth = handling(m);
  const Measured measured = onSurface(record(truth, apparatus()), options(), m);
  ASSERT_GT(measured.out.size(), 9500u);
  double force2 = 0, point2 = 0;
  for (const SurfaceSample& s : measured.out) {
    const double t = s.t_s + truth.front().t_s;
    const SurfaceSample& was = truth[std::min<std::size_t>(truth.size() - 1, static_cast<std::size_t>(t * 2000))];
    force2 += std::pow(s.force - was.force, 2);
    point2 += (s.point - was.point).squaredNorm();
  }
  EXPECT_LT(std::sqrt(force2 / static_cast<double>(measured.out.size())), 0.02);
  EXPECT_LT(std::sqrt(point2 / static_cast<double>(measured.out.size())), 5e-4);
}

TEST(Measured, SaysHowItWent) {
  const Model m = potato();
  const Apparatus a = apparatus();
  Measured measured = onSurface(record(handling(m), a), options(), m);
  EXPECT_LT((measured.load.bias_S - a.load.bias_S).norm(), 1e-3);
  EXPECT_NEAR(measured.load.weight, a.load.weight, 1e-3);
  EXPECT_GT(measured.contacts, 9500);
  EXPECT_GE(measured.points, 400);
  measured.load = {Vec3(0.1, -0.05, 0.2), 0.3};
  measured.contacts = 7;
  measured.points = 402;
  measured.out.resize(9);
  measured.registration.rms = 1.25e-5;
  measured.registration.left_out = 2;
  measured.registration.X_MO = {Vec3(0.25, -0.0625, 1), Quat(Eigen::AngleAxisd(0.5, Vec3::UnitY()))};
  EXPECT_EQ(describe(measured),
            "bias (0.1, -0.05, 0.2) N, weight 0.3 N; 7 of 9 samples in contact; 400 registered: 0.0125 mm rms off the "
            "surface, 2 left out, 6 of 6 freedoms determined; found x=0.25,y=-0.0625,z=1,turn_x=0,turn_y=0.5,turn_z=0");
  measured.points = 0;
  EXPECT_EQ(describe(measured), "bias (0.1, -0.05, 0.2) N, weight 0.3 N; 7 of 9 samples in contact, not registered");
}

TEST(Measured, NoiseIsBorne) {
  Apparatus a = apparatus();
  a.force_noise = 0.02;
  a.pose_noise = 0.0003;
  const Model m = potato();
  const Measured measured = onSurface(record(handling(m), a), options(), m);
  const Pose residual = measured.registration.X_MO * a.X_OM;
  EXPECT_LT(residual.p.norm(), 3e-4);
  EXPECT_NEAR(measured.registration.rms, 0.0003, 1e-4) << "what the tracker adds, along the normal";
}

TEST(Measured, PointsThatAreNotOnTheMeshAreLeftOut) {
  const Model m = potato();
  std::vector<Vec3> points;
  for (const SurfaceSample& s : handling(m)) {
    if (points.size() < 400 && std::fmod(s.t_s, 0.02) < 0.0005) points.push_back(s.point);
  }
  const std::size_t good = points.size();
  for (int i = 0; i < 60; ++i) points.push_back(points[static_cast<std::size_t>(i)] * 1.3);  // Where the table was hit.
  const Pose off{Vec3(0.002, -0.001, 0.001), Quat(Eigen::AngleAxisd(0.05, Vec3::UnitX()))};
  const Registration r = registerPoints(TreeNearest(m), points, 0, off);
  EXPECT_LT(r.X_MO.p.norm(), 1e-5);
  EXPECT_LT(r.X_MO.q.angularDistance(Quat::Identity()), 1e-3);
  EXPECT_TRUE(r.settled);
  EXPECT_GE(r.left_out, 60);
  EXPECT_FALSE(registerPoints(TreeNearest(m), points, 0, off, 1).settled);
  EXPECT_GT(good, 300u);
}

TEST(Measured, RegistrationSettlesInSpiteOfNoise) {
  // Half a millimetre of noise and a tenth of the points elsewhere: which of them are left out changes with the pose.
  const Model m = potato();
  const TreeNearest surface(m);
  // The last four once went round in rings of poses for ever.
  for (std::uint32_t seed : {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 334, 808, 1200, 2078}) {
    std::mt19937 random(hapticd::seedOf(seed));
    const auto one = [&random] { return 2 * (static_cast<double>(random()) / 4294967295.0) - 1; };
    const auto vector = [&] { return Vec3(one(), one(), one()); };
    std::vector<Vec3> points;
    for (int i = 0; i < 200; ++i) {
      const Vec3 p = m.vertex(random() % static_cast<std::uint32_t>(m.vertices.size())) + 0.0009 * vector();
      points.push_back(i % 10 == 0 ? Vec3(1.1 * p) : p);
    }
    const Pose off{0.003 * vector(), Quat(Eigen::AngleAxisd(0.08, vector().normalized()))};
    const Registration r = registerPoints(surface, points, 0, off);
    EXPECT_LT(r.X_MO.p.norm(), 5e-4) << seed;
    EXPECT_TRUE(r.settled) << seed;
    EXPECT_LT(r.rounds, 150) << seed;
  }
}

TEST(Measured, AFirstGuessThatLeadsAstrayIsLeft) {
  const Model m = potato();
  const Apparatus a = apparatus();
  const Recording r = record(handling(m), a);
  int lost = 0;
  for (const Pose& off : {Pose{Vec3::Zero(), Quat(Eigen::AngleAxisd(3, Vec3::UnitX()))},
                          Pose{Vec3::Zero(), Quat(Eigen::AngleAxisd(2, Vec3(1, 1, 0).normalized()))},
                          Pose{Vec3(0.05, -0.04, 0.03), Quat(Eigen::AngleAxisd(1.5, Vec3::UnitZ()))},
                          Pose{Vec3(1, 0, 0), Quat(Eigen::AngleAxisd(3, Vec3::UnitY()))}}) {
    MeasuredOptions o = options();
    o.first_guess = off * a.X_OM.inverse();
    const Measured measured = onSurface(r, o, m);
    const Pose residual = measured.registration.X_MO * a.X_OM;
    EXPECT_LT(residual.p.norm(), 1e-4) << off.p.transpose();
    EXPECT_LT(residual.q.angularDistance(Quat::Identity()), 2e-3);
    const bool told = describe(measured).find("; not from the first guess, ") != std::string::npos;
    EXPECT_EQ(told, measured.registration.guess_lost);
    lost += told ? 1 : 0;
  }
  EXPECT_GE(lost, 2);
  const Measured measured = onSurface(r, options(), m);
  EXPECT_FALSE(measured.registration.guess_lost);
  EXPECT_EQ(measured.registration.as_near, 0);
}

TEST(Measured, PointsThatLieOnNothingOfTheMeshSettleOrAreRefused) {
  const Model m = sphere(0.05, 6);
  const Eigen::AlignedBox3d box(Vec3::Constant(-0.05), Vec3::Constant(0.05));
  std::mt19937 random(hapticd::seedOf(1));
  std::normal_distribution<double> anywhere(0, 0.03);
  int refused = 0;
  for (int i = 0; i < 20; ++i) {
    std::vector<Vec3> points(40);
    for (Vec3& p : points) p = {anywhere(random), anywhere(random), anywhere(random)};
    try {
      EXPECT_TRUE(registerFromSeveral(TreeNearest(m), box, points, 0, {}).settled);
    } catch (const Failure& failure) {
      EXPECT_THAT(failure.what(), HasSubstr("registration: it does not settle; the points are 0.0"));
      ++refused;
    }
  }
  EXPECT_GE(refused, 1);
}

TEST(Measured, OfPlacesThatAreAlikeTheFirstGuessIsKept) {
  Model m = sphere(0.05, 40);  // Three axes of different lengths: half a turn about each changes nothing.
  for (auto& v : m.vertices) v[0] *= 1.4F, v[2] *= 0.7F;
  const Apparatus a = apparatus();
  MeasuredOptions o = options();
  const Measured measured = onSurface(record(handling(m), a), o, m);
  const Pose residual = measured.registration.X_MO * a.X_OM;
  EXPECT_LT(residual.q.angularDistance(Quat::Identity()), 2e-3);
  EXPECT_EQ(measured.registration.as_near, 3);
  EXPECT_FALSE(measured.registration.guess_lost);
  EXPECT_THAT(describe(measured), HasSubstr("; as near in 3 other places at least: the first guess decides; found"));
}

TEST(Measured, APlaneIsRegisteredInThreeDirectionsAndKeepsTheGuessInTheOthers) {
  const Model m = plane(0.05, 3);
  Apparatus a;
  a.X_OM = {Vec3(0.003, -0.002, 0.01), Quat(Eigen::AngleAxisd(0.1, Vec3::UnitX()))};
  MeasuredOptions o = options();
  o.first_guess = {};
  const Measured measured = onSurface(record(lissajous(m, {10, 2000, 1}), a), o, m);
  EXPECT_EQ(measured.registration.freedoms, 3);
  EXPECT_LT(measured.registration.rms, 2e-5);
  for (const SurfaceSample& s : measured.out) ASSERT_NEAR(s.point.z(), 0, 2e-4);
}

/** The same with times `scale` times as long, `later`. */
Recording retimed(Recording r, double scale, double later) {
  for (ForceSample& f : r.forces) f.t_s = scale * f.t_s + later;
  for (PoseSample& p : r.poses) p.t_s = scale * p.t_s + later;
  return r;
}

TEST(Measured, SamplesAreEvenInSecondsSince1970) {
  const Recording r = record(lissajous(plane(0.05, 3), {2, 2000, 1}), {});
  const std::vector<ProbeSample> merged = merge(retimed(r, 1, 1.7e9), {});
  EXPECT_EQ(merged.size(), merge(r, {}).size());
  EXPECT_NEAR(merged.back().t_s - merged.front().t_s, 1e-3 * static_cast<double>(merged.size() - 1), 1e-6);
}

TEST(Measured, TimesInAnotherUnitDoNotGoOnForEver) {
  const Recording r = record(lissajous(plane(0.05, 3), {2, 2000, 1}), {});
  for (const double scale : {1e6, 1e9}) {  // Microseconds and nanoseconds in a column t.
    EXPECT_THAT([&] { (void)merge(retimed(r, scale, 0), {}); },
                ThrowsMessage<Failure>(HasSubstr("at 1000 Hz are too many samples (at most 1e+07: name the column of")))
        << scale;
  }
}

TEST(Measured, IsReadFromTwoFiles) {
  const Model m = plane(0.05, 3);
  const Recording r = record(lissajous(m, {2, 2000, 1}), {});
  const hapticd::test::TemporaryDirectory directory;
  const std::string forces = directory.path() + "/f.csv", poses = directory.path() + "/p.csv";
  {
    std::ofstream f(forces), p(poses);
    f << "t,fx,fy,fz\n";
    for (const ForceSample& s : r.forces) f << fmt::format("{},{},{},{}\n", s.t_s, s.f_S.x(), s.f_S.y(), s.f_S.z());
    // The object turns: what is relative to it stays.
    p << "t_ms,x,y,z,qw,qx,qy,qz,object_x,object_y,object_z,object_qw,object_qx,object_qy,object_qz\n";
    for (const PoseSample& s : r.poses) {
      const Pose X_WO{Vec3(0.1, 0, s.t_s * 0.01), Quat(Eigen::AngleAxisd(0.2 * s.t_s, Vec3::UnitZ()))};
      const Pose X = X_WO * s.X_OS;
      p << fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", 1000 * s.t_s, X.p.x(), X.p.y(), X.p.z(),
                       X.q.w(), X.q.x(), X.q.y(), X.q.z(), X_WO.p.x(), X_WO.p.y(), X_WO.p.z(), X_WO.q.w(), X_WO.q.x(),
                       X_WO.q.y(), X_WO.q.z());
    }
  }
  const std::string spec =
      fmt::format("measured:forces={},poses={},tip_z=0.1,tip_radius=0.0015,free=0.95", forces, poses);
  const Trajectory in = makeTrajectory(spec, m, {1000});
  ASSERT_GT(in.samples.size(), 1900u);
  for (std::size_t i = 100; i < in.samples.size(); ++i) {
    ASSERT_NEAR(in.samples[i].force.z(), 1, 0.01);
    ASSERT_NEAR(in.samples[i].hip.z(), -0.001, 2e-4);
  }
  EXPECT_THROW((void)makeTrajectory(spec + ",colour=red", m, {1000}), Failure);
  EXPECT_THROW((void)makeTrajectory(spec + ",weight=0.3", m, {1000}), Failure) << "it is found";
  std::ofstream(poses, std::ios::app) << "6000,0,0,0,1,0,0,0,0,0,0,1,0,0,0\n";
  EXPECT_THROW((void)makeTrajectory(spec, m, {1000}), Failure) << "a gap";
  EXPECT_GT(makeTrajectory(spec + ",max_gap=5", m, {1000}).samples.size(), 1900u);
  EXPECT_THROW((void)makeTrajectory("measured:forces=" + forces, m, {1000}), Failure);
  EXPECT_THROW((void)makeTrajectory(spec + ",max_gap=5,clock=100", m, {1000}), Failure) << "they share no time then";
}

TEST(Measured, BetweenTwoStrokesTheHandGoesThroughTheAir) {
  // Over the north pole, lifted by 20 mm to the equator, and along that.
  const Model m = sphere(0.05, 60);
  std::vector<SurfaceSample> out;
  for (int i = 0; i < 6000; ++i) {
    const double t = i / 2000.0, polar = 0.1 * t + 1.2 * std::clamp(t - 1, 0.0, 1.0);
    const double lift = 0.02 * std::clamp(std::min(t - 1, 2 - t) * 10, 0.0, 1.0);
    const Vec3 n(std::sin(polar), 0, std::cos(polar));
    out.push_back({t, (0.05 + lift) * n, n, lift > 0 ? 0.0 : 1.0});
  }
  MeasuredOptions o = options();
  o.registered = true;
  o.first_guess = {};
  Apparatus a;
  const Trajectory in = pressInto(onSurface(record(out, a), o, m).out, {1000});
  ASSERT_GT(in.samples.size(), 2900u);
  double highest = 0;
  for (std::size_t i = 1; i < in.samples.size(); ++i) {
    ASSERT_LT((in.samples[i].hip - in.samples[i - 1].hip).norm(), 2e-3) << in.samples[i].t_s;
    highest = std::max(highest, in.samples[i].hip.norm());
    if (in.samples[i].hip.norm() > 0.06) {
      ASSERT_EQ(in.samples[i].force, Vec3(Vec3::Zero()));
    }
  }
  EXPECT_NEAR(highest, 0.07, 1e-3);
}

TEST(Measured, ClocksThatDisagreeAreTold) {
  const Model m = potato();
  for (const double lag : {0.0, 0.004, 0.02, -0.05}) {
    Apparatus a = apparatus();
    a.force_noise = 0.005;
    Recording r = record(handling(m), a);
    for (PoseSample& p : r.poses) p.t_s += lag;
    const Measured measured = onSurface(r, options(), m);
    EXPECT_NEAR(measured.lag.lag_s, lag, 5 * measured.lag.deviation_s) << lag;
    EXPECT_LT(measured.lag.deviation_s, 1e-3) << lag;
    EXPECT_GT(measured.lag.deviation_s, 1e-5) << lag;
    EXPECT_EQ(describe(measured).find("clock=") != std::string::npos, lag != 0) << describe(measured);
    EXPECT_EQ(describe(measured).find(" late ") != std::string::npos, lag > 0) << describe(measured);
  }
  Recording still = record(handling(m), apparatus());
  for (PoseSample& p : still.poses) p.X_OS.q = still.poses[0].X_OS.q;
  EXPECT_EQ(estimateLag(still, 0.95).deviation_s, 0) << "it does not turn";
}

// It was counted from the later of both streams: of poses that were 25 ms late it told 35.
TEST(Measured, TheFreeTimeIsThatOfTheForces) {
  const Model m = potato();
  MeasuredOptions o = options();
  o.merge.free_s = Apparatus{}.free_s;  // To the last of it.
  Recording r = record(handling(m), apparatus());
  for (PoseSample& p : r.poses) p.t_s += 0.025;
  EXPECT_NEAR(onSurface(r, o, m).lag.lag_s, 0.025, 1e-3);

  r = record(handling(m), apparatus());
  std::erase_if(r.poses, [](const PoseSample& p) { return p.t_s < 0.4; });
  const ProbeLoad load = onSurface(r, o, m).load;
  EXPECT_NEAR(load.weight, 0.4, 2e-3);
  EXPECT_LT((load.bias_S - Vec3(0.3, -0.2, 0.1)).norm(), 2e-3);

  std::erase_if(r.poses, [](const PoseSample& p) { return p.t_s < 1.1; });
  EXPECT_THAT([&] { (void)onSurface(r, o, m); }, ThrowsMessage<Failure>(HasSubstr("a free time that both have")));
}

TEST(Measured, TheClockToTryIsTheWholeOfIt) {
  const Model m = potato();
  Recording r = record(handling(m), apparatus());
  for (PoseSample& p : r.poses) p.t_s += 0.02;
  for (const double given : {0.0, 0.03, -1.7e9}) {  // The last one brings seconds since 1970 to those of the forces.
    MeasuredOptions o = options();
    o.clock_s = given;
    const Measured measured = onSurface(r, o, m);
    const std::string words = describe(measured);
    const std::size_t at = words.find("clock=");
    ASSERT_NE(at, std::string::npos) << words;
    EXPECT_NEAR(std::stod(words.substr(at + 6)) - given, -0.02, 1e-3) << words;
  }
}

TEST(Measured, ForcesOfTheWrongSignAreRefused) {
  const Model m = potato();
  Recording r = record(handling(m), apparatus());
  for (ForceSample& f : r.forces) f.f_S = -f.f_S;
  EXPECT_THAT([&] { (void)onSurface(r, options(), m); }, ThrowsMessage<Failure>(HasSubstr("change their sign")));
}

TEST(Measured, WhatItFoundIsAFirstGuessThatNeedsNoOther) {
  const Model m = potato();
  const Recording r = record(handling(m), apparatus());
  const Measured measured = onSurface(r, options(), m);
  const std::string words = describe(measured);
  MeasuredOptions again = options();
  const std::size_t at = words.find("found ");
  ASSERT_NE(at, std::string::npos) << words;
  Spec spec("measured:" + words.substr(at + 6));
  again.first_guess = placement(spec);
  again.registered = true;
  const Measured same = onSurface(r, again, m);
  EXPECT_LT((same.registration.X_MO.p - measured.registration.X_MO.p).norm(), 1e-6);
  EXPECT_LT(same.registration.X_MO.q.angularDistance(measured.registration.X_MO.q), 1e-5);
  ASSERT_EQ(same.out.size(), measured.out.size());
  EXPECT_LT((same.out[5000].point - measured.out[5000].point).norm(), 2e-6);
}

TEST(Measured, ContactsThatLieNowhereNearTheMeshAreRefused) {
  const Model m = potato();
  MeasuredOptions wrong = options();
  wrong.merge.tip_S = Vec3::Zero();  // The sensor's own origin, 10 cm from the tip that touches.
  Recording r = record(handling(m), apparatus());
  EXPECT_THAT([&] { (void)onSurface(r, wrong, m); },
              ThrowsMessage<Failure>(HasSubstr(" mm rms off the surface of a mesh of ")));

  MeasuredOptions elsewhere = options();
  elsewhere.registered = true;
  elsewhere.first_guess = apparatus().X_OM.inverse();
  EXPECT_NO_THROW((void)onSurface(r, elsewhere, m));
  elsewhere.first_guess.p.z() += 0.5;  // Nothing that a registration would mend is mended then.
  EXPECT_THAT([&] { (void)onSurface(r, elsewhere, m); },
              ThrowsMessage<Failure>(HasSubstr("which registered=1 takes as they are")));
}

TEST(Measured, UnitsThatNoHandSurvivesAreNamedWithTheirLine) {
  const hapticd::test::TemporaryDirectory directory;
  const std::string forces = directory.path() + "/f.csv", poses = directory.path() + "/p.csv";
  const auto refusal = [&](double force, double place) -> std::string {
    std::ofstream(forces) << "t,fx,fy,fz\n0,0,0,1\n1,0,0," << force << "\n";
    std::ofstream(poses) << "t,x,y,z,qw,qx,qy,qz\n0,0,0,0,1,0,0,0\n1,0," << place << ",0,1,0,0,0\n";
    try {
      (void)readRecording(forces, poses);
    } catch (const Failure& failure) {
      return failure.what();
    }
    return "";
  };
  EXPECT_EQ(refusal(1, 1), "");
  EXPECT_EQ(refusal(2e6, 1), forces + ", line 3: the force is 2e+06 N (name the column with its unit, as fx_mN)");
  EXPECT_EQ(refusal(1, 250), poses +
                                 ", line 3: the position is 250 m away (at most 100 m: name the column with its "
                                 "unit, as x_mm)");
}

TEST(Measured, FaultsAreNamed) {
  Recording r = record(lissajous(plane(0.05, 3), {1, 2000, 1}), {});
  for (ForceSample& f : r.forces) f.t_s += 100;
  EXPECT_THAT([&] { (void)merge(r, {}); }, ThrowsMessage<Failure>(HasSubstr("one clock")));
  EXPECT_THROW((void)registerPoints(TreeNearest(plane(1, 1)), {Vec3(0, 0, 0)}, 0, {}), Failure);
}

TEST(Geodesics, AreGreatCirclesOnASphereAndStraightOnAPlane) {
  const Model ball = sphere(0.05, 64);
  const std::vector<SurfaceSample> around = geodesic(ball, {EIGEN_PI, 1000, 1}, 0.1, 0.3, Vec3(0.05, 0, 0.003));
  const Vec3 axis = around.front().point.cross(around[300].point).normalized();
  for (const SurfaceSample& s : around) {
    ASSERT_NEAR(s.point.norm(), 0.05, 1e-4);
    ASSERT_NEAR(s.point.dot(axis), 0, 1e-3) << s.t_s;
    ASSERT_GT(s.normal.dot(s.point.normalized()), 0.999);
  }
  EXPECT_LT((around.back().point - around.front().point).norm(), 1e-3) << "once around: 2 pi R at 0.1 m/s";

  const std::vector<SurfaceSample> line = geodesic(plane(0.05, 7), {0.3, 1000, 1}, 0.1, 0.3, Vec3(0, 0, 0));
  for (const SurfaceSample& s : line) {
    const Vec3 gone = s.point - line.front().point;
    ASSERT_NEAR(gone.norm(), 0.1 * s.t_s, 1e-6);
    ASSERT_NEAR(gone.cross(Vec3(std::cos(0.3), std::sin(0.3), 0)).norm(), 0, 1e-6);
  }
  for (const SurfaceSample& s : geodesic(plane(0.05, 7), {5, 100, 1}, 0.3, 0.3, Vec3(0, 0, 0))) {
    ASSERT_LE(s.point.cwiseAbs().maxCoeff(), 0.0501) << "turns back at the border";
  }
}

}  // namespace
}  // namespace haptic_bench
