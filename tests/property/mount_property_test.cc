// A world that is turned, shifted and scaled with the device feels the same: what the hand is sent depends on where
// things are to each other, not on where they are, and on how large they are to the hand.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>
#include <utility>

#include "rt/cycle/cycle.h"
#include "tests/support/for_seeds.h"
#include "tests/support/shape/test_surface.h"
#include "tests/support/stepped/attach_tool.h"
#include "tests/support/stepped/mount_at.h"
#include "tests/support/stepped/solid.h"
#include "tests/support/stepped/stepped_cycle.h"
#include "tests/support/stepped/wandering_hand.h"

namespace hapticd {
namespace {

constexpr double kAsBefore = 1e-9;  // [N], [N m]
constexpr double kScaled = 1e-8;    // Far from the origin a small world's places round more to the hand [N], [N m].
constexpr double kSolved = 1e-7;    // What the solver of a tool's contacts leaves open [N], [N m].
constexpr std::uint32_t kGround = makeObjectId(1, 1), kBall = makeObjectId(2, 1), kBox = makeObjectId(3, 1),
                        kGuide = makeObjectId(4, 1), kProbe = makeObjectId(5, 1), kBody = makeObjectId(6, 1);

constexpr double kWave = 2 * M_PI / 64;  // Of the floor's relief, four in a picture [1/pixel].
const Vec3 kBallAt(0.06, 0, 0.04), kBoxAt(-0.06, 0.01, 0.04), kBodyAt(0, 0.06, 0.04);

/** What is asked. */
struct Question {
  bool tool = false;      ///< The hand holds a box; else it is a point.
  bool models = true;     ///< A client sends local models, too.
  bool passivity = true;  ///< The guard's controller may act.
  bool quarters = false;  ///< All turns are of 90 degrees: axes become axes.
  bool scaled = false;    ///< The other world is larger or smaller by a power of two, so that floats hold it as well.
};

CycleConfig config(bool passivity) {
  CycleConfig c;
  c.guard[0].limits = {6, 0.3, 2000, 100, 4, 5, 10, 5};
  c.guard[0].ramp_ns = 20'000'000;
  c.guard[0].small_force = 3;
  c.guard[0].continuous_force = 2;
  c.guard[0].peak_force = 6;
  c.guard[0].heating_s = 1;
  c.guard[0].passivity = passivity;
  return c;
}

/**
 * A scene that is told to the cycle where X_WD has brought it, a device that stands there too, and all of it `s` times
 * as large: lengths s times, so that newtons stay newtons stiffness, damping and mass 1 / s.
 */
class MountedWorld : public test::SteppedCycle {
 public:
  MountedWorld(const Pose& X_WD, double s, const Question& asked)
      : SteppedCycle(config(asked.passivity)), X_(X_WD), s_(s) {
    cycle->setResolution(0, 1e-5, 1e-4);
    put(CommandKind::kSetMount, test::mountAt(X_WD, 0, s));
    put(CommandKind::kAddSession, SessionRef{0, 0, 1});
    SetGravity down{};
    store(turned(s * Vec3(0.5, 0, -9.81)), down.g);
    put(CommandKind::kSetGravity, down);
    object(kGround, ShapeKind::kPlane, {{0, 0, -0.01}, Quat::Identity()}, Vec3::Zero());
    meshes.publishTexture(0, &waves_.view);
    SurfaceParameters surface{};
    surface.relief = 1;
    surface.relief_depth = s * 0.002;
    surface.relief_size[0] = surface.relief_size[1] = s * 0.032;
    put(CommandKind::kSetSurface, SetSurface{kGround, 0, surface});
    // Apart from each other: which side of a corner a hand comes down on may be a matter of rounding.
    object(kBall, ShapeKind::kSphere, {kBallAt, Quat::Identity()}, {0.01, 0, 0});
    object(kBox, ShapeKind::kBox, {kBoxAt, Quat(Eigen::AngleAxisd(0.5, Vec3::UnitZ()))}, {0.01, 0.01, 0.01});
    object(kBody, ShapeKind::kSphere, {kBodyAt, Quat::Identity()}, {0.01, 0, 0});
    SetBody body{kBody, 0, 0.2 / s, {}, {}, 1};
    for (int i = 0; i < 3; ++i) body.inertia[i] = s * 1e-5;
    put(CommandKind::kSetBody, body);
    object(kGuide, ShapeKind::kGroup, {{0, 0, 0.03}, Quat(Eigen::AngleAxisd(0.7, Vec3::UnitX()))}, Vec3::Zero());
    if (asked.tool) {
      object(kProbe, ShapeKind::kBox, {{0, 0, 0.1}, Quat::Identity()}, {0.01, 0.02, 0.005});
      DeviceInfo device;
      device.max_force = 6;
      device.max_stiffness = 2000;
      device.max_angular_stiffness = 4;
      device.max_damping = 5;
      device.max_angular_damping = 0.01;
      device.actuated_rotation = true;
      AttachTool tool = test::attachBox(kProbe, {0.02, 0.04, 0.01}, device);
      tool.flags = kToolWeighs;
      for (double* x : {&tool.mass, &tool.outer, &tool.stiffness, &tool.damping}) *x /= s;
      for (double* x : {&tool.angular_outer, &tool.angular_stiffness, &tool.angular_damping}) *x *= s;
      for (double& x : tool.com) x *= s;
      for (double& x : tool.inertia) x *= s;
      put(CommandKind::kAttachTool, tool);
    }
    step();
  }

