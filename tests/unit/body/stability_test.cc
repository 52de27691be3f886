/** @file
 * Tools that are dropped, pushed, jammed, spun and hammered on the simulated device with its hand: no energy out of
 * nothing, rest is rest, nothing infinite; 1 and 4 kHz, 0.02 to 2 kg, couplings up to what the device bears.
 */
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>

#include "rt/body/constraint_response.h"
#include "rt/body/impulse_response.h"
#include "rt/body/penalty_response.h"
#include "tests/support/tool_rig.h"

namespace hapticd {
namespace {

using test::Field;
using test::Points;
using test::RigOptions;
using test::ToolRig;

constexpr double kDegree = EIGEN_PI / 180;

struct Case {
  const char* name;
  Points points;
  Field field;
  Vec3 size;
  Vec3 start;
  void (*excite)(ToolRig&);
  bool airborne = false;  ///< Ends in the air.
};

void drop(ToolRig& rig) {
  rig.tool().setTwist({{0.1, 0, -1}, {3, 1, 0}});
  rig.run(0.3);
}
void push(ToolRig& rig) {
  rig.aim({0.01, 0.005, -0.03}, Vec3(0.3, 0.2, 0));
  rig.run(0.3);
}
void jam(ToolRig& rig) {
  rig.aim({0, 0, -0.005});
  rig.run(0.4);
  rig.aim({0.01, 0.004, -0.012}, Vec3(10 * kDegree, 15 * kDegree, 20 * kDegree));
  rig.run(0.4);
}
void spin(ToolRig& rig) {
  rig.tool().setTwist({Vec3::Zero(), {40, 60, 10}});
  rig.aim({0, 0, -0.045});
  rig.run(0.4);
}
void hammer(ToolRig& rig) {
  for (int i = 0; i < 4; ++i) {
    rig.aim({0, 0, -0.03});
    rig.run(0.07);
    rig.aim({0, 0, 0.04}, Vec3(0.1 * i, 0.2, 0));
    rig.run(0.07);
  }
  rig.aim({0, 0, 0.005});
  rig.run(0.1);
}

std::vector<Case> cases() {
  const Vec3 brick(0.03, 0.03, 0.03);
  const Vec3 rod(0.01, 0.01, 0.04);
  const Vec3 wide(0.04, 0.03, 0.02);
  return {
      {"dropped", test::boxCorners(brick), test::halfSpace(), brick, {0, 0, 0.03}, drop, true},
      {"pushed", test::boxCorners(wide), test::halfSpace(), wide, {0, 0, 0.02}, push},
      {"jammed", test::peg(0.005, 0.04, 5, 12), test::hole(0.0051, 0.06), rod, {0, 0, 0.0}, jam},
      {"spun", test::boxCorners(wide), test::bowl(0.05), wide, {0, 0, -0.01}, spin},
      {"hammered", test::boxCorners(brick), test::halfSpace(), brick, {0, 0, 0.04}, hammer},
  };
}

struct Outcome {
  double created, strongest, fastest;
  ToolRig::Unrest unrest;
  bool finite;
};

Outcome play(const Case& what, RigOptions options, Response& response) {
  options.size = what.size;
  response.reset();
  ToolRig rig(options, what.points, what.field, response);
  rig.start(what.start);
  what.excite(rig);
  rig.run(1.2 + (what.airborne ? 3 * options.mass : 0));  // two kilograms on a spring swing for long
  const ToolRig::Unrest unrest = rig.watch(0.3);
  return {rig.created(), rig.strongest(), rig.fastest(), unrest, rig.finite()};
}

TEST(ToolStability, EnergyRestAndFinitenessOfTheDefault) {
  ConstraintResponse response;
  for (const Case& what : cases()) {
    for (const double rate : {1000.0, 4000.0}) {
      for (const double mass : {0.02, 0.2, 2.0}) {
        for (const double stiffness : {0.0, 1e9}) {
          if (rate > 1000 && (mass == 0.2) == (stiffness > 0)) continue;  // haptic-bench sixdof sweeps them all
          RigOptions options;
          options.rate_hz = rate;
          options.mass = mass;
          options.stiffness = stiffness;
          const Outcome out = play(what, options, response);
          SCOPED_TRACE(testing::Message() << what.name << " " << rate << " Hz " << mass << " kg "
                                          << (stiffness > 0 ? "stiff" : "passive"));
          if (std::getenv("HAPTICD_SHOW")) {
            std::printf("%-9s %4.0f %.2f %d created %9.2g strongest %6.2f fastest %5.2f unrest %8.3g %8.3g\n",
                        what.name, rate, mass, stiffness > 0, out.created, out.strongest, out.fastest,
                        out.unrest.device, out.unrest.tool);
          }
          EXPECT_TRUE(out.finite);
          EXPECT_LE(out.created, 1e-9);
          EXPECT_LT(out.unrest.device, 80e-6) << "eight encoder steps";
          EXPECT_LT(out.unrest.tool, 80e-6);
        }
      }
    }
  }
}

/** Minutes long: --gtest_also_run_disabled_tests. The default must hold; the others are told (docs/tool.md). */
TEST(ToolStability, DISABLED_SweepOfAllResponses) {
  PenaltyGains hard;
  hard.stiffness = 5000;
  hard.max_depth = 0.01;
  ConstraintResponse constraint;
  ImpulseResponse impulse;
  PenaltyResponse penalty(hard);
  for (Response* response :
       {static_cast<Response*>(&constraint), static_cast<Response*>(&impulse), static_cast<Response*>(&penalty)}) {
    for (const Case& what : cases()) {
      int runs = 0, at_rest = 0;
      double created = 0, unrest = 0;
      for (const double rate : {1000.0, 4000.0}) {
        for (const double mass : {0.02, 0.06, 0.2, 0.6, 2.0}) {
          for (const double stiffness : {0.0, 1e9}) {
            RigOptions options;
            options.rate_hz = rate;
            options.mass = mass;
            options.stiffness = stiffness;
            const Outcome out = play(what, options, *response);
            EXPECT_TRUE(out.finite);
            const double moved = std::max(out.unrest.device, out.unrest.tool);
            ++runs;
            at_rest += moved < 80e-6 ? 1 : 0;
            created = std::max(created, out.created);
            unrest = std::max(unrest, moved);
          }
        }
      }
      std::printf("%-10s %-8s at rest %d of %d, unrest %.3g m, created %.2g J\n", response->name(), what.name, at_rest,
                  runs, unrest, created);
      EXPECT_LE(created, 1e-9);
      if (response == &constraint) {
        EXPECT_EQ(at_rest, runs);
      }
    }
  }
}

TEST(ToolStability, RestIsRestForAMinute) {
  // A box pressed askew on a floor, and a peg jammed in its hole: what a minute moves is less than an encoder step.
  ConstraintResponse response;
  for (const Case& what : cases()) {
    if (what.excite != push && what.excite != jam) continue;
    RigOptions options;
    options.size = what.size;
    ToolRig rig(options, what.points, what.field, response);
    rig.start(what.start);
    what.excite(rig);
    rig.run(2);
    const Vec3 tool = rig.tool().body().com();
    const Quat turned = rig.tool().body().orientation();
    const Vec3 hand = rig.device().body().position();
    rig.run(60);
    EXPECT_LT((rig.tool().body().com() - tool).norm(), 10e-6) << what.name;
    EXPECT_LT(rig.tool().body().orientation().angularDistance(turned), 1e-3) << what.name;
    EXPECT_LT((rig.device().body().position() - hand).norm(), 10e-6) << what.name;
    EXPECT_GT(rig.last().touching, 0u);
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
    ToolRig rig(options, test::boxCorners(options.size), test::ball(0.08), response);
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
