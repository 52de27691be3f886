// The whole cycle under random clients, objects, orders and hands: what the
// guard promises still holds, and what a lost client leaves behind only falls.
#include <gtest/gtest.h>

#include <array>
#include <memory>

#include "rt/cycle/cycle.h"
#include "tests/support/for_seeds.h"
#include "tests/support/stepped/solid.h"

namespace hapticd {
namespace {

constexpr std::int64_t kPeriod = 1'000'000;
constexpr std::uint32_t kDevices = 2;
constexpr std::uint32_t kSessions = 4;

CycleConfig config() {
  CycleConfig c;
  c.device_count = kDevices;
  for (GuardConfig& g : c.guard) {
    g.limits = {6, 0.3, 800, 40, 4, 3, 10, 5};
    g.ramp_ns = 50'000'000;
    g.small_force = 3;  // Else the random world would seldom let the ramp begin.
    g.energy_limit = 2;
  }
  return c;
}

class World {
 public:
  explicit World(unsigned seed) : random(seed), cycle_(std::make_unique<Cycle>(config(), meshes_)) {
    input = std::make_unique<CycleInput>();
    output = std::make_unique<CycleOutput>();
  }

  /** One tick with the commands put so far. */
  void step() {
    ++input->tick;
    input->now_ns += kPeriod;
    for (std::uint32_t d = 0; d < kDevices; ++d) {
      hand_[d].v = 0.98 * hand_[d].v + random.vector(0.02) - 2 * (hand_[d].p);
      hand_[d].p += 1e-3 * hand_[d].v;
      DeviceSample& sample = input->device[d];
      sample = DeviceSample{};
      sample.t_ns = input->now_ns;
      sample.p = hand_[d].p;
      sample.fresh = !random.once(10);
    }
    if (trouble) sampleTrouble();
    must_stop = input->stop_line || input->deadman_open || input->missed >= 50;
    cycle_->step(*input, *output);
    input->command_count = 0;
    input->missed = 0;
    input->stop_line = input->deadman_open = false;
  }

  template <class T>
  void put(CommandKind kind, const T& payload, std::uint32_t session = kControlSession) {
    if (input->command_count == kMaxCommandsPerCycle) return;
    Command& c = input->command[input->command_count++] = makeCommand(kind, payload, session);
    c.seq = ++seq_;
  }
  void session(CommandKind kind, std::uint32_t slot) { put(kind, SessionRef{slot, 0, slot + 1}); }
  void device(CommandKind kind, std::uint32_t d) { put(kind, DeviceRef{d}); }

  void client(std::uint32_t slot) {
    if (random.once(3)) {
      hd_client_force f{};
      f.device = static_cast<std::uint32_t>(random.below(kDevices));
      f.lease_ns = random.below(300) * kPeriod;
      store(random.vector(random.once(10) ? 1000 : 2), f.force);
      store(random.vector(0.2), f.torque);
      put(CommandKind::kClientForce, f, slot);
      return;
    }
    if (random.once(10)) {
      put(CommandKind::kClearModel, hd_clear_model{static_cast<std::uint32_t>(random.below(3)), 0, 0}, slot);
      return;
    }
    if (random.once(10)) {
      put(CommandKind::kLimits, hd_limits{random.in(0, 5), random.in(0, 1)}, slot);
      return;
    }
    hd_local_model m{};
    m.slot = static_cast<std::uint32_t>(random.below(3));
    m.device = static_cast<std::uint32_t>(random.below(kDevices));
    m.kind = static_cast<std::uint32_t>(1 + random.below(3));
    m.lease_ns = random.below(300) * kPeriod;
    m.blend_ns = random.below(20) * kPeriod;
    m.material = {random.in(0, 1500), random.in(0, 4), 0.8, 0.5};
    store(random.vector(0.01), m.origin);
    m.normal[random.below(3)] = random.once(2) ? 1 : -1;
    m.radius = random.in(0.005, 0.03);
    put(CommandKind::kLocalModel, m, slot);
  }

  void addBall(std::uint32_t slot) {
    const Pose X{random.vector(0.03), Quat::Identity()};
    put(CommandKind::kAddObject,
        test::solid(makeObjectId(slot, 1), ShapeKind::kSphere, {800, 1, 0.6, 0.4}, X, {0.01, 0, 0}));
  }
  void moveBall(std::uint32_t slot) {
    const Pose X{random.vector(0.03), Quat::Identity()};
    put(CommandKind::kObjectPose, poseMessage(makeObjectId(slot, 1), X, {random.vector(0.05), Vec3::Zero()}));
  }

