// Groups that are configured by a serial number whose device is not there: when the buses are looked at for it.
#include <atomic>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "tests/session/bench.h"
#include "tests/session/still_device.h"

namespace hapticd::test {
namespace {

class Numbered final : public StillDevice {
 public:
  Numbered(const std::string& uri, const std::string& serial) : StillDevice("numbered", uri, serial) {}
  Result<void> open() override { return {}; }
  void giveUp() noexcept override {}
  void close() noexcept override {}
};

struct BySerial : testing::Test {
  BySerial() { make(); }
  /** With both of them missing. */
  void make() {
    plugged = false;
    tells = true;
    CoreOptions options;
    options.config = Bench::relaxed();
    for (const char* serial : {"S1", "S2"}) {
      GroupConfig group;
      group.name = "of " + std::string(serial);
      group.devices = {serial};
      group.rate_hz = 2000;
      options.config.groups.push_back(group);
    }
    options.threads = false;
    options.epoch = 42;
    core = std::make_unique<Core>(options, clock);
    DeviceManager& devices = core->devices();
    devices.setFactory([this](std::string_view text) -> Result<std::unique_ptr<Device>> {
      std::string uri(text);
      if (uri.find("://") == std::string::npos) {
        ++looks_of_control;
        const auto chosen = chooseDevice(uri, attached());
        if (!chosen) return chosen.error();
        uri = *chosen;
      }
      return std::unique_ptr<Device>(std::make_unique<Numbered>(uri, serialOf(uri)));
    });
    devices.setChooser(chooseDevice);
    devices.setFinder([this] {
      ++looks;
      return attached();
    });
    EXPECT_TRUE(core->openConfigured([] { return false; }).ok());
    while (core->devices().opening() != 0 || !core->wanted().settled()) core->poll();
    EXPECT_EQ(core->wanted().absent().size(), 2u);
    client = *core->connect(100, 1000, false);
    administration = *core->connect(101, 0, true);
    looks_of_control = looks = 0;
  }
  /** As written in its URI; of a Falcon as its driver finds it, if it is there. */
  [[nodiscard]] std::string serialOf(const std::string& uri) {
    const auto at = uri.find("serial=");
    if (at != std::string::npos) return uri.substr(at + 7);
    return plugged && tells && uri.starts_with("falcon://S1") ? "S1" : "";
  }
  [[nodiscard]] std::vector<DeviceFound> attached() {
    std::vector<DeviceFound> all(plugged ? 2 : 1);
    if (plugged) all[0] = {.info = {}, .real = true}, all[0].info.uri = "falcon://S1", all[0].info.serial = "S1";
    all.back().info.uri = "sim://default";
    all.back().info.serial = "sim";
    return all;
  }
  /** By whom; the clock rests, so no group is tried for its own sake. */
  Result<OpenDevice*> ask(const char* text, std::uint64_t by) {
    std::optional<Result<OpenDevice*>> answer;
    core->openDevice(text, by, [&](const Result<OpenDevice*>& device) { answer = device; });
    while (!answer) core->poll();
    return *answer;
  }
  [[nodiscard]] std::string groupOf(const char* text) {
    const auto device = ask(text, client);
    return device ? (*device)->link->name() : toString(device.error());
  }

  ManualClock clock{1'000'000'000};
  std::atomic<bool> plugged = false;
  bool tells = true;  ///< Its driver, of its serial number before it has opened it.
  std::atomic<int> looks_of_control = 0, looks = 0;
  std::unique_ptr<Core> core;
  std::uint64_t client = 0, administration = 0;
};

TEST_F(BySerial, WhoAsksForAnotherDeviceHasNobodyLookForThem) {
  for (const char* uri : {"sim://default?seed=1", "falcon://other", "sim://default?seed=2"})
    EXPECT_TRUE(ask(uri, client).ok()) << uri;
  EXPECT_EQ(looks_of_control, 0);
  EXPECT_EQ(looks, 0);
}

TEST_F(BySerial, WhoAsksForAnyHearsThatItIsMissing) {
  const auto any = ask("", client);
  ASSERT_FALSE(any.ok()) << "no other is taken instead";
  EXPECT_EQ(any.error().what, "no device has that name or serial number");
  EXPECT_EQ(looks_of_control, 0);
  EXPECT_EQ(looks, 1) << "aside";
}

/** Else it would have another rate, and none of what else its group has. */
TEST_F(BySerial, OneThatIsPluggedInLaterComesWithItsGroup) {
  for (const char* text : {"falcon://S1", "S1", ""}) {
    make();
    plugged = true;
    EXPECT_EQ(groupOf(text), "of S1") << "'" << text << "'";
    EXPECT_EQ(looks_of_control, 1) << "by the try of the group itself";
    const auto closed = core->closeDevice("falcon://S1", administration);
    ASSERT_TRUE(closed.ok() || closed.error().code == ErrorCode::kTimeout) << "its thread may find no processor";
    EXPECT_EQ(looks_of_control, 1) << "what it was is known";
    while (core->devices().isClosing("falcon://S1")) core->poll();
    tells = false;
    EXPECT_EQ(groupOf("falcon://S1"), "of S1") << "nobody gets it without its group when it was closed";
  }
}

TEST_F(BySerial, WhatIsOnlyCalledSoIsAnother) {
  EXPECT_EQ(groupOf("sim://default?serial=S1"), "group1");
  plugged = true;
  const auto tuned = ask("falcon://S1?firmware=x", administration);
  ASSERT_TRUE(tuned.ok());
  EXPECT_EQ((*tuned)->link->name(), "group2") << "the administrator's own";
  EXPECT_EQ(looks_of_control, 0);
}

}  // namespace
}  // namespace hapticd::test
