// Configured devices that do not open: the daemon starts without them, says so, and finds them later.
#include "tests/session/device/missing.h"

namespace hapticd::test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::UnorderedElementsAre;

TEST_F(Missing, OneThatDoesNotAnswerKeepsNobodyElse) {
  sockets["a://dead"].set(false);
  (void)sockets["b://well"];
  make({group("left", {"a://dead"}), group("right", {"b://well"})});
  ASSERT_TRUE(start().ok());
  EXPECT_THAT(open(), ElementsAre("b://well"));
  ASSERT_THAT(absent(), ElementsAre("a://dead"));
  const auto one = core->wanted().absent().front();
  EXPECT_EQ(one.group, "left");
  EXPECT_EQ(one.why.what, "it does not answer");
  EXPECT_FALSE(one.passed_over);
  EXPECT_TRUE(core->wanted().names("a://dead"));
}

TEST_F(Missing, IsTriedAtIntervalsThatDoubleToHalfAMinute) {
  sockets["a://dead"].set(false);
  make({group("left", {"a://dead"})});
  ASSERT_TRUE(start().ok());
  until(100'000'000'000);
  const auto& tried = sockets["a://dead"].tried_ns;
  const std::vector<double> pauses_s = {1, 2, 4, 8, 16, 30, 30};
  ASSERT_EQ(tried.size(), pauses_s.size() + 1);
  for (std::size_t i = 0; i < pauses_s.size(); ++i) {
    EXPECT_NEAR(static_cast<double>(tried[i + 1] - tried[i]) * 1e-9, pauses_s[i], 0.02);
  }
  sockets["a://dead"].set(true);
  until(130'000'000'000);
  EXPECT_THAT(open(), ElementsAre("a://dead"));
  EXPECT_TRUE(absent().empty());
  EXPECT_EQ(core->devices().links().front()->name(), "left");
  EXPECT_EQ(core->devices().links().front()->group().options().cycle.period_ns, 500'000) << "the group's own rate";
  until(200'000'000'000);
  EXPECT_EQ(sockets["a://dead"].opened, 1);
}

TEST_F(Missing, WhoAsksHasItTriedAtOnce) {
  sockets["a://dead"].set(false);
  make({group("left", {"a://dead"})});
  ASSERT_TRUE(start().ok());
  until(3'500'000'000);  // The next attempt is due at 7 s.
  for (const char* text : {"a://dead", ""}) {
    std::string told;
    core->openDevice(text, administration, [&](const Result<OpenDevice*>& device) { told = device.error().what; });
    until(clock.now());
    EXPECT_EQ(told, "it does not answer") << "'" << text << "'";
  }
  sockets["a://dead"].set(true);
  OpenDevice* device = nullptr;
  core->openDevice("", administration, [&](const Result<OpenDevice*>& opened) { device = *opened; });
  until(clock.now());
  ASSERT_NE(device, nullptr);
  EXPECT_EQ(device->link->name(), "left");
  EXPECT_TRUE(absent().empty());
}

/** Else a device would come back without its group's dead-man switch, and at another rate. */
TEST_F(Missing, WhoAsksForOneOfAClosedGroupGetsTheGroup) {
  for (const char* uri : {"a://arm", "b://pedal", "c://other"}) (void)sockets[uri];
  attached = {"a://arm"};
  for (const char* named : {"a://arm", ""})  // Nothing is any; as it is for who asks.
    for (const char* text : {"b://pedal", "a://arm", ""}) {
      make({group("desk", {named, "b://pedal"})});
      ASSERT_TRUE(start().ok());
      ASSERT_TRUE(core->closeDevice("a://arm", administration).ok());
      until(clock.now() + 100'000'000'000);
      EXPECT_TRUE(open().empty()) << "nobody looks for it";
      EXPECT_TRUE(absent().empty()) << "nor is it missing";
      EXPECT_TRUE(core->wanted().names("a://arm"));
      const auto ask = [&](const char* uri) {
        Result<void> told;
        core->openDevice(uri, administration, [&](const Result<OpenDevice*>& device) {
          told = device ? Result<void>() : Result<void>(device.error());
        });
        until(clock.now());
        return told;
      };
      EXPECT_TRUE(ask("c://other").ok());
      EXPECT_THAT(open(), ElementsAre("c://other"));
      ASSERT_TRUE(core->closeDevice("c://other", administration).ok());
      sockets["b://pedal"].set(false);
      EXPECT_EQ(ask(text).error().what, "it does not answer") << "all or nothing";
      EXPECT_TRUE(open().empty());
      sockets["b://pedal"].set(true);
      ASSERT_TRUE(ask(text).ok());
      EXPECT_THAT(open(), ElementsAre("a://arm", "b://pedal"));
      EXPECT_EQ(core->devices().links().front()->name(), "desk");
      EXPECT_EQ(core->devices().links().front()->group().options().cycle.period_ns, 500'000) << "the group's own rate";
    }
}

TEST_F(Missing, ASlowOneDoesNotHoldTheStart) {
  sockets["a://slow"].set(true, true);
  make({group("left", {"a://slow"})});
  ASSERT_TRUE(core->openConfigured().ok());
  EXPECT_EQ(clock.now(), WantedGroups::kPatience_ns);
  ASSERT_THAT(absent(), ElementsAre("a://slow"));
  EXPECT_THAT(core->wanted().absent().front().why.what, HasSubstr("still"));
  OpenDevice* device = nullptr;
  core->openDevice("a://slow", administration, [&](const Result<OpenDevice*>& opened) { device = *opened; });
  sockets["a://slow"].set(true);
  until(clock.now());
  EXPECT_THAT(open(), ElementsAre("a://slow"));
  EXPECT_NE(device, nullptr) << "who asks meanwhile waits for the same";
  EXPECT_EQ(sockets["a://slow"].opened, 1);
}

TEST_F(Missing, OneThatHangsDelaysNoneAfterIt) {
  sockets["a://slow"].set(true, true);
  (void)sockets["b://well"];
  sockets["c://dead"].set(false);
  make({group("left", {"a://slow"}), group("middle", {"b://well"}), group("right", {"c://dead"})});
  int looks = 0;
  const auto out_of_patience = [&] {
    looks += answered("b://well") && answered("c://dead") ? 1 : 0;  // Some more, for their threads to end.
    if (looks == 50) clock.advance(WantedGroups::kPatience_ns);
    ::usleep(100);
    return true;
  };
  ASSERT_TRUE(core->openConfigured(out_of_patience).ok());
  EXPECT_GE(clock.now(), WantedGroups::kPatience_ns);
  EXPECT_THAT(open(), ElementsAre("b://well")) << "when the first client is served";
  EXPECT_THAT(absent(), ElementsAre("a://slow", "c://dead"));
  EXPECT_EQ(sockets["b://well"].tried_ns.front(), 0) << "tried at once";
  // Nor one that comes back later, while the first still hangs.
  sockets["c://dead"].set(true);
  now_ns = clock.now();
  for (int i = 0; i < 2000 && open().size() < 2; ++i) {
    clock.advance(5 * kMs);
    for (int k = 0; k < 20 && open().size() < 2; ++k) core->poll(), ::usleep(100);
  }
  EXPECT_THAT(open(), ElementsAre("b://well", "c://dead"));
  sockets["a://slow"].set(true);
  until(clock.now());
  EXPECT_THAT(open(), ElementsAre("b://well", "c://dead", "a://slow"));
}

TEST_F(Missing, WhicheverOpensFirstTheirOrderIsThatOfTheConfiguration) {
  sockets["a://slow"].set(true, true);
  (void)sockets["b://well"];
  sockets["c://dead"].set(false);
  sockets["d://slow"].set(true, true);
  make({group("first", {"a://slow"}), group("second", {"b://well"}), group("third", {"c://dead"}),
        group("fourth", {"4711"}), group("fifth", {"d://slow"})});
  ASSERT_TRUE(core->openConfigured([] { return false; }).ok());
  while (!tried("a://slow") || !answered("b://well") || !answered("c://dead") || !tried("d://slow")) core->poll();
  linger();
  EXPECT_TRUE(open().empty()) << "the first is awaited";
  for (const auto& one : core->wanted().absent()) EXPECT_THAT(one.why.what, HasSubstr("still")) << one.uri;
  sockets["d://slow"].set(true);
  sockets["a://slow"].set(true);
  settle();
  EXPECT_THAT(open(), ElementsAre("a://slow", "b://well", "d://slow"));
  EXPECT_THAT(absent(), ElementsAre("c://dead", "4711"));
}

TEST_F(Missing, AnEndClosesWhatWaitsForItsTurn) {
  sockets["a://slow"].set(true, true);
  (void)sockets["b://well"];
  make({group("left", {"a://slow"}), group("right", {"b://well"})});
  ASSERT_TRUE(core->openConfigured([] { return false; }).ok());
  while (!tried("a://slow") || !answered("b://well")) core->poll();
  linger();
  core.reset();
  EXPECT_EQ(sockets["b://well"].opened, 1);
  EXPECT_EQ(sockets["b://well"].closed, 1);
}

TEST_F(Missing, AnEndDoesNotWaitForIt) {
  sockets["a://slow"].set(true, true);
  make({group("left", {"a://slow"})});
  ASSERT_TRUE(core->openConfigured([&] { return clock.now() < 50 * kMs; }).ok());
  EXPECT_EQ(clock.now(), 50 * kMs);
  core.reset();
  EXPECT_EQ(sockets["a://slow"].opened, 0);
}

TEST_F(Missing, AGroupIsThereAsAWhole) {
  (void)sockets["a://well"];
  sockets["b://dead"].set(false);
  make({group("pair", {"a://well", "b://dead"})});
  ASSERT_TRUE(start().ok());
  until(2'500'000'000);
  EXPECT_TRUE(open().empty());
  EXPECT_THAT(absent(), ElementsAre("a://well", "b://dead"));
  EXPECT_GE(sockets["a://well"].opened, 2);
  EXPECT_EQ(sockets["a://well"].closed, sockets["a://well"].opened) << "one that opened was kept from others";
  sockets["b://dead"].set(true);
  until(8'000'000'000);
  EXPECT_THAT(open(), ElementsAre("a://well", "b://dead"));
  EXPECT_EQ(core->devices().links().size(), 1u);
}

TEST_F(Missing, NoOtherDeviceIsTakenInsteadOfAMissingOne) {
  sockets["a://dead"].set(false);
  (void)sockets["sim://default"];
  attached = {"sim://default"};
  make({group("left", {"a://dead"})});
  ASSERT_TRUE(start().ok());
  bool refused = false;
  core->openDevice("", administration, [&](const Result<OpenDevice*>& device) { refused = !device.ok(); });
  until(clock.now());
  EXPECT_TRUE(refused);
  EXPECT_TRUE(open().empty());
}

TEST_F(Missing, ItsGroupKeepsItsName) {
  (void)sockets["b://well"];
  sockets["a://dead"].set(false);
  make({group("group1", {"a://dead"})});
  ASSERT_TRUE(start().ok());
  core->openDevice("b://well", administration, [](const Result<OpenDevice*>& device) { EXPECT_TRUE(device.ok()); });
  until(clock.now());
  ASSERT_EQ(core->devices().links().size(), 1u);
  EXPECT_NE(core->devices().links().front()->name(), "group1");
}

TEST_F(Missing, ASerialNumberMayComeLater) {
  make({group("left", {"4711"})});
  ASSERT_TRUE(start().ok());
  EXPECT_THAT(absent(), ElementsAre("4711"));
  (void)sockets["4711"];
  until(5'000'000'000);
  EXPECT_THAT(open(), ElementsAre("4711"));
}

TEST_F(Missing, OneThatIsPluggedInLaterIsKnownByAllItsNames) {
  for (const char* configured : {"a://default", "4711"}) {
    for (const char* asked : {"a://default", "4711", "a://4711", ""}) {
      sockets.clear();
      stands_for.clear();
      sockets["a://default"].set(false);  // Its driver knows such a URI; nothing is plugged in.
      make({group("left", {configured})});
      ASSERT_TRUE(start().ok());
      (void)sockets["a://4711"];
      stands_for = {{"a://default", "a://4711"}, {"4711", "a://4711"}};
      OpenDevice* device = nullptr;
      core->openDevice(asked, administration, [&](const Result<OpenDevice*>& opened) {
        ASSERT_TRUE(opened.ok()) << toString(opened.error());
        device = *opened;
      });
      until(clock.now());
      ASSERT_NE(device, nullptr) << configured << ", asked for as '" << asked << "'";
      EXPECT_EQ(device->link->name(), "left") << configured << ", asked for as '" << asked << "'";
      EXPECT_EQ(device->info().uri, "a://4711");
      until(clock.now() + 40'000'000'000);
      EXPECT_TRUE(absent().empty());
      core.reset();
    }
  }
}

TEST_F(Missing, ItsLimitsAreThoseOfItsEntryHoweverLateItIsPluggedIn) {
  DeviceConfig entry;
  entry.uri = "a://default";
  entry.limits.force_n = 1.25;
  entry.radius_m = 0.002;
  for (const bool by_itself : {false, true}) {
    sockets.clear();
    stands_for.clear();
    sockets["a://default"].set(false);
    limits = {entry};
    make({group("left", {by_itself ? "b://other" : "a://default"})});
    (void)sockets["b://other"];
    ASSERT_TRUE(start().ok());
    (void)sockets["a://4711"];
    stands_for = {{"a://default", "a://4711"}};
    core->openDevice("a://4711", administration, [](const Result<OpenDevice*>& device) {
      ASSERT_TRUE(device.ok());
      EXPECT_EQ((*device)->limits.force, 1.25);
      EXPECT_EQ((*device)->radius, 0.002);
      const GuardConfig& guard = (*device)->link->group().options().cycle.guard[0];
      EXPECT_EQ(guard.limits.force, 1.25) << "and the guard's";
      EXPECT_EQ(guard.life_ns, (*device)->device().commandLife_ns());
      EXPECT_GT(guard.life_ns, 0);
    });
    until(clock.now());
    EXPECT_THAT(open(), ::testing::Contains("a://4711"));
    core.reset();
  }
}

TEST_F(Missing, WhatNoAttemptWouldMendEndsTheStart) {
  (void)sockets["a://well"];
  make({group("left", {"a://well"}), group("right", {"nobody://knows"})});
  EXPECT_EQ(start().error().code, ErrorCode::kNotFound);
  EXPECT_EQ(sockets["a://well"].opened, 0);
  make({group("left", {"a://well"}), group("right", {"a://well"})});
  EXPECT_EQ(start().error().code, ErrorCode::kDeviceBusy);
  EXPECT_EQ(sockets["a://well"].opened, 0);
}

TEST_F(Missing, ADeviceOfTheCommandLineMustOpen) {
  sockets["a://dead"].set(false);
  make({group("default", {"a://dead"})}, true);
  EXPECT_EQ(core->openConfigured().error().code, ErrorCode::kDeviceGone);
}

}  // namespace
}  // namespace hapticd::test
