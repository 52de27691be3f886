/** @file
 * haptic-bench sixdof: force and torque of the contact responses against the truth along trajectories, response by
 * response and by the rate of collision detection. The protocol of Weller, Sagardia, Mainzer, Hulin, Zachmann, Preusche
 * (EuroVR/EGVE 2010): magnitude and direction of both, against a model in closed form, over every sample.
 *
 * The truth is the quasi-static one: a tool without mass that the coupling presses against a rigid, smooth obstacle.
 * The device is moved as the trajectory says (no hand, no device dynamics), slowly enough for the tool's own mass to
 * matter little; contacts come from formulas, so that what is measured is response, coupling and local model alone.
 */
#include "tools/haptic-bench/command/sixdof.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "rt/base/rotation.h"
#include "rt/body/constraint_response.h"
#include "rt/body/contact_model.h"
#include "rt/body/direct.h"
#include "rt/body/impulse_response.h"
#include "rt/body/penalty_response.h"
#include "rt/body/tool.h"
#include "tools/haptic-bench/bench.h"
#include "tools/haptic-bench/machine.h"
#include "tools/haptic-bench/option.h"
#include "tools/haptic-bench/result/tables.h"

namespace haptic_bench {
namespace {

using namespace hapticd;  // NOLINT(google-build-using-namespace)

constexpr double kDt = 1e-3;                      ///< Of the servo [s].
constexpr double kSeconds = 8;                    ///< Of a trajectory.
constexpr double kMass = 0.05;                    ///< Of the tool [kg].
constexpr double kSettle = 0.5;                   ///< Not judged [s].
constexpr double kMargin = 0.003;                 ///< Of the contacts [m].
const Vec3 kHalf(0.02, 0.03, 0.01);               ///< Half-extents of the box [m].
constexpr double kBall = 0.02, kObstacle = 0.08;  ///< Radii [m].

/** A pair of solids in closed form, a path of the device, and what is then to be felt. */
struct Scenario {
  const char* name;
  Pose (*path)(double t);
  void (*contacts)(const Pose& X, double margin, ContactSet& out);
  /** Force and torque on the device; k, k_turn: the coupling's stiffness in the end. */
  Wrench (*truth)(const Pose& device, double k, double k_turn);
};

void add(ContactSet& out, double margin, const Vec3& a, const Vec3& b, const Vec3& n, std::uint32_t feature) {
  const double gap = n.dot(a - b);
  if (gap > margin || out.count == kMaxContacts) return;
  Contact& c = out.contact[out.count++];
  c.p_WA = a;
  c.p_WB = b;
  c.n_W = n;
  c.depth = -gap;
  c.feature_a = feature;
}

/** A box laid flat on a floor, pressed, slid and tilted: the floor keeps it flat, so the coupling shows the whole tilt.
 */
constexpr Scenario kBoxOnFloor{
    "box on floor",
    [](double t) {
      const double depth = 0.004 + 0.0015 * std::sin(2 * t);
      return Pose{{0.02 * std::sin(1.1 * t), 0.02 * std::cos(0.7 * t), kHalf.z() - depth},
                  fromRotationVector(0.02 * Vec3(std::sin(1.3 * t), std::cos(1.7 * t), 0))};
    },
    [](const Pose& X, double margin, ContactSet& out) {
      for (std::uint32_t i = 0; i < 8; ++i) {
        const Vec3 corner((i & 1) != 0 ? kHalf.x() : -kHalf.x(), (i & 2) != 0 ? kHalf.y() : -kHalf.y(),
                          (i & 4) != 0 ? kHalf.z() : -kHalf.z());
        const Vec3 a = X * corner;
        add(out, margin, a, Vec3(a.x(), a.y(), 0), Vec3::UnitZ(), i + 1);
      }
    },
    [](const Pose& device, double k, double k_turn) {
      return Wrench{{0, 0, k * (kHalf.z() - device.p.z())}, -k_turn * rotationVector(device.q)};
    }};

/** A ball that strokes a ball: force along the line of centres, no torque. Curved: planes of old contacts are off. */
constexpr Scenario kBallOnBall{
    "ball on ball",
    [](double t) {
      const double polar = 0.6 * std::sin(1.5 * t);
      const double turn = 0.9 * t;
      const double r = kBall + kObstacle - 0.004 - 0.001 * std::sin(3 * t);
      return Pose{r * Vec3(std::sin(polar) * std::cos(turn), std::sin(polar) * std::sin(turn), std::cos(polar)),
                  Quat::Identity()};
    },
    [](const Pose& X, double margin, ContactSet& out) {
      const Vec3 n = X.p.normalized();
      add(out, margin, X.p - kBall * n, kObstacle * n, n, 1);
    },
    [](const Pose& device, double k, double) {
      const double depth = kBall + kObstacle - device.p.norm();
      return Wrench{k * depth * device.p.normalized(), Vec3::Zero()};
    }};

/** A ball in a groove of two walls at right angles: one wall, both, the other. The tool is at the point of the groove's
 * free space that is nearest to the device: of a wedge, in closed form. */
constexpr Scenario kBallInGroove{"ball in groove",
                                 [](double t) {
                                   return Pose{{0.02 * std::sin(t), 0.008 * std::sin(1.7 * t),
                                                std::sqrt(2.0) * kBall - 0.004 - 0.002 * std::sin(2.3 * t)},
                                               Quat::Identity()};
                                 },
                                 [](const Pose& X, double margin, ContactSet& out) {
                                   for (std::uint32_t i = 0; i < 2; ++i) {
                                     const Vec3 n = Vec3(0, i == 0 ? 1 : -1, 1).normalized();
                                     add(out, margin, X.p - kBall * n, X.p - X.p.dot(n) * n, n, i + 1);
                                   }
                                 },
                                 [](const Pose& device, double k, double) {
                                   // Normals at right angles: the projection takes each wall's share by itself.
                                   Vec3 force = Vec3::Zero();
                                   for (const double side : {1.0, -1.0}) {
                                     const Vec3 n = Vec3(0, side, 1).normalized();
                                     force += k * std::max(0.0, kBall - device.p.dot(n)) * n;
                                   }
                                   return Wrench{force, Vec3::Zero()};
                                 }};

struct Played {
  Judged force, torque;
  double deepest = 0;  ///< Overlap that the tool was left in [m].
};

/** The response null: direct rendering, the tool where the device is and as stiff as the coupling in the end. */
Played play(const Scenario& scenario, Response* response, int every) {
  ToolSetup setup;
  setup.mass = MassProperties::ofBox(kMass, 2 * kHalf);
  DeviceInfo info;  // a good desktop device: stiffness enough to press with a few newtons
  info.max_stiffness = 4000;
  setup.gains = chooseGains(info, {kMass, setup.mass.inertia_O.trace() / 3, kDt, 1000});
  const CouplingGains& g = setup.gains;
  const double k = g.outer * g.stiffness / (g.outer + g.stiffness);
  const double k_turn = g.angular_outer * g.angular_stiffness / (g.angular_outer + g.angular_stiffness);
  Tool tool(setup);
  Pose start = scenario.path(0);
  start.p.z() += 0.01;
  tool.reset(start);
  if (response != nullptr) response->reset();
  Played out;
  ContactSet found;
  ContactModel model, next;
  ToolStep step;
  const int ticks = static_cast<int>(kSeconds / kDt);
  const int lower = static_cast<int>(kSettle / kDt) / 2;
  for (int i = 0; i < ticks; ++i) {
    Pose device = scenario.path(std::max(0, i - 2 * lower) * kDt);
    device.p.z() += 0.01 * std::max(0.0, 1.0 - double(i) / lower);
    if (response == nullptr) tool.reset(device);
    if (i % every == 0) {
      // What was asked a period ago is answered now.
      model = every > 1 ? next : model;
      found.count = 0;
      scenario.contacts(tool.body().pose(), kMargin, found);
      const ContactBody body;
      next.build(found, tool.body().pose(), {&body, 1}, 0);
      if (every == 1) model = next;
    }
    std::array<Touch, kMaxTouches> touches;
    for (std::uint32_t c = 0; c < model.count; ++c) {
      touches[c] = model.touch(c, tool.body().pose(), tool.body().com(), Pose{}, Twist{});
    }
    if (response != nullptr) {
      tool.step(device, {touches.data(), model.count}, kDt, *response, step);
    } else {
      step.on_device = directWrench({touches.data(), model.count}, Twist{}, Twist{}, {k, 0});
    }
    if (i < 2 * lower) continue;
    const Wrench truth = scenario.truth(device, k, k_turn);
    out.force.add(step.on_device.force, truth.force);
    out.torque.add(step.on_device.torque, truth.torque);
    found.count = 0;
    scenario.contacts(tool.body().pose(), 0, found);
    for (const Contact& c : found.contacts()) out.deepest = std::max(out.deepest, c.depth);
  }
  return out;
}

/** What has no value (the torque of a contact that makes none) is a dash. */
std::string column(double value, const char* unit) {
  return std::isnan(value) ? fmt::format("{:>8}", "-") : fmt::format("{:6.2f} {}", value, unit);
}

int run(const Common& common, bool check) {
  PenaltyGains hard;
  hard.stiffness = 5000;
  hard.max_depth = 0.01;
  const std::vector<std::shared_ptr<Response>> responses = {std::make_shared<ConstraintResponse>(),
                                                            std::make_shared<ImpulseResponse>(),
                                                            std::make_shared<PenaltyResponse>(hard), nullptr};
  for (const std::string& line : describeMachine()) fmt::print("# {}\n", line);
  if (common.csv) {
    fmt::print("{}\n", tableForm("sixdof").header());
  } else {
    fmt::print("{:14} {:11} {:>5} | {:>9} {:>8} {:>8} {:>8} | {:>11} {:>8} {:>8} | {:>9}\n", "case", "response", "Hz",
               "force RMS", "relative", "worst", "angle", "torque RMS", "relative", "angle", "overlap");
  }
  bool good = true;
  for (const Scenario* scenario : {&kBoxOnFloor, &kBallInGroove, &kBallOnBall}) {
    for (const auto& response : responses) {
      // Several touches share direct rendering's stiffness as they come: it has no such truth.
      if (response == nullptr && scenario != &kBallOnBall) continue;
      const char* const name = response != nullptr ? response->name() : "direct";
      for (const int every : {1, 2, 5}) {
        const Played r = play(*scenario, response.get(), every);
        if (common.csv) {
          fmt::print("{},{},{},{:g},{:g},{:g},{:g},{:g},{:g},{:g},{:g}\n", scenario->name, name, 1000 / every,
                     r.force.rms(), r.force.relative(), r.force.worst, r.force.degrees(), r.torque.rms(),
                     r.torque.relative(), r.torque.degrees(), r.deepest);
        } else {
          fmt::print("{:14} {:11} {:5} | {:7.4f} N {} {:6.3f} N {} | {:6.2f} mN m {} {} | {:6.1f} um\n", scenario->name,
                     name, 1000 / every, r.force.rms(), column(100 * r.force.relative(), "%"), r.force.worst,
                     column(r.force.degrees(), "°"), 1e3 * r.torque.rms(), column(100 * r.torque.relative(), "%"),
                     column(r.torque.degrees(), "°"), r.deepest * 1e6);
        }
        const bool default_response = response == responses.front();
        // A torque made of nothing: against that of the force at the ball's radius.
        good = good && (!default_response || (r.force.isGood(0) && r.torque.isGood(kBall * r.force.truth())));
      }
    }
  }
  if (check && !good) fmt::print("the default response misses 5 % or 3 degrees\n");
  return check && !good ? 1 : 0;
}

}  // namespace

void addSixdof(CLI::App& app, Run& chosen) {
  CLI::App* command =
      app.add_subcommand("sixdof", "Force and torque of a held tool against the truth, by response and collision rate");
  const auto check = std::make_shared<bool>(false);
  command->add_flag("--check", *check, "End with 1 when the default response is off by more than 5 % or 3 degrees");
  whenNamed(command, chosen, [check](const Common& common) { return run(common, *check); });
}

}  // namespace haptic_bench