  [[nodiscard]] Vec3 turned(const Vec3& x) const { return X_.q * x; }

  void object(std::uint32_t id, ShapeKind kind, const Pose& at, const Vec3& size) {
    add(test::solid(id, kind, {900 / s_, 1 / s_, 0.5, 0.4}, brought(at), s_ * size));
  }
  [[nodiscard]] Pose brought(const Pose& X) const { return X_ * Pose{s_ * X.p, X.q}; }
  void move(std::uint32_t id, const Vec3& p, const Vec3& v) {
    put(CommandKind::kObjectPose, poseMessage(id, brought({p, Quat::Identity()}), {turned(s_ * v), Vec3::Zero()}));
  }
  void effect(EffectKind kind) {
    SetEffect order{kGuide, 0, {}};
    EffectParameters& e = order.effect;
    e.kind = static_cast<std::uint32_t>(kind);
    e.force = 2;
    e.stiffness = 300 / s_;
    // Where two chords of a path meet, which of them says what is across may be a matter of rounding.
    e.damping = kind == EffectKind::kGuide ? 0 : 3 / s_;
    e.reach = s_ * 0.05;
    e.frequency = 90;
    if (kind == EffectKind::kGuide) {
      e.points = 4;
      for (int i = 0; i < 4; ++i) {
        e.path[i][0] = static_cast<float>(s_) * (0.01F * static_cast<float>(i) - 0.02F);
        e.path[i][1] = static_cast<float>(s_) * (i % 2 == 0 ? 0.01F : -0.01F);
      }
    }
    put(CommandKind::kSetEffect, order);
  }
  void pushes(const Vec3& force, const Vec3& torque) {
    hd_client_force f{};
    f.lease_ns = 200'000'000;
    store(turned(force), f.force);
    store(turned(s_ * torque), f.torque);
    put(CommandKind::kClientForce, f, 0);
  }
  void model(std::uint32_t kind, const Vec3& origin, const Vec3& normal) {
    hd_local_model m{};
    m.slot = kind % 2;
    m.kind = kind;
    m.lease_ns = 300'000'000;
    m.blend_ns = 10'000'000;
    m.material = {800 / s_, 1 / s_, 0.6, 0.5};
    store(X_ * (s_ * origin), m.origin);
    store(turned(normal), m.normal);
    m.radius = s_ * 0.02;
    put(CommandKind::kLocalModel, m, 0);
  }
  /** Where the box in the hand meets the floor: at its lower corners. */
  void corners() {
    ToolContacts found{};
    found.object = kProbe;
    found.count = 4;
    for (std::uint32_t i = 0; i < 4; ++i) {
      ToolContacts::Point& p = found.point[i];
      const auto s = static_cast<float>(s_);
      p.p_A[0] = s * (i % 2 == 0 ? 0.01F : -0.01F);
      p.p_A[1] = s * (i / 2 == 0 ? 0.02F : -0.02F);
      p.p_A[2] = s * -0.005F;
      p.n_B[2] = 1;
      p.key = objectSlot(kGround) << 24 | (i + 1);
    }
    answer(found);
  }
  /** The body touches nothing but the hand, which it is to be told. */
  void alone() {
    ToolContacts none{};
    none.device = kMaxDevices;
    none.object = kBody;
    answer(none);
  }
  [[nodiscard]] Vec3 bodyAt() const { return cycle->scene().slot(objectSlot(kBody)).X_WO.p; }
  /** Of the device itself. */
  const DeviceOutput& with(const DeviceSample& sample) {
    input->device[0] = sample;
    return step();
  }

