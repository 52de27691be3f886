// Who asks for one recorded motion together with others: who must have room for it, and who is charged.
#include <gmock/gmock.h>

#include <algorithm>
#include <atomic>
#include <list>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tests/session/bench.h"
#include "tests/session/holding_device.h"

namespace hapticd::test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

/** Those who ask for one recorded motion. */
struct Sharing : testing::Test {
  Sharing() {
    bench.core.devices().setFactory([this](std::string_view uri) -> Result<std::unique_ptr<Device>> {
      return std::unique_ptr<Device>(std::make_unique<HoldingDevice>(std::string(uri), kMost, open));
    });
  }
  /** Nobody is answered before bench.step(). */
  void ask(std::uint64_t by) {
    Answer& answer = answers.emplace_back();
    bench.core.openDevice(
        kUri, by, [&answer](const Result<OpenDevice*>& device) { answer = device ? "had" : toString(device.error()); });
  }
  /** What each has heard. */
  std::vector<std::string> heard() {
    while (std::ranges::any_of(answers, [](const Answer& one) { return !one; })) bench.step();
    std::vector<std::string> all;
    for (const Answer& one : std::exchange(answers, {})) all.push_back(*one);
    return all;
  }
  /** So much that the motion has no room. */
  std::uint64_t fill(std::uint64_t by) { return *bench.core.uploads().begin(1000, bench.core.client(by)); }
  [[nodiscard]] std::uint64_t bytesOf(std::uint64_t connection) const {
    return bench.core.bytesOf(bench.core.client(connection).uid);
  }
  void close() {
    const auto closed = bench.core.closeDevice(kUri, bench.administration);
    EXPECT_TRUE(closed.ok() || closed.error().code == ErrorCode::kTimeout) << toString(closed.error());
    untilClosed();
  }
  /** Its driver lets go on a thread, which may find no processor. */
  void untilClosed() {
    while (bench.core.devices().isClosing(kUri)) bench.step();
    EXPECT_EQ(*open, 0);
  }

  static Config small() {
    Config config = Bench::relaxed();
    config.quotas.memory_mb = static_cast<double>(kMost) * 1e-6;
    return config;
  }

  static constexpr std::uint64_t kMost = 1'000'000;
  static constexpr const char* kUri = "sim://default?mass=0.6";
  using Answer = std::optional<std::string>;
  std::list<Answer> answers;
  std::shared_ptr<std::atomic<int>> open = std::make_shared<std::atomic<int>>(0);
  Bench bench{small()};
  const std::uint64_t other = *bench.core.connect(102, 1001, false);
  const std::uint64_t third = *bench.core.connect(103, 1002, false);
};

/** Whoever asked first; and each who has no room hears of his own. */
TEST_F(Sharing, OfThoseWhoWaitEachNeedsRoomForIt) {
  const auto of = [](const char* user) { return HasSubstr(std::string("its recorded motion: user ") + user); };
  const std::uint64_t filled = fill(bench.connection);
  for (const std::uint64_t by : {bench.connection, other, third}) ask(by);
  EXPECT_THAT(heard(), ElementsAre(of("1000"), "had", "had"));
  EXPECT_EQ(bytesOf(bench.connection), 1000u);
  EXPECT_EQ(bytesOf(other), kMost);
  EXPECT_EQ(bytesOf(third), 0u) << "it is there once";
  bench.core.disconnect(other);
  EXPECT_EQ(bytesOf(third), kMost);
  bench.core.disconnect(third);
  bench.step(200);
  untilClosed();
  EXPECT_EQ(bench.core.devices().devices().size(), 1u) << "as what somebody asked for it goes with them";

  const std::uint64_t fourth = *bench.core.connect(104, 1003, false);
  for (const std::uint64_t by : {fourth, bench.connection}) ask(by);
  EXPECT_THAT(heard(), ElementsAre("had", of("1000")));
  close();
  (void)fill(fourth);
  for (const std::uint64_t by : {fourth, bench.connection}) ask(by);
  EXPECT_THAT(heard(), ElementsAre(of("1003"), of("1000")));
  untilClosed();
  EXPECT_EQ(bench.core.devices().devices().size(), 1u);

  bench.core.uploads().cancel(filled);
  for (int i = 0; i < 2; ++i) ask(bench.connection);
  EXPECT_THAT(heard(), ElementsAre("had", "had")) << "it is not counted twice";
  EXPECT_EQ(bytesOf(bench.connection), kMost);
  close();
}

TEST_F(Sharing, WhoTakesItOverFromOneWhoHasLeftNeedsRoomToo) {
  const std::uint64_t listener = bench.core.events().subscribe(0, [] {});
  (void)fill(bench.connection);
  for (const std::uint64_t by : {other, bench.connection}) ask(by);
  bench.core.disconnect(other);
  EXPECT_THAT(heard().back(), HasSubstr("user 1000"));
  untilClosed();
  EXPECT_EQ(bytesOf(bench.connection), 1000u);
  EXPECT_EQ(bench.core.devices().devices().size(), 1u);
  const auto events = bench.core.events().take(listener).events;
  EXPECT_TRUE(std::ranges::none_of(events, [](const Event& one) { return one.kind == EventKind::kDeviceAdded; }))
      << "it was there for nobody";
}

/** It stays charged to whoever has asked for it, and is there; what was the administrator's is free. */
TEST_F(Sharing, AnAdministratorWhoAsksForItTooRelievesNobody) {
  for (const std::uint64_t by : {bench.connection, bench.administration}) ask(by);
  EXPECT_THAT(heard(), ElementsAre("had", "had"));
  EXPECT_EQ(bytesOf(bench.connection), kMost);
  ask(bench.administration);
  EXPECT_THAT(heard(), ElementsAre("had"));
  EXPECT_EQ(bytesOf(bench.connection), kMost);
  bench.core.disconnect(bench.connection);
  ask(other);
  EXPECT_THAT(heard(), ElementsAre("had"));
  EXPECT_EQ(bytesOf(other), 0u) << "only the administrator had it";
  close();

  (void)fill(other);
  for (const std::uint64_t by : {bench.administration, other}) ask(by);
  EXPECT_THAT(heard(), ElementsAre("had", "had"));
  EXPECT_EQ(bytesOf(other), 1000u);
  close();
  for (const std::uint64_t by : {other, bench.administration, third}) ask(by);
  EXPECT_THAT(heard(), ElementsAre(HasSubstr("user 1001"), "had", "had"));
  EXPECT_EQ(bytesOf(third), 0u);
  bench.core.disconnect(bench.administration);
  EXPECT_EQ(bytesOf(third), 0u) << "as little when he leaves";
}

}  // namespace
}  // namespace hapticd::test
