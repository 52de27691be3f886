// The property of where a recording begins: at any moment of a busy session nothing that was asked for is lost, and the
// replay gives what was sent, bit for bit.
#include <gtest/gtest.h>

#include <array>
#include <map>
#include <string>
#include <vector>

#include "tests/recording/script.h"
#include "tests/recording/taken.h"
#include "tests/support/for_seeds.h"

namespace hapticd::test {
namespace {

/** A script in which hands hold tools, are fingers, are off their points, and objects move freely. */
class Busy : public Script {
 public:
  explicit Busy(unsigned seed) : Script(seed), settings_(seed + 1) {
    (void)bench.core.scene().setGravity({0, 0, -9.81});
    for (ScriptedDevice* device : bench.scripted) device->setButtons(1);  // What holds a clutch.
  }

  void run(int ticks) {
    for (int i = 0; i < ticks; ++i) {
      if (random.once(3)) act();
      if (settings_.once(10)) arrange();
      step();
    }
  }
  /** Until no device is armed. */
  void lower() {
    for (const auto& device : bench.core.devices().devices()) {
      if (device->lease != 0) (void)bench.core.disarm(device->lease);
    }
    for (int i = 0; i < 1200 && armed(); ++i) step();
  }
  [[nodiscard]] bool armed() { return cycle().deviceGuard(0).armed() || cycle().deviceGuard(1).armed(); }
  [[nodiscard]] const Cycle& cycle() { return bench.core.devices().links().front()->group().servo().cycle(); }

 private:
  /** Not a mesh: as tools and bodies these take their time. */
  [[nodiscard]] std::string object() {
    auto names = bench.core.scene().names();
    std::erase_if(names, [](const std::string& name) { return name[0] == 'm'; });
    return names[static_cast<std::size_t>(settings_.below(static_cast<int>(names.size())))];
  }

  /** One setting of a device or an object. Some are refused. */
  void arrange() {
    Random& r = settings_;
    Core& core = bench.core;
    const Client root = core.client(bench.administration);
    OpenDevice& device = bench.device(static_cast<std::size_t>(r.below(2)));
    switch (r.below(12)) {
      case 0:
        return (void)core.attachTool(device, {object(), r.in(0.05, 0.3), 0, r.once(2), r.once(3)}, root);
      case 1:
        return (void)core.detachTool(device, root);
      case 2: {
        SetFinger finger{};
        if (!r.once(3)) {
          finger.law = static_cast<std::uint32_t>(PadLaw::kLinear);
          finger.arm = 0.004;
          finger.radius = 0.008;
          finger.stiffness = r.in(0.01, 0.1);
          finger.damping = 1;
          finger.cue = r.once(2) ? 1 : 0;
        }
        return (void)core.setFinger(device, finger, root);
      }
      case 3:
      case 4:
      case 5:
        return (void)core.setClutch(device, r.once(2), r.once(3) ? 1 : 0, root);
      case 6:
        return (void)core.setScale(device, r.in(0.5, 2), root);
      case 7:
        return (void)core.setRadius(device, r.once(2) ? 0 : r.in(0, 0.01), root);
      case 8:
        return (void)core.setGrip(device, r.once(2) ? 0 : r.in(1, 5), 0.3, root);
      case 9: {
        BodySpec body;
        body.mass = r.once(3) ? 0 : r.in(0.05, 0.5);
        return (void)core.scene().setBody(object(), body);
      }
      case 10: {
        EffectSpec effect;
        effect.kind = static_cast<EffectKind>(r.below(5));
        effect.duration_s = r.once(2) ? 0 : r.in(0.1, 1);
        return (void)core.scene().setEffect(object(), effect, bench.clock.now());
      }
      default: {
        SurfaceSpec surface;
        surface.transient_gain = r.in(0, 10);
        surface.smooth_deg = r.in(0, 40);
        return (void)core.scene().setSurface(object(), surface);
      }
    }
  }