 private:
  Pose X_;
  double s_;
  test::TestRelief waves_{256, 256,
                          [](auto x, auto y) { return 0.5 + 0.25 * (std::sin(x * kWave) + std::cos(y * kWave)); }};
};

/** What both worlds are told, and how the hand moves, by one row of random numbers. */
class Story {
 public:
  Story(unsigned seed, const Question& asked)
      : random_(seed), hand_(random_, 0.02, {Vec3::Zero(), kBallAt, kBoxAt}), asked_(asked) {
    sample_.has_velocity = seed % 2 == 0;
  }

  void next(std::array<MountedWorld*, 2> worlds) {
    const auto both = [&](auto&& tell) {
      for (MountedWorld* world : worlds) tell(*world);
    };
    if (random_.once(200)) both([](MountedWorld& w) { w.arm(); });
    if (random_.once(900)) both([](MountedWorld& w) { w.put(CommandKind::kDisarm, DeviceRef{0}); });
    ++tick_;
    if (tick_ % 10 == 0) {
      const double phase = 0.01 * tick_;
      const Vec3 sway(0.002, 0.004, 0.003);
      const Vec3 p = kBallAt + std::sin(phase) * sway, v = 10 * std::cos(phase) * sway;
      both([&](MountedWorld& w) { w.move(kBall, p, v); });
    }
    if (random_.once(100)) {
      const auto kind = static_cast<EffectKind>(random_.below(6));
      both([&](MountedWorld& w) { w.effect(kind); });
    }
    if (random_.once(100)) {
      const Vec3 f = random_.vector(2), t = random_.vector(0.1);
      both([&](MountedWorld& w) { w.pushes(f, t); });
    }
    if (asked_.models && random_.once(100)) {
      const std::uint32_t kind = 1 + random_.below(3u);
      const Vec3 origin = random_.vector(0.01), normal = random_.vector(1).normalized();
      both([&](MountedWorld& w) { w.model(kind, origin, normal); });
    }
    // How fast a tool leaves an overlap, and how much of one is let be, is told in the world's metres.
    if (asked_.tool && !asked_.scaled && random_.once(2)) both([](MountedWorld& w) { w.corners(); });
    const Vec3 aim = hand_.next();
    sample_.v = 0.05 / 1e-3 * (aim - p_);
    p_ += 1e-3 * sample_.v;
    w_ = 0.95 * w_ + random_.vector(0.2);
    q_ = rotated(q_, w_, 1e-3);
    sample_.w = w_;
    sample_.p = p_;
    sample_.q = q_;
    sample_.fresh = !random_.once(20);
    sample_.gripper_rad = 0.1;
  }
  [[nodiscard]] DeviceSample sample() const { return sample_; }
  Random& random() { return random_; }

