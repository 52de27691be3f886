/** @file
 * Tools that are dropped, pushed, jammed, spun and hammered on the simulated device with its hand: no energy out of
 * nothing, rest is rest, nothing infinite; 1 and 4 kHz, 0.02 to 2 kg, couplings up to what the device bears.
 */
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>

#include "rt/body/constraint_response.h"
#include "tools/haptic-bench/stability/cases.h"

namespace hapticd {
namespace {

using haptic_bench::AnalyticDetector;
using haptic_bench::RigOptions;
using haptic_bench::ToolRig;

/** Each excitation with the pair that it is hardest on. */
struct Case {
  haptic_bench::StabilityPair pair;
  haptic_bench::Excitation what;
};

std::vector<Case> cases() {
  const auto pairs = haptic_bench::stabilityPairs();  // a brick on the floor, a plate in a bowl, a peg in its hole
  const auto what = haptic_bench::excitations();      // dropped, pushed, jammed, spun, hammered
  return {{pairs[0], what[0]}, {pairs[0], what[1]}, {pairs[2], what[2]}, {pairs[1], what[3]}, {pairs[0], what[4]}};
}

RigOptions optionsOf(const Case& c) {
  RigOptions options;
  options.size = c.pair.size;
  return options;
}

TEST(ToolStability, EnergyRestAndFinitenessOfTheDefault) {
  ConstraintResponse response;
  for (const Case& c : cases()) {
    for (const double rate : {1000.0, 4000.0}) {
      for (const double mass : {0.02, 0.2, 2.0}) {
        for (const double stiffness : {0.0, 1e9}) {
          if (rate > 1000 && (mass == 0.2) == (stiffness > 0)) continue;  // haptic-bench stability sweeps them all
          RigOptions options = optionsOf(c);
          options.rate_hz = rate;
          options.mass = mass;
          options.stiffness = stiffness;
          response.reset();
          AnalyticDetector detector(c.pair.points, c.pair.field);
          ToolRig rig(options, detector, nullptr, nullptr, response);
          const auto out = haptic_bench::play(c.pair, c.what, mass, rig);
          SCOPED_TRACE(testing::Message() << c.what.name << " " << rate << " Hz " << mass << " kg "
                                          << (stiffness > 0 ? "stiff" : "passive"));
          EXPECT_TRUE(out.finite);
          EXPECT_LE(out.created, 1e-9);
          EXPECT_LT(out.unrest, haptic_bench::kRest);
        }
      }
    }
  }
}

TEST(ToolStability, RestIsRestForAMinute) {
  // A box pressed askew on a floor, and a peg jammed in its hole: what a minute moves is less than an encoder step.
  ConstraintResponse response;
  for (const Case& c : cases()) {
    if (c.what.name != std::string("pushed") && c.what.name != std::string("jammed")) continue;
    AnalyticDetector detector(c.pair.points, c.pair.field);
    ToolRig rig(optionsOf(c), detector, nullptr, nullptr, response);
    (void)haptic_bench::play(c.pair, c.what, 0.2, rig);
    rig.run(2);
    const Vec3 tool = rig.tool().body().com();
    const Quat turned = rig.tool().body().orientation();
    const Vec3 hand = rig.device().body().position();
    rig.run(60);
    EXPECT_LT((rig.tool().body().com() - tool).norm(), 10e-6) << c.what.name;
    EXPECT_LT(rig.tool().body().orientation().angularDistance(turned), 1e-3) << c.what.name;
    EXPECT_LT((rig.device().body().position() - hand).norm(), 10e-6) << c.what.name;
    EXPECT_GT(rig.last().touching, 0u);
  }
}

TEST(ToolStability, APegHeldDeepInItsHoleRestsAndComesOut) {
  // Sixty points of a tilted peg are nearer to the wall than the clearance, and friction alone holds it against both
  // ends of the hole. Then the hand pulls it out.
  const haptic_bench::Excitation jam = haptic_bench::excitations()[2];
  int run = 0;
  for (const double clearance : {30e-6, 100e-6, 300e-6}) {
    for (const double friction : {0.2, 0.4, 0.8}) {
      for (const auto& [rings, around] : {std::pair{5, 12}, {9, 7}}) {
        haptic_bench::StabilityPair pair = haptic_bench::stabilityPairs()[3];
        pair.points = haptic_bench::peg(0.005, 0.04, rings, around);
        pair.field = haptic_bench::hole(0.005 + clearance, 0.06);
        RigOptions options;
        options.size = pair.size;
        options.friction = friction;
        options.mass = run % 4 < 2 ? 0.02 : 0.2;
        options.stiffness = run % 3 == 0 ? 1e9 : 0;
        options.collide_every = run % 2 == 0 ? 1 : 2;  // as often as the daemon asks
        ++run;
        ConstraintResponse response;
        AnalyticDetector detector(pair.points, pair.field);
        ToolRig rig(options, detector, nullptr, nullptr, response);
        const auto out = haptic_bench::play(pair, jam, options.mass, rig);
        SCOPED_TRACE(testing::Message() << clearance * 1e6 << " um, friction " << friction << ", " << rings
                                        << " rings");
        EXPECT_TRUE(out.finite);
        EXPECT_LE(out.created, 1e-9);
        EXPECT_LT(out.unrest, haptic_bench::kRest);
        rig.run(1);
        const Vec3 tool = rig.tool().body().com();
        rig.run(2);
        EXPECT_LT((rig.tool().body().com() - tool).norm(), 1e-6);
        EXPECT_GE(rig.last().touching, 2u);
        rig.aim({0, 0, 0.04});
        rig.run(1);
        // Out, or less deep than friction times its thickness: there two opposite points may wedge it.
        EXPECT_GT(rig.tool().body().com().z(), 0.02 - friction * 0.01 - 1e-3);
      }
    }
  }
}

TEST(ToolStability, ABrickSlipsAtItsFrictionAndSlidesWithIt) {
  // Pressed on the floor and drawn aside more and more: it stays until the tangential force is friction times the
  // normal one, and then slides with just that.
  const haptic_bench::StabilityPair pair = haptic_bench::stabilityPairs()[0];
  for (const double friction : {0.2, 0.5}) {
    RigOptions options;
    options.size = pair.size;
    options.friction = friction;
    ConstraintResponse response;
    AnalyticDetector detector(pair.points, pair.field);
    ToolRig rig(options, detector, nullptr, nullptr, response);
    rig.start(pair.home);
    rig.aim(pair.home - Vec3(0, 0, 0.01));
    rig.run(2);
    const Vec3 before = rig.tool().body().com();
    int held = 0;
    int slid = 0;
    for (int i = 0; i < 4000; ++i) {
      rig.aim(pair.home + Vec3(1e-5 * i, 0, -0.01));
      rig.tick();
      const Vec3 f = rig.last().contact.force;
      ASSERT_GT(f.z(), 0.1);
      const double share = std::hypot(f.x(), f.y()) / f.z();
      EXPECT_LE(share, friction * (1 + 1e-9));
      const double speed = rig.tool().body().twist().v.norm();
      if (slid == 0 && share < friction * (1 - 1e-6)) {
        EXPECT_LT((rig.tool().body().com() - before).norm(), 2e-6) << "it stays while friction holds";
        ++held;
      } else if (speed > 1e-4) {
        EXPECT_NEAR(share, friction, 1e-6);
        ++slid;
      }
    }
    EXPECT_GT(held, 100);
    EXPECT_GT(slid, 500);
    EXPECT_LE(rig.created(), 1e-9);
  }
}

/** RMS difference of the force from that with a query in every tick, and its RMS. */
TEST(ContactModel, TwoHundredQueriesASecondFeelLikeAThousand) {
  const auto forces = [](int every, int late, bool tied) {
    ConstraintResponse response;
    RigOptions options;
    options.collide_every = every;
    options.late = late;
    options.follow_touches = tied;
    options.size = Vec3(0.04, 0.03, 0.02);
    AnalyticDetector detector(haptic_bench::boxCorners(options.size), haptic_bench::ball(0.08));
    ToolRig rig(options, detector, nullptr, nullptr, response);
    rig.start({0, 0, 0.1});
    std::vector<Vec3> out;
    for (int i = 0; i < 3000; ++i) {
      const double t = i * 1e-3;
      rig.aim({0.03 * std::sin(3 * t), 0.02 * std::sin(2 * t), 0.1 - 0.03 * std::sin(4 * t)},
              Vec3(0.3 * std::sin(5 * t), 0, 0));
      rig.tick();
      out.push_back(rig.last().on_device.force);
    }
    return out;
  };
  const auto rms = [](const std::vector<Vec3>& x, const std::vector<Vec3>& y) {
    double sum = 0;
    for (std::size_t i = 0; i < x.size(); ++i) sum += (x[i] - y[i]).squaredNorm();
    return std::sqrt(sum / static_cast<double>(x.size()));
  };
  const std::vector<Vec3> truth = forces(1, 0, true);
  const double size = rms(truth, std::vector<Vec3>(truth.size(), Vec3::Zero()));
  const double local = rms(forces(5, 4, true), truth);
  const double held = rms(forces(5, 4, false), truth);
  if (std::getenv("HAPTICD_SHOW")) std::printf("force %.3f N, error %.4f N, held %.4f N\n", size, local, held);
  EXPECT_GT(size, 1);
  EXPECT_LT(local, 0.03 * size);
  EXPECT_LT(local, 0.5 * held) << "contacts that stand still between queries are no worse";
}

}  // namespace
}  // namespace hapticd