  /** The collide thread's answer for a tool or body, sometimes a lie. */
  void contacts(std::uint32_t device, std::uint32_t object) {
    ToolContacts found{};
    found.device = device;
    found.object = object;
    found.tick = input->tick;
    found.count = static_cast<std::uint32_t>(random.below(random.once(20) ? 17 : 15));
    for (std::uint32_t i = 0; i < std::min(found.count, ToolContacts::kMost); ++i) {
      ToolContacts::Point& p = found.point[i];
      const Vec3 at = random.vector(0.01), n = random.vector(1).normalized();
      for (int k = 0; k < 3; ++k) {
        p.p_A[k] = static_cast<float>(at[k]);
        p.n_B[k] = static_cast<float>(n[k]);
      }
      p.offset = static_cast<float>(random.once(200) ? random.wild() : random.in(-0.01, 0.02));
      p.key = static_cast<std::uint32_t>(random.below(5)) << 24 | (i + 1);
    }
    put(CommandKind::kToolContacts, found);
  }
  void tool(std::uint32_t d) {
    AttachTool order{};
    order.device = d;
    order.object = makeObjectId(static_cast<std::uint32_t>(1 + random.below(4)), 1);
    order.shows_torque = static_cast<std::uint32_t>(random.below(2));
    order.flags = static_cast<std::uint32_t>(random.below(4));
    order.mass = random.once(30) ? random.broken() : random.in(0.01, 1);
    for (int i = 0; i < 3; ++i) order.inertia[i] = 1e-4 * order.mass;
    order.outer = order.stiffness = random.in(0, 4000);
    order.damping = random.in(0, 20);
    order.angular_outer = order.angular_stiffness = random.in(0, 4);
    order.angular_damping = random.in(0, 0.02);
    put(CommandKind::kAttachTool, order);
  }
  void body(std::uint32_t slot) {
    SetBody order{};
    order.object = makeObjectId(slot, 1);
    order.falls = 1;
    order.mass = random.once(4) ? 0 : random.once(30) ? random.wild() : random.in(0.005, 2);
    for (double& i : order.inertia) i = 0;
    for (int i = 0; i < 3; ++i) order.inertia[i] = 1e-4 * order.mass;
    order.damping = random.in(0, 5);
    put(CommandKind::kSetBody, order);
  }
  /** Where a device stands, and how large: anywhere, seldom nowhere. */
  void mount(std::uint32_t d) {
    SetMount order{d, 0, {}, {}, random.once(2) ? 1 : std::exp(random.in(-4.6, 4.6))};
    if (random.once(10)) order.scale = random.once(2) ? random.wild() : random.broken();
    const Pose X = random.once(3) ? Pose{} : random.pose(0.05);
    store(X.p, order.p);
    store(X.q, order.q);
    if (random.once(10)) order.p[random.below(3)] = random.wild();
    if (random.once(10)) order.q[random.below(4)] = random.broken();
    put(CommandKind::kSetMount, order);
  }
  /** What touches: a fingertip, or a point again. */
  void finger(std::uint32_t d) {
    SetFinger order{d,
                    random.below(7u),
                    random.below(2u),
                    random.below(2u),
                    random.in(0, 0.02),
                    random.in(0, 0.02),
                    random.in(0, 1),
                    random.in(0, 20),
                    random.in(0, 10)};
    if (random.once(20)) order.stiffness = random.wild();
    if (random.once(20)) order.arm = random.broken();
    put(CommandKind::kSetFinger, order);
  }
  void effect(std::uint32_t slot) {
    SetEffect order{};
    order.object = makeObjectId(slot, 1);
    EffectParameters& e = order.effect;
    e.kind = random.below(7u);
    e.force = random.once(30) ? random.wild() : random.in(0, 5);
    e.stiffness = random.in(0, 1000);
    e.damping = random.in(0, 10);
    e.reach = random.in(0, 0.05);
    e.frequency = random.in(0, 400);
    e.until_ns = random.once(3) ? input->now_ns + random.below(200) * kPeriod : 0;
    e.points = random.below(6u);
    for (std::uint32_t i = 0; i < e.points; ++i)
      for (float& x : e.path[i]) x = static_cast<float>(random.in(-0.03, 0.03));
    put(CommandKind::kSetEffect, order);
  }

  Random random;
  bool trouble = false;
  bool tools = false;      ///< Hands hold objects, and objects move freely.
  bool mounts = false;     ///< Devices are set up elsewhere, or somebody tries to.
  bool clutches = false;   ///< Hands are taken off their points.
  bool must_stop = false;  ///< The last step had a cause for both devices.
  std::unique_ptr<CycleInput> input;
  std::unique_ptr<CycleOutput> output;
  [[nodiscard]] const Cycle& cycle() const { return *cycle_; }