  Random settings_;
};

std::array<double, 7> bits(const Pose& X) { return {X.p.x(), X.p.y(), X.p.z(), X.q.w(), X.q.x(), X.q.y(), X.q.z()}; }

template <class T>
std::string bytes(const T& x) {
  return {reinterpret_cast<const char*>(&x), sizeof x};
}

void compareDevice(const Cycle& was, const Cycle& is, std::uint32_t d) {
  SCOPED_TRACE("device " + std::to_string(d));
  EXPECT_EQ(bits(is.mount(d).pose()), bits(was.mount(d).pose()));
  EXPECT_EQ(is.mount(d).scale(), was.mount(d).scale());
  EXPECT_EQ(bytes(is.clutch(d).order(d)), bytes(was.clutch(d).order(d)));
  EXPECT_EQ(is.deviceRadius(d), was.deviceRadius(d));
  EXPECT_EQ(is.finger(d).soft(), was.finger(d).soft());
  if (was.finger(d).soft()) {
    EXPECT_EQ(bytes(is.finger(d).order()), bytes(was.finger(d).order()));
  }
  EXPECT_EQ(is.grip(d).stiffness, was.grip(d).stiffness);
  // A hand lets go of what is gone in its next tick with a reading.
  const bool held = was.tool(d).held() && was.scene().find(was.tool(d).order().object) != nullptr;
  EXPECT_EQ(is.tool(d).held(), held);
  if (held) {
    EXPECT_EQ(bytes(is.tool(d).order()), bytes(was.tool(d).order()));
  }
  EXPECT_EQ(is.deviceGuard(d).fault(), was.deviceGuard(d).fault());
  EXPECT_EQ(is.deviceGuard(d).heat(), was.deviceGuard(d).heat());
  EXPECT_EQ(is.deviceGuard(d).limits().force, was.deviceGuard(d).limits().force);
}

void compareScene(const Cycle& was, const Cycle& is) {
  EXPECT_EQ(is.bodies().gravity(), was.bodies().gravity());
  ASSERT_EQ(is.scene().used().size(), was.scene().used().size());
  for (const std::uint16_t slot : was.scene().used()) {
    SCOPED_TRACE("slot " + std::to_string(slot));
    const SceneObject &a = was.scene().slot(slot), &b = is.scene().slot(slot);
    EXPECT_EQ(b.id, a.id);
    EXPECT_EQ(b.parent, a.parent);
    EXPECT_EQ(b.flags, a.flags);
    EXPECT_LT((b.X_PO.p - a.X_PO.p).norm() + b.X_PO.q.angularDistance(a.X_PO.q), 1e-12);
    EXPECT_LT((b.V_PO.v - a.V_PO.v).norm() + (b.V_PO.w - a.V_PO.w).norm(), 1e-12);
    EXPECT_EQ(b.shape.kind, a.shape.kind);
    EXPECT_EQ(b.shape.mesh, a.shape.mesh);
    EXPECT_EQ(bytes(b.material), bytes(a.material));
    EXPECT_EQ(bytes(b.surface.parameters), bytes(a.surface.parameters));
  }
  const auto effects = [](const Scene& scene) {
    std::map<std::uint16_t, std::string> all;
    for (const std::uint16_t slot : scene.effects()) all[slot] = bytes(scene.effect(slot));
    return all;
  };
  EXPECT_EQ(effects(is.scene()), effects(was.scene()));
}

/** A model whose frame is gone ends in the next tick. */
bool isOfWhatIsGone(const Command& command, const Scene& scene) {
  std::uint32_t frame = 0;
  if (command.kind == CommandKind::kLocalModel) frame = command.as<hd_local_model>().frame;
  if (command.kind == CommandKind::kForceField) frame = command.as<hd_force_field>().frame;
  return frame != 0 && scene.find(frame) == nullptr;
}

void compareSessions(const Cycle& was, const Cycle& is, std::int64_t now_ns) {
  for (std::uint32_t slot = 0; slot < kMaxSessions; ++slot) {
    SCOPED_TRACE("session " + std::to_string(slot));
    const SessionShare &a = was.session(slot), &b = is.session(slot);
    EXPECT_EQ(b.life(), a.life());
    EXPECT_EQ(b.id(), a.id());
    EXPECT_EQ(b.appliedSeq(), a.appliedSeq());
    std::vector<Command> asked, given;
    a.restate(now_ns, asked);
    b.restate(now_ns, given);
    std::erase_if(asked, [&](const Command& model) { return isOfWhatIsGone(model, was.scene()); });
    ASSERT_EQ(given.size(), asked.size());
    for (std::size_t i = 0; i < asked.size(); ++i) EXPECT_EQ(bytes(given[i]), bytes(asked[i]));
  }
  ASSERT_EQ(is.pending().size(), was.pending().size());
  for (std::size_t i = 0; i < was.pending().size(); ++i) EXPECT_EQ(bytes(is.pending()[i]), bytes(was.pending()[i]));
}

struct Seen {
  int tools = 0, fingers = 0, frozen = 0;
  long pressed = 0;
};

void recordAtMoments(unsigned seed, Seen& seen) {
  Busy script(seed);
  for (int moment = 0; moment < 3; ++moment) {
    script.run(200 + script.random.below(600));
    script.lower();
    script.run(script.random.below(20));
    if (script.armed()) continue;
    const auto was = std::make_unique<Cycle>(script.cycle());
    for (std::uint32_t d = 0; d < 2; ++d) {
      seen.tools += was->tool(d).held() ? 1 : 0;
      seen.fingers += was->finger(d).soft() ? 1 : 0;
      seen.frozen += was->clutch(d).frozen() ? 1 : 0;
    }
    const std::int64_t now_ns = script.bench.core.devices().links().front()->group().servo().lastInput().now_ns;
    Taken taken(script.bench);
    for (std::uint32_t d = 0; d < 2; ++d) compareDevice(*was, script.cycle(), d);
    compareScene(*was, script.cycle());
    compareSessions(*was, script.cycle(), now_ns);
    script.pressed = 0;
    script.run(600);
    seen.pressed += script.pressed;
    const auto replayer = replayerOf(taken.finish([&] { script.step(); }));
    ASSERT_NE(replayer, nullptr);
    const auto verdict = verify(*replayer);
    ASSERT_TRUE(verdict.ok()) << toString(verdict.error());
    EXPECT_EQ(verdict->differing, 0u) << verdict->first;
    if (testing::Test::HasFailure()) return;
  }
}

TEST(RecordingFromAnyMoment, LosesNothingAndIsReplayedBitForBit) {
  Seen seen;
  forSeeds(4, [&](unsigned seed) { recordAtMoments(seed, seen); });
  if (drawsAll()) {
    EXPECT_GT(seen.tools, 0);
    EXPECT_GT(seen.fingers, 0);
    EXPECT_GT(seen.frozen, 0);
    EXPECT_GT(seen.pressed, 100);
  }
}

}  // namespace
}  // namespace hapticd::test