 private:
  int tick_ = 0;
  Random random_;
  test::WanderingHand hand_;
  Question asked_;
  Vec3 p_ = Vec3::Zero(), w_ = Vec3::Zero();
  Quat q_ = Quat::Identity();
  DeviceSample sample_;
};

/** Counts, so that it is known to have looked at something. */
struct Felt {
  int armed = 0, contact = 0, limited = 0, passivity = 0, torque = 0, faults = 0, relief = 0;
  void note(const DeviceOutput& out) {
    armed += out.command.enabled;
    contact += out.contact.object != 0;
    limited += (out.guard.flags & HD_SAMPLE_LIMITED) != 0;
    passivity += (out.guard.flags & HD_SAMPLE_PASSIVITY) != 0;
    torque += out.command.torque.norm() > 1e-3;
    relief += !out.guard.by_source[HD_SOURCE_TEXTURE].isZero(0);
    faults += out.guard.fault != HD_FAULT_NONE;
  }
};

/** Anywhere and turned anyhow, or by quarter turns. */
Pose placeFor(const Question& asked, Random& random) {
  Pose X = random.pose(1);
  if (!asked.quarters) return X;
  X.q.setIdentity();
  for (int axis = 0; axis < 3; ++axis) X.q = Quat(Eigen::AngleAxisd(M_PI_2 * random.below(4), Vec3::Unit(axis))) * X.q;
  return X;
}

Felt expectTheSame(unsigned count, const Question& asked) {
  Felt felt;
  const double same = asked.tool ? kSolved : asked.scaled ? kScaled : kAsBefore;
  forSeeds(count, [&](unsigned seed) {
    Story story(seed, asked);
    const Pose X = placeFor(asked, story.random());
    // A tool's speed has a bound, in metres of the world.
    const double s = asked.scaled ? std::exp2(story.random().below(asked.tool ? 5 : 9) - 4) : 1;
    MountedWorld plain({}, 1, asked), mounted(X, s, asked);
    ASSERT_FALSE(mounted.cycle->mount(0).identity());
    // The weight that a driver carries is that of a device which stands upright.
    const double upright = (X.q * Vec3::UnitZ()).z();
    for (int tick = 0; tick < 1500; ++tick) {
      SCOPED_TRACE(tick);
      story.next({&plain, &mounted});
      DeviceSample sample = story.sample();
      sample.gravity = upright * Vec3(0.1, 0, 0.6);
      const DeviceOutput& one = plain.with(sample);
      sample.gravity = {0.1, 0, 0.6};
      const DeviceOutput& other = mounted.with(sample);
      ASSERT_EQ(one.command.enabled, other.command.enabled);
      ASSERT_EQ(one.guard.fault, other.guard.fault);
      for (int i = 0; i < HD_SOURCES; ++i)
        ASSERT_NEAR((one.guard.by_source[i] - other.guard.by_source[i]).norm(), 0, 10 * same) << i;
      ASSERT_NEAR((one.command.force - other.command.force).norm(), 0, same);
      ASSERT_NEAR((one.command.torque - other.command.torque).norm(), 0, same);
      if (!asked.models) {  // Of a model that presses with no force at all, a rounding decides whether it holds energy.
        const auto books = [](const MountedWorld& w) { return w.cycle->deviceGuard(0).passivity().byAxis(); };
        ASSERT_NEAR(one.guard.energy, other.guard.energy, same);
        if (asked.quarters || !asked.tool) {
          ASSERT_NEAR((books(plain) - books(mounted)).norm(), 0, same);
        }
      }
      ASSERT_EQ(one.contact.object, other.contact.object);
      ASSERT_NEAR((X * (s * one.pose.p) - other.pose.p).norm(), 0, 1e-14 * std::max(1.0, s));
      ASSERT_NEAR((X.q * (s * one.velocity.v) - other.velocity.v).norm(), 0, 1e-12 * std::max(1.0, s));
      ASSERT_NEAR((X.q * one.velocity.w - other.velocity.w).norm(), 0, 1e-12);
      if (one.contact.object != 0) {
        ASSERT_NEAR((X * (s * one.contact.proxy) - other.contact.proxy).norm(), 0, 0.1 * same * std::max(1.0, s));
      }
      felt.note(other);
    }
  });
  return felt;
}

/** Of a body that moves, the guard books the power along the device's axes, wherever those are. */
TEST(MountProperty, ATurnedAndShiftedWorldFeelsTheSameWithAGuardThatActs) {
  const Felt felt = expectTheSame(20, {.models = false});
  if (!drawsAll()) return;
  EXPECT_GT(felt.armed, 5000);
  EXPECT_GT(felt.contact, 300);
  EXPECT_GT(felt.limited, 100);
  EXPECT_GT(felt.relief, 100);
  EXPECT_GT(felt.passivity, 50);
}

TEST(MountProperty, ATurnedAndShiftedWorldFeelsTheSameWithLocalModels) {
  const Felt felt = expectTheSame(20, {.passivity = false});
  if (!drawsAll()) return;
  EXPECT_GT(felt.armed, 5000);
  EXPECT_GT(felt.contact, 300);
}

TEST(MountProperty, ATurnedAndShiftedWorldFeelsTheSameToAToolInSixDegreesOfFreedom) {
  const Felt felt = expectTheSame(20, {.tool = true, .passivity = false});
  if (!drawsAll()) return;
  EXPECT_GT(felt.armed, 5000);
  EXPECT_GT(felt.contact, 300);
  EXPECT_GT(felt.torque, 300);
}

/** What a metre of the hand is changes no newton, where the world's stiffness is as much less. */
TEST(MountProperty, AScaledWorldFeelsTheSame) {
  const Question asked[] = {{.models = false, .quarters = true, .scaled = true},
                            {.quarters = true, .scaled = true},
                            {.tool = true, .passivity = false, .scaled = true},
                            {.passivity = false, .scaled = true}};
  for (const Question& question : asked) {
    SCOPED_TRACE(&question - asked);
    const Felt felt = expectTheSame(20, question);
    if (!drawsAll()) continue;
    EXPECT_GT(felt.armed, 5000);
    EXPECT_GT(felt.contact, question.tool ? -1 : 300);
    EXPECT_GT(felt.torque, question.tool ? 300 : -1);
    EXPECT_GT(felt.passivity, question.passivity && !question.tool ? 50 : -1);
  }
}

/** It has as many newtons for its mass; that it falls asleep below a speed of the world is no part of this. */
TEST(MountProperty, AFreeBodyOfAScaledWorldIsPushedAlike) {
  for (const double s : {0.25, 4.0}) {
    const Question asked{.models = false, .passivity = false};
    const Pose X{{0.1, 0.2, 0.3}, Quat(Eigen::AngleAxisd(M_PI_2, Vec3::UnitX()))};
    MountedWorld plain({}, 1, asked), scaled(X, s, asked);
    DeviceSample sample;
    sample.fresh = true;
    int pressed = 0;
    for (int tick = 0; tick < 500; ++tick) {
      sample.p = kBodyAt + Vec3(0.001, 0, 0.015 - 2e-5 * tick);
      for (MountedWorld* world : {&plain, &scaled}) {
        if (tick == 10) world->arm();
        world->alone();
      }
      const DeviceOutput &one = plain.with(sample), &other = scaled.with(sample);
      ASSERT_NEAR((one.command.force - other.command.force).norm(), 0, kSolved);
      ASSERT_NEAR((X * (s * plain.bodyAt()) - scaled.bodyAt()).norm(), 0, s * kSolved);
      pressed += one.command.force.norm() > 0.01 ? 1 : 0;
    }
    EXPECT_GT(pressed, 20);
    EXPECT_GT((plain.bodyAt() - kBodyAt).norm(), 1e-3) << "it has made way";
  }
}

/** What a tool or a model is given by others is known by axis alone: where axes become axes, that is exact. */
TEST(MountProperty, QuarterTurnsFeelTheSameWithAllThereIs) {
  for (const auto& [tool, models] : {std::pair{false, true}, {true, true}, {true, false}}) {
    const Felt felt = expectTheSame(20, {.tool = tool, .models = models, .quarters = true});
    if (!drawsAll()) continue;
    EXPECT_GT(felt.armed, 5000);
    EXPECT_GT(felt.contact, 300);
    EXPECT_GT(felt.passivity, models ? 50 : 0);
  }
}

}  // namespace
}  // namespace hapticd
