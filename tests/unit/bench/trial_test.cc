/** @file
 * The harness against published figures and closed forms.
 */
#include "tools/haptic-bench/trial/trial.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "tools/haptic-bench/algorithm/registry.h"
#include "tools/haptic-bench/failure.h"
#include "tools/haptic-bench/trajectory/registry.h"

namespace haptic_bench {
namespace {

double mse(const std::string& algorithm, const std::string& model_spec, const std::string& trajectory_spec,
           double stiffness = 1000) {
  const Model model = makeModel(model_spec);
  const Trajectory trajectory = makeTrajectory(trajectory_spec, model, {stiffness});
  return judge(trajectory, runTrial(algorithm, model, trajectory, {stiffness}, 1).answers, 1e-3).force_mse;
}

TEST(BenchTrial, RidgesScoreWhatTheStuckProxyAnomalyIsKnownToScore) {
  // Thesis figure 4.6: a plain god-object waits at the foot, whoever writes it; the nearest point does not.
  const struct {
    const char* model;
    double god_object, nearest;
  } known[] = {{"ridge:degrees=45", 2.8, 0.042},
               {"ridge:degrees=60", 9.1, 0.082},
               {"ridge:degrees=75", 62, 0.18},
               {"ridge:degrees=85", 135, 0.145}};
  for (const auto& k : known) {
    EXPECT_NEAR(mse("god-object", k.model, "profile"), k.god_object, 0.02 * k.god_object) << k.model;
    EXPECT_NEAR(mse("nearest", k.model, "profile"), k.nearest, 0.02 * k.nearest) << k.model;
  }
}

// At the foot of a ridge no ball touches the point that it was said to touch: the exact nearest point scored 0.15 N^2.
TEST(BenchTrial, ABallIsJudgedWhereItFits) {
  const Model ridge = makeModel("ridge:degrees=45");
  Surface surface{5000};
  const auto judged = [&] {
    const Trajectory in = makeTrajectory("profile:force=0.1", ridge, surface);
    EXPECT_EQ(in.unfit > 0, surface.radius > 0);
    EXPECT_LT(in.unfit, in.samples.size() / 10) << surface.radius;
    return judge(in, runTrial("nearest", ridge, in, surface, 1).answers, 1e-3).force_mse;
  };
  const double point = judged();
  for (const double radius : {0.0005, 0.002}) {
    surface.radius = radius;
    EXPECT_LT(judged(), 2 * point) << radius;
  }
}

TEST(BenchTrial, OfABallThatFitsEverywhereEverySampleIsJudged) {
  Surface surface{1000};
  surface.radius = 0.002;
  for (const auto& [model, way] : {std::pair{"sphere:stacks=8", "spiral"},
                                   {"sphere:stacks=8", "geodesic"},
                                   {"sphere", "geodesic"},
                                   {"plane", "lissajous"},
                                   {"bowl", "swing"}}) {
    EXPECT_EQ(makeTrajectory(way, makeModel(model), surface).unfit, 0u) << model << " " << way;
  }
  surface.radius = 0.055;
  EXPECT_THROW((void)makeTrajectory("swing", makeModel("bowl"), surface), Failure) << "larger than the bowl";
}

TEST(BenchTrial, OnAPlaneEveryAlgorithmIsExact) {
  for (const char* algorithm : {"ours", "god-object", "nearest"}) {
    for (const char* trajectory : {"lissajous:seconds=2", "reach:seconds=2"}) {
      EXPECT_LT(mse(algorithm, "plane:cells=7", trajectory), 1e-12) << algorithm << " " << trajectory;
    }
  }
}

TEST(BenchTrial, TheHandComesFromOutsideTheFacetsToo) {
  // Flat facets fill a hollow by more than the hand is pressed in: begun within them, nobody would feel anything.
  const char *const model = "bowl:edge=0.004", *const way = "swing:seconds=2";
  const double nearest = mse("nearest", model, way, 1e5);
  for (const char* algorithm : {"ours", "god-object"})
    EXPECT_NEAR(mse(algorithm, model, way, 1e5), nearest, 0.01 * nearest) << algorithm;
}

TEST(BenchTrial, OursSlidesWithTheFrictionOfTheTruth) {
  const Model model = makeModel("plane");
  const Surface rough{1000, 0, 0.6, 0.4};
  const Trajectory trajectory = makeTrajectory("lissajous:seconds=4", model, rough);
  const Outcome outcome = runTrial("ours", model, trajectory, rough, 1);
  double late = 0;  // Until it slides at first, and where the path turns about the proxy's lag, it differs.
  for (std::size_t i = 200; i < outcome.answers.size(); ++i) {
    late = std::max(late, (outcome.answers[i].force - trajectory.samples[i].force).norm());
    ASSERT_NEAR(outcome.answers[i].force.head<2>().norm(), 0.4, 1e-6) << i;
  }
  EXPECT_LT(late, 0.03);
}

TEST(BenchTrial, ABallTouchesARadiusOutside) {
  Surface ball{1000};
  ball.radius = 0.002;
  for (const char* spec : {"sphere:stacks=64", "plane"}) {
    const Model model = makeModel(spec);
    const Trajectory trajectory = makeTrajectory(model.kind == "plane" ? "lissajous" : "spiral", model, ball);
    const double nearest = judge(trajectory, runTrial("nearest", model, trajectory, ball, 1).answers, 1e-3).force_mse;
    const double ours = judge(trajectory, runTrial("ours", model, trajectory, ball, 1).answers, 1e-3).force_mse;
    EXPECT_LT(nearest, 1e-3) << spec << ": 1 N, with facets";
    EXPECT_LE(ours, 1.02 * nearest + 1e-12) << spec;
    EXPECT_THROW((void)runTrial("god-object", model, trajectory, ball, 1), Failure);
  }
}

TEST(BenchTrial, GodObjectSitsInACornerOfThreePlanes) {
  Model walls;  // x, y, z = 0.01, seen from the origin.
  for (int axis = 0; axis < 3; ++axis) {
    const auto at = [&](double a, double b) {
      Vec3 x = Vec3::Constant(0.01);
      x[(axis + 1) % 3] = a;
      x[(axis + 2) % 3] = b;
      return walls.addVertex(x);
    };
    const std::uint32_t corners[] = {at(-0.1, -0.1), at(-0.1, 0.1), at(0.1, 0.1), at(0.1, -0.1)};
    walls.addQuad(corners[0], corners[1], corners[2], corners[3]);
  }
  Trajectory in;
  for (int i = 0; i < 100; ++i) {
    in.samples.push_back({0.001 * i, Vec3(0.0002 * i, 0.0003 * i, 0.00025 * i), Vec3::Zero(), Vec3::Zero()});
  }
  const Outcome outcome = runTrial("god-object", walls, in, {1000}, 1);
  for (std::size_t i = 0; i < in.samples.size(); ++i) {
    const Vec3 clamped = in.samples[i].hip.cwiseMin(0.01);
    ASSERT_LT((outcome.answers[i].proxy - clamped).norm(), 1e-8) << i;
    ASSERT_LT((outcome.answers[i].force - 1000 * (clamped - in.samples[i].hip)).norm(), 1e-4) << i;
  }
}

TEST(BenchTrial, RepeatsBitForBit) {
  const Model model = makeModel("sphere:stacks=8");
  const Trajectory trajectory = makeTrajectory("spiral:seconds=1", model, {1000});
  const Outcome outcome = runTrial("ours", model, trajectory, {1000}, 3);
  EXPECT_TRUE(outcome.repeats);
  EXPECT_EQ(outcome.rounds.size(), 3u);
  EXPECT_GT(outcome.bytes, model.triangles.size() * 12);
}

TEST(Metrics, HaveTheirClosedForm) {
  Trajectory truth;
  truth.force_known = truth.proxy_known = true;
  std::vector<Answer> answers;
  for (int i = 0; i < 10; ++i) {
    truth.samples.push_back({0.001 * i, Vec3(0.001 * i, 0, 0), Vec3(0, 0, 1), Vec3(0, 0, 1)});
    answers.push_back({Vec3(i + 1, 0, 1), Vec3(0, 0, i < 3 ? 1.25 : i == 3 ? 1.125 : 1), true});
  }
  const Accuracy a = judge(truth, answers, 0.125);
  EXPECT_DOUBLE_EQ(a.force_mse, 38.5);
  EXPECT_DOUBLE_EQ(a.energy_error, 0.001 * 99 / 2) << "of a force that rises by a newton a millimetre, over 9 mm";
  EXPECT_EQ(a.above, 3u) << "the fourth is as far off as the threshold";
  EXPECT_DOUBLE_EQ(a.proxy_max, 0.25);
  EXPECT_DOUBLE_EQ(a.proxy_rms, 0.125 * std::sqrt(1.3));

  Trajectory unknown = truth;
  unknown.force_known = false;
  Accuracy b = judge(unknown, answers, 0.125);
  EXPECT_EQ(b.force_mse, 0);
  EXPECT_EQ(b.energy_error, 0);
  EXPECT_EQ(b.proxy_rms, a.proxy_rms);
  unknown.force_known = true;
  unknown.proxy_known = false;
  b = judge(unknown, answers, 0.125);
  EXPECT_EQ(b.force_mse, a.force_mse);
  EXPECT_EQ(b.proxy_rms, 0);
  EXPECT_EQ(b.proxy_max, 0);
  EXPECT_EQ(b.above, 0u);

  // What is not judged adds no error, and no work on the way to it or from it.
  truth.samples[4].judged = truth.samples[5].judged = false;
  b = judge(truth, answers, 0.125);
  EXPECT_DOUBLE_EQ(b.force_mse, 40.5);
  EXPECT_DOUBLE_EQ(b.energy_error, 0.001 * (15 - 7.5 + 51 - 25.5));
  EXPECT_EQ(b.hash, a.hash) << "of all forces";
  for (int i = 0; i < 9; ++i) truth.samples[static_cast<std::size_t>(i)].judged = false;
  EXPECT_DOUBLE_EQ(judge(truth, answers, 0.125).force_mse, 100);
  truth.samples[9].judged = false;
  EXPECT_EQ(judge(truth, answers, 0.125).force_mse, 0);
}

TEST(Metrics, TheirHashIsThatOfTheForcesBits) {
  Trajectory truth;
  truth.samples.resize(4);
  std::vector<Answer> answers(4);
  for (std::size_t i = 0; i < 4; ++i) answers[i].force = Vec3(1.0 + static_cast<double>(i), 0, 0.5);
  const auto hash = [&] { return judge(truth, answers, 1).hash; };
  const std::uint64_t before = hash();
  EXPECT_LT(before, std::uint64_t{1} << 48) << "a double holds it";
  EXPECT_GE(before, std::uint64_t{1} << 32);
  for (Answer& answer : answers) answer.force.y() = -0.0;
  EXPECT_EQ(hash(), before) << "a zero's sign is no difference";
  for (Answer& answer : answers) answer.proxy = Vec3(1, 2, 3);
  EXPECT_EQ(hash(), before) << "of forces alone";
  answers[0].force.y() = 1e-300;
  EXPECT_NE(hash(), before);
  answers[0].force.y() = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    for (const int axis : {0, 2}) {
      double& force = answers[i].force[axis];
      const double was = std::exchange(force, std::nextafter(force, 10));
      EXPECT_NE(hash(), before) << i << " " << axis;
      force = was;
    }
  }
  std::swap(answers[1], answers[2]);
  EXPECT_NE(hash(), before) << "in another order";
  std::swap(answers[1], answers[2]);
  for (const int axis : {0, 2}) answers[1].force[axis] = -answers[1].force[axis];
  EXPECT_NE(hash(), before) << "two signs";
}

TEST(Metrics, TimesAreByNearestRank) {
  std::vector<std::int64_t> ns;
  for (int i = 1000; i > 0; --i) ns.push_back(i);
  const Timing t = summarise(ns);
  EXPECT_EQ(t.median, 500);
  EXPECT_EQ(t.p99, 990);
  EXPECT_EQ(t.p999, 999);
  EXPECT_EQ(t.max, 1000);
  EXPECT_DOUBLE_EQ(t.mean, 500.5);
}

TEST(Algorithms, FaultsAreNamed) {
  const Model model = makeModel("plane");
  const Trajectory trajectory = makeTrajectory("lissajous:seconds=1", model, {1000});
  for (const char* name : {"", "theirs", "./none.so", "ours:colour=red", "nearest:x=1"}) {
    EXPECT_THROW((void)runTrial(name, model, trajectory, {}, 1), Failure) << name;
  }
  haptic_algorithm table = findAlgorithm("ours");
  table.version = 99;
  EXPECT_THROW(checkAlgorithm(&table, "test"), Failure);
  table = findAlgorithm("ours");
  table.bytes = 8;
  EXPECT_THROW(checkAlgorithm(&table, "test"), Failure);
  table = findAlgorithm("ours");
  table.step = nullptr;
  EXPECT_THROW(checkAlgorithm(&table, "test"), Failure);
}

}  // namespace
}  // namespace haptic_bench