 private:
  struct Hand {
    Vec3 p = Vec3::Zero(), v = Vec3::Zero();
  };
  void sampleTrouble() {
    if (random.once(500)) input->stop_line = true;
    if (random.once(500)) input->deadman_open = true;
    if (random.once(500)) input->missed = static_cast<std::uint32_t>(random.below(80));
    DeviceSample& sample = input->device[random.below(kDevices)];
    if (random.once(500)) sample.status = kDeviceError;
    if (random.once(500)) sample.p[random.below(3)] = random.broken();
    if (random.once(500)) sample.p[random.below(3)] = random.wild();
    if (random.once(500)) sample.q.coeffs()[random.below(4)] = random.broken();
  }

  MeshTable meshes_;
  std::unique_ptr<Cycle> cycle_;
  std::array<Hand, kDevices> hand_;
  std::uint64_t seq_ = 0;
};

void disturbTools(World& w) {
  for (std::uint32_t d = 0; d < kDevices; ++d) {
    if (w.random.once(400)) w.tool(d);
    if (w.random.once(1000)) w.device(CommandKind::kDetachTool, d);
    if (w.random.once(3) && w.cycle().tool(d).held()) w.contacts(d, w.cycle().tool(d).order().object);
    // Up to 8 N: while it is more than 3 N, no ramp begins.
    if (w.random.once(300)) w.put(CommandKind::kSetGrip, SetGrip{d, 0, w.random.in(0, 40), w.random.in(0, 0.2)});
  }
  for (std::uint32_t b = 1; b <= 3; ++b) {
    if (w.random.once(300)) w.body(b);
  }
  const std::uint8_t moving = w.cycle().bodies().find(static_cast<std::uint32_t>(1 + w.random.below(3)));
  if (moving != FreeBodies::kNone) {
    w.contacts(kMaxDevices + moving, makeObjectId(static_cast<std::uint32_t>(1 + w.random.below(3)), 1));
  }
  if (w.random.once(500)) {
    SetGravity gravity{};
    store(w.random.once(10) ? w.random.wildVector() : w.random.vector(10), gravity.g);
    w.put(CommandKind::kSetGravity, gravity);
  }
}

/** Puts a tick's worth of random orders. Session 3 is left to the caller. */
void disturb(World& w) {
  if (w.tools) disturbTools(w);
  for (std::uint32_t s = 0; s < kSessions; ++s) {
    if (w.random.once(30)) w.client(s);
  }
  for (std::uint32_t b = 1; b <= 3; ++b) {
    if (w.random.once(60)) w.moveBall(b);
  }
  for (std::uint32_t d = 0; d < kDevices; ++d) {
    if (w.random.once(100)) w.device(CommandKind::kArm, d);
    if (w.random.once(1500)) w.device(CommandKind::kDisarm, d);
    if (w.random.once(3000)) w.device(CommandKind::kStop, d);
    if (w.mounts && w.random.once(100)) w.mount(d);
    if (w.random.once(300)) w.finger(d);
    if (w.clutches && w.random.once(100))
      w.put(CommandKind::kSetClutch, SetClutch{d, w.random.below(2u), w.random.below(35u), 0, {}});
    if (w.random.once(300)) {
      w.put(CommandKind::kDeviceLimits,
            DeviceLimits{d, static_cast<std::uint32_t>(w.random.in(0, 2)), w.random.in(0, 8), w.random.in(0, 0.4),
                         w.random.in(0, 1500), w.random.in(0, 50), 3, w.random.in(0, 10), w.random.in(0, 10),
                         w.random.in(0, 5)});
    }
  }
  for (std::uint32_t s = 0; s < kSessions - 1; ++s) {
    if (w.random.once(400)) w.session(CommandKind::kLoseSession, s);
    if (w.random.once(400)) w.session(CommandKind::kReviveSession, s);
  }
  if (w.random.once(100)) w.effect(1 + w.random.below(3u));
}

void begin(World& w) {
  for (std::uint32_t s = 0; s < kSessions; ++s) w.session(CommandKind::kAddSession, s);
  for (std::uint32_t b = 1; b <= 3; ++b) w.addBall(b);
  w.step();
}

/** What a tick may change: what the slew limit allows or, towards zero, what brings it there in Guard::kFall_s. */
double steepest(const Vec3& from, const Vec3& to, double slew) {
  const double fall = to.norm() < from.norm() ? from.norm() / Guard::kFall_s : 0.0;
  return std::max(slew, fall) * 1e-3;
}

TEST(CycleProperty, GuardsPromisesHoldForTheWholeCycle) {
  int armed = 0, faults = 0, together = 0, gripped = 0, effects = 0, mounted = 0, turned = 0, clutched = 0;
  forSeeds(20, [&](unsigned seed) {
    World w(seed);
    w.trouble = seed % 2 == 0;
    w.tools = seed % 4 > 1;
    w.mounts = seed % 3 == 0;
    w.clutches = seed % 5 < 3;
    begin(w);
    std::array<DeviceCommand, kDevices> last;
    for (int tick = 0; tick < 3000; ++tick) {
      SCOPED_TRACE(tick);
      disturb(w);
      std::array<GuardLimits, kDevices> before;
      for (std::uint32_t d = 0; d < kDevices; ++d) before[d] = w.cycle().deviceGuard(d).limits();
      w.step();
      together += w.cycle().bodies().joint().movers() > 1 ? 1 : 0;
      for (std::uint32_t d = 0; d < kDevices; ++d) {
        const DeviceCommand& now = w.output->device[d].command;
        const GuardOutput& guard = w.output->device[d].guard;
        const GuardLimits& limits = w.cycle().deviceGuard(d).limits();
        turned += now.enabled && w.cycle().finger(d).turning() ? 1 : 0;
        mounted += now.enabled && !w.cycle().mount(d).identity() ? 1 : 0;
        clutched += now.enabled && w.cycle().clutch(d).frozen() ? 1 : 0;
        ASSERT_LE(now.force.norm(), limits.force);
        ASSERT_LE(now.torque.norm(), limits.torque);
        ASSERT_LE(std::abs(now.gripper_force), limits.gripper_force);
        gripped += now.gripper_force > 0.5 ? 1 : 0;
        effects += guard.by_source[HD_SOURCE_EFFECT].norm() > 0.1 ? 1 : 0;
        Vec3 sum = Vec3::Zero();
        for (const Vec3& part : guard.by_source) sum += part;
        ASSERT_EQ(sum, now.force);
        if (now.enabled) {
          ++armed;
          ASSERT_FALSE(w.must_stop);
          ASSERT_EQ(guard.fault, std::uint32_t{HD_FAULT_NONE});
          const bool fell = now.force.isZero(0) && now.torque.isZero(0);  // A lowering whose second was over.
          if (limits.force >= before[d].force && !fell) {
            ASSERT_LE((now.force - last[d].force).norm(), steepest(last[d].force, now.force, limits.force_slew));
          }
          if (limits.torque >= before[d].torque && !fell) {
            ASSERT_LE((now.torque - last[d].torque).norm(), steepest(last[d].torque, now.torque, limits.torque_slew));
          }
        } else {
          ASSERT_TRUE(now.force.isZero(0) && now.torque.isZero(0) && now.gripper_force == 0);
        }
        faults += guard.fault != HD_FAULT_NONE && last[d].enabled;
        last[d] = now;
      }
    }
  });
  if (drawsAll()) {
    EXPECT_GT(armed, 20'000);
    EXPECT_GT(faults, 20);
    EXPECT_GT(together, 500);
    EXPECT_GT(gripped, 1000);
    EXPECT_GT(effects, 1000);
    EXPECT_GT(mounted, 1000);
    EXPECT_GT(turned, 100);
    EXPECT_GT(clutched, 1000);
  }
}

TEST(CycleProperty, ALostClientsShareOnlyFallsAndIsGoneInTime) {
  int meaningful = 0;
  forSeeds(40, [&](unsigned seed) {
    World w(seed);
    begin(w);
    for (int i = 0; i < 10; ++i) w.client(3);
    for (int tick = 0; tick < 100; ++tick) {
      disturb(w);
      w.step();
    }
    w.session(CommandKind::kLoseSession, 3);
    std::array<double, kDevices> last;
    for (std::uint32_t d = 0; d < kDevices; ++d) {
      last[d] = w.cycle().session(3).last(d).norm();
      meaningful += last[d] > 0.1;
    }
    for (int tick = 0; tick < 60; ++tick) {
      disturb(w);  // Session 3 goes on sending, too.
      w.step();
      for (std::uint32_t d = 0; d < kDevices; ++d) {
        const double now = w.cycle().session(3).last(d).norm();
        ASSERT_LE(now, last[d] * (1 + 1e-12)) << "tick " << tick;
        if (tick >= 50) {
          ASSERT_EQ(now, 0);
        }
        last[d] = now;
      }
    }
  });
  if (drawsAll()) {
    EXPECT_GT(meaningful, 20);
  }
}

TEST(CycleProperty, SameInputsSameBits) {
  forSeeds(5, [&](unsigned seed) {
    World a(seed), b(seed);
    a.trouble = b.trouble = true;
    a.tools = b.tools = seed % 2 == 0;
    a.mounts = b.mounts = seed % 2 == 1;
    begin(a);
    begin(b);
    for (int tick = 0; tick < 1000; ++tick) {
      disturb(a);
      disturb(b);
      a.step();
      b.step();
      for (std::uint32_t d = 0; d < kDevices; ++d) {
        ASSERT_EQ(a.output->device[d].command.force, b.output->device[d].command.force);
        ASSERT_EQ(a.output->device[d].command.torque, b.output->device[d].command.torque);
        ASSERT_EQ(a.output->device[d].guard.flags, b.output->device[d].guard.flags);
      }
    }
  });
}

}  // namespace
}  // namespace hapticd
