// A group that takes whatever device there is, beside those that name theirs.
#include "tests/session/device/missing.h"

namespace hapticd::test {
namespace {

using ::testing::ElementsAre;
using ::testing::UnorderedElementsAre;

TEST_F(Missing, WhateverThereIsWaitsForThoseThatAreNamedBeforeAndLeavesThoseAfter) {
  for (const char* uri : {"a://slow", "b://well", "sim://default"}) (void)sockets[uri];
  attached = {"a://slow", "b://well"};
  const GroupConfig slow = group("slow", {"a://slow"}), any = group("any", {""}), well = group("well", {"b://well"});
  for (const auto& groups : {std::vector{slow, any, well}, {any, well, slow}}) {
    sockets["a://slow"].set(true, true);
    make(groups);
    ASSERT_TRUE(core->openConfigured([] { return false; }).ok());
    linger();
    EXPECT_EQ(tried("sim://default"), groups[0].name == "any");
    sockets["a://slow"].set(true);
    settle();
    EXPECT_THAT(open(), UnorderedElementsAre("a://slow", "sim://default", "b://well")) << "each device once";
    EXPECT_TRUE(absent().empty());
  }
}

/** What is attached is known without the parameters by which a group drives it. */
TEST_F(Missing, WhateverThereIsLeavesWhatAnotherNamesWithParameters) {
  const char* const named = "falcon://default?firmware=/x.bin";
  for (const char* uri : {"falcon://default", named, "sim://default"}) (void)sockets[uri];
  attached = {"falcon://default"};
  make({group("any", {""}), group("arm", {named})});
  ASSERT_TRUE(start().ok());
  EXPECT_THAT(open(), UnorderedElementsAre("sim://default", named));
  EXPECT_FALSE(tried("falcon://default"));
}

TEST_F(Missing, WhateverThereIsPassesOverWhatDoesNotOpen) {
  sockets["a://dead"].set(false);
  for (const char* uri : {"b://well", "sim://default"}) (void)sockets[uri];
  attached = {"a://dead", "b://well"};
  make({group("default", {""})});
  ASSERT_TRUE(start().ok());
  EXPECT_THAT(open(), ElementsAre("b://well"));
  ASSERT_THAT(absent(), ElementsAre("a://dead"));
  EXPECT_TRUE(core->wanted().absent().front().passed_over);
  until(60'000'000'000);
  EXPECT_EQ(sockets["a://dead"].tried_ns.size(), 1u) << "the group has its device";
  sockets["a://dead"].set(true);
  core->openDevice("a://dead", administration, [](const Result<OpenDevice*>& device) { EXPECT_TRUE(device.ok()); });
  until(clock.now());
  EXPECT_TRUE(absent().empty());
}

TEST_F(Missing, WhateverThereIsIsNotPassedOverForAnotherOfItsGroup) {
  for (const char* uri : {"a://well", "sim://default"}) (void)sockets[uri];
  sockets["b://late"].set(false);
  attached = {"a://well"};
  for (const std::vector<std::string>& devices : {std::vector<std::string>{"", "b://late"}, {"b://late", ""}}) {
    make({group("pair", devices)});
    ASSERT_TRUE(start().ok());
    EXPECT_TRUE(open().empty());
    EXPECT_THAT(absent(), UnorderedElementsAre("a://well", "b://late"));
    sockets["b://late"].set(true);
    until(clock.now() + 5'000'000'000);
    EXPECT_THAT(open(), UnorderedElementsAre("a://well", "b://late")) << "not the simulator";
    sockets["b://late"].set(false);
  }
}

TEST_F(Missing, TheSimulatorIsTheLastResortOfAGroupThatTakesWhateverThereIs) {
  sockets["a://dead"].set(false);
  (void)sockets["sim://default"];
  attached = {"a://dead"};
  make({});
  ASSERT_TRUE(start().ok());
  EXPECT_THAT(open(), ElementsAre("sim://default"));
  EXPECT_THAT(absent(), ElementsAre("a://dead"));
}

}  // namespace
}  // namespace hapticd::test
