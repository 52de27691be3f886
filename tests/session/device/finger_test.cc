// A soft finger, set by name and felt by the servo.
#include "daemon/device/finger_words.h"
#include "daemon/resource/resource_tree.h"
#include "rt/finger/soft_finger.h"
#include "tests/session/bench.h"

namespace hapticd::test {
namespace {

TEST(FingerWords, SayWhatDiffersFromTheUsual) {
  const auto soft = parseFinger("soft", "w");
  ASSERT_TRUE(soft.ok());
  EXPECT_EQ(soft->law, static_cast<std::uint32_t>(PadLaw::kLinear));
  EXPECT_EQ(soft->arm, FingertipConstants::kArm);
  EXPECT_TRUE(SoftFinger::valid(*soft));
  const auto all = parseFinger("viscous-sphere,radius=0.007,stiffness=0.2,damping=0,cue=3,uncoupled,arm=0", "w");
  ASSERT_TRUE(all.ok()) << toString(all.error());
  EXPECT_EQ(fingerLaw(*all), "viscous-sphere");
  EXPECT_EQ(all->radius, 0.007);
  EXPECT_EQ(all->stiffness, 0.2);
  EXPECT_EQ(all->damping, 0);
  EXPECT_EQ(all->cue, 3);
  EXPECT_EQ(all->flags, std::uint32_t{kFingerUncoupled});
  EXPECT_TRUE(SoftFinger::valid(*all));
  for (const char* off : {"", "none"}) {
    const auto point = parseFinger(off, "w");
    ASSERT_TRUE(point.ok()) << off;
    EXPECT_EQ(point->law, 0u) << off;
  }
}

TEST(FingerWords, NameTheWordAtFault) {
  for (const char* words :
       {"hard", "soft,", "soft,arm", "soft,arm=", "soft,arm=x", "soft,arm=-1", "soft,arm=0.2", "soft,radius=0",
        "soft,stiffness=0", "soft,stiffness=101", "soft,damping=nan", "soft,cue=inf", "soft,soft", "uncoupled", ",",
        " soft", "soft,arm=0.01,0.02", "none,arm=0.01"}) {
    const auto refused = parseFinger(words, "here");
    ASSERT_FALSE(refused.ok()) << words;
    EXPECT_EQ(refused.error().code, ErrorCode::kInvalidArgument) << words;
    EXPECT_EQ(refused.error().where, "here") << words;
    EXPECT_FALSE(refused.error().remedy.empty()) << words;
  }
}

TEST(DeviceFinger, IsWrittenReadAndReachesTheServo) {
  Bench bench;
  ResourceTree tree(bench.core);
  OpenDevice& device = *bench.core.devices().devices().front();
  const std::string path = "/devices/" + device.name + "/finger";
  const Client anybody{.uid = 1000};
  EXPECT_EQ(*tree.get(path, anybody), "null");
  const auto set = tree.set(path + "?value=soft,arm=0.008", anybody);
  ASSERT_TRUE(set.ok()) << toString(set.error());
  EXPECT_NE(set->find("\"arm\":0.008"), std::string::npos) << *set;
  bench.step(3);
  SetFinger felt{};
  const auto read = [&](Servo& servo) { felt = servo.cycle().finger(0).order(); };
  ASSERT_TRUE(device.link->group().betweenCycles(read).ok());
  EXPECT_EQ(felt.law, static_cast<std::uint32_t>(PadLaw::kLinear));
  EXPECT_EQ(felt.arm, 0.008);
  EXPECT_EQ(tree.set(path + "?value=wet", anybody).error().where, path);
  const Error far = tree.set(path + "?value=soft,arm=6", anybody).error();
  EXPECT_EQ(toString(far), path + ": arm = 6 is out of range (0 to 0.1 m)");
  EXPECT_NE(tree.get(path, anybody)->find("0.008"), std::string::npos) << "as before";
  ASSERT_TRUE(bench.core.acquireLease(bench.live()->id).ok());
  EXPECT_EQ(tree.set(path + "?value=soft", Client{.uid = 1001}).error().code, ErrorCode::kLeaseHeld);
  ASSERT_TRUE(tree.set(path + "?value=", anybody).ok());
  EXPECT_EQ(*tree.get(path, anybody), "null");
}

TEST(DeviceFinger, OfTheConfigurationIsThereFromTheFirstCycle) {
  Config config = Bench::relaxed();
  config.devices.emplace_back();
  config.devices.back().uri = "test://first";
  config.devices.back().finger = "hertz";
  Bench bench(config, 2);
  std::uint32_t law[2] = {};
  for (std::uint32_t d = 0; d < 2; ++d) {
    const auto read = [&](Servo& servo) { law[d] = servo.cycle().finger(d).order().law; };
    ASSERT_TRUE(bench.device(d).link->group().betweenCycles(read).ok());
  }
  EXPECT_EQ(law[0], static_cast<std::uint32_t>(PadLaw::kHertz));
  EXPECT_EQ(law[1], 0u) << "another device";
}

}  // namespace
}  // namespace hapticd::test
