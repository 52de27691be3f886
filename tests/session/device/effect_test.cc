// Effects by resource names: what is set is felt, what cannot be is refused, and what has a time ends by it.
#include <gmock/gmock.h>

#include <array>
#include <nlohmann/json.hpp>

#include "daemon/resource/resource_tree.h"
#include "tests/session/bench.h"

namespace hapticd::test {
namespace {

using ::testing::HasSubstr;

class EffectBench : public ::testing::Test {
 protected:
  EffectBench() {
    ObjectSpec spec;
    spec.name = "hint";
    EXPECT_TRUE(bench.core.scene().create(spec, anybody).ok());
    bench.scripted[0]->sample.p = {0.005, 0, 0};
    const Session* session = bench.live(bench.administration);
    EXPECT_TRUE(bench.arm(session->id).ok());
    bench.step(40);
  }
  Result<std::string> set(const std::string& what) { return tree.set("/objects/hint/" + what, anybody); }
  Vec3 felt(int ticks = 30) {
    bench.step(ticks);
    const hd_sample s = bench.sample();
    return {s.by_source[HD_SOURCE_EFFECT][0], s.by_source[HD_SOURCE_EFFECT][1], s.by_source[HD_SOURCE_EFFECT][2]};
  }

  Bench bench;
  Client anybody = bench.core.client(bench.administration);
  ResourceTree tree{bench.core};
};

TEST_F(EffectBench, WhatIsSetIsFeltAndToldAgain) {
  EXPECT_EQ(*tree.get("/objects/hint/effect", anybody), "\"none\"");
  EXPECT_EQ(felt().norm(), 0);
  EXPECT_EQ(*set("effect?value=guide"), "\"guide\"");
  EXPECT_NEAR(felt().x(), -1, 1e-6) << "200 N/m and 1 N unless told otherwise";
  EXPECT_EQ(*set("effect_stiffness?value=100"), "100.0");
  EXPECT_NEAR(felt().x(), -0.5, 1e-6);
  EXPECT_EQ(*set("effect_path?value=0,-0.1,0.002,0,0.1,0.002,0.05,0.1,0.002"),
            "[[0.0,-0.1,0.002],[0.0,0.1,0.002],[0.05,0.1,0.002]]");
  EXPECT_GT(felt().z(), 0.1);
  EXPECT_EQ(*set("effect_path?value=none"), "[]");
  EXPECT_NEAR(felt().x(), -0.5, 1e-6);
  EXPECT_EQ(*set("effect?value=none"), "\"none\"");
  EXPECT_EQ(felt().norm(), 0);
  EXPECT_EQ(*tree.get("/objects/hint/effect_stiffness", anybody), "100.0") << "it stays for the next time";
}

TEST_F(EffectBench, AllOfItIsSetAtOnceOrNothing) {
  EXPECT_EQ(*set("effect?value=guide,force=4,stiffness=100,damping=0,reach=0.05,hz=50,duration_s=0,path=none"),
            "\"guide\"");
  EXPECT_NEAR(felt().x(), -0.5, 1e-6);
  EXPECT_EQ(*tree.get("/objects/hint/effect_hz", anybody), "50.0");
  EXPECT_EQ(*set("effect?value=guide,path=0,-0.1,0.002,0,0.1,0.002"), "\"guide\"");
  EXPECT_EQ(*tree.get("/objects/hint/effect_path", anybody), "[[0.0,-0.1,0.002],[0.0,0.1,0.002]]");
  EXPECT_EQ(*tree.get("/objects/hint/effect_force", anybody), "4.0") << "what is not named stays";
  EXPECT_EQ(*set("effect?value= guide , hz=60, path=0,-0.1,0.002, 0,0.1,0.002 "), "\"guide\"") << "blanks say nothing";
  EXPECT_EQ(*tree.get("/objects/hint/effect_hz", anybody), "60.0");
  EXPECT_EQ(*tree.get("/objects/hint/effect_path", anybody), "[[0.0,-0.1,0.002],[0.0,0.1,0.002]]");
  for (const auto& [wrong, where, says] : {std::array{"guide,force=1,stiff=3", "/effect", "'stiff=3' is no field"},
                                           {"guide,force", "/effect", "'force' is no field"},
                                           {"guide,force=1,hz=fast", "/effect.hz", "'fast'"},
                                           {"guide,force=1,reach=0", "effect.reach", "0.001"},
                                           {"guide,force=1,path=1,2", "/effect.path", "2 numbers"},
                                           {"guide,force=1,,", "/effect", "'' is no field"},
                                           {"drag,force=1", "/effect", "'drag' is no effect"}}) {
    const auto answer = set(std::string("effect?value=") + wrong);
    ASSERT_FALSE(answer.ok()) << wrong;
    EXPECT_EQ(answer.error().code, ErrorCode::kInvalidArgument) << wrong;
    EXPECT_THAT(answer.error().where, HasSubstr(where)) << wrong;
    EXPECT_THAT(toString(answer.error()), HasSubstr(says)) << wrong;
    EXPECT_EQ(*tree.get("/objects/hint/effect_force", anybody), "4.0") << wrong;
  }
}

TEST_F(EffectBench, WhatIsWrongIsRefusedByItsNameAndChangesNothing) {
  ASSERT_TRUE(set("effect?value=guide").ok());
  const Vec3 before = felt();
  const auto refused = [&](const std::string& what, const std::string& where, const std::string& says) {
    const auto answer = set(what);
    ASSERT_FALSE(answer.ok()) << what;
    EXPECT_EQ(answer.error().code, ErrorCode::kInvalidArgument);
    EXPECT_THAT(toString(answer.error()), HasSubstr(where));
    EXPECT_THAT(toString(answer.error()), HasSubstr(says));
  };
  refused("effect?value=magnet", "/objects/hint/effect", "none, force, viscous, friction, vibration or guide");
  refused("effect_force?value=-1", "effect.force", "between 0 and 1000 N");
  refused("effect_stiffness?value=1e6", "effect.stiffness", "N/m");
  refused("effect_damping?value=1e6", "effect.damping", "N s/m");
  refused("effect_reach?value=0", "effect.reach", "0.001");
  refused("effect_hz?value=401", "effect.hz", "400");
  refused("effect_duration_s?value=1e9", "effect.durationS", "3600");
  refused("effect_path?value=1,2,3", "effect.path", "1 point;");
  refused("effect_path?value=1,2,3,4", "/objects/hint/effect_path", "4 numbers");
  refused("effect_path?value=1,2,3,4,5,1000", "effect.path", "point 2");
  std::string long_path = "effect_path?value=0,0,0";
  for (std::uint32_t i = 0; i < kMaxPathPoints; ++i) long_path += ",0,0,0";
  refused(long_path, "effect_path", "99 numbers");
  EXPECT_EQ(felt(), before);
}

TEST_F(EffectBench, OneWithADurationEndsAndBeginsAnewWhenItIsSet) {
  ASSERT_TRUE(set("effect_duration_s?value=0.1").ok());
  ASSERT_TRUE(set("effect?value=force").ok());
  EXPECT_NEAR(felt(50).z(), 1, 1e-6);
  EXPECT_NEAR(felt(80).z(), 0, 1e-6);
  // A servo that comes now is told when it ended.
  const auto orders = bench.core.scene().orders(*bench.core.devices().links().front());
  const auto it =
      std::find_if(orders.begin(), orders.end(), [](const Command& c) { return c.kind == CommandKind::kSetEffect; });
  ASSERT_NE(it, orders.end());
  EXPECT_LT(it->as<SetEffect>().effect.until_ns, bench.clock.now());
  EXPECT_GT(it->as<SetEffect>().effect.until_ns, 0);
  ASSERT_TRUE(set("effect?value=force").ok());
  EXPECT_NEAR(felt(50).z(), 1, 1e-6);
}

TEST_F(EffectBench, OneThatHasEndedGivesItsPlaceToAnother) {
  const auto& effects = bench.core.devices().links().front()->group().servo().cycle().scene();
  for (std::uint32_t i = 0; i < 3 * kMaxEffects; ++i) {
    ObjectSpec spec;
    spec.name = "e" + std::to_string(i);
    ASSERT_TRUE(bench.core.scene().create(spec, anybody).ok());
    const std::string object = "/objects/" + spec.name;
    ASSERT_TRUE(tree.set(object + "/effect_duration_s?value=0.02", anybody).ok());
    const auto answer = tree.set(object + "/effect?value=force", anybody);
    ASSERT_TRUE(answer.ok()) << i << ": " << toString(answer.error());
    const double z = felt(15).z();
    EXPECT_GT(z, 0.3) << "it is felt, for the servo has room for it";
    EXPECT_LT(z, 2.1);
    bench.step(10);
    EXPECT_LE(effects.effects().size(), kMaxEffects);
  }
  EXPECT_EQ(*tree.get("/objects/e0/effect", anybody), "\"none\"");
  EXPECT_EQ(*tree.get("/objects/e0/effect_duration_s", anybody), "0.02") << "its numbers are kept";
}

TEST_F(EffectBench, NoMoreObjectsHaveOneThanAServoKeepsUpWith) {
  for (std::uint32_t i = 0; i <= kMaxEffects; ++i) {
    ObjectSpec spec;
    spec.name = "e" + std::to_string(i);
    ASSERT_TRUE(bench.core.scene().create(spec, anybody).ok());
    const auto answer = tree.set("/objects/" + spec.name + "/effect?value=viscous", anybody);
    ASSERT_EQ(answer.ok(), i < kMaxEffects);
    if (!answer.ok()) {
      EXPECT_EQ(answer.error().code, ErrorCode::kQuotaExceeded);
    }
  }
  ASSERT_TRUE(bench.core.scene().remove("e0", anybody).ok());
  EXPECT_TRUE(tree.set("/objects/e" + std::to_string(kMaxEffects) + "/effect?value=viscous", anybody).ok());
  bench.step(10);
  EXPECT_EQ(bench.core.devices().links().front()->group().servo().cycle().scene().effects().size(), kMaxEffects);
}

}  // namespace
}  // namespace hapticd::test
