// What one client may have waiting for a servo: whoever floods it is refused, and nobody else is.
#include <capnp/capability.h>
#include <kj/async.h>

#include <functional>
#include <optional>

#include "daemon/rpc/servers.h"
#include "tests/session/bench.h"

namespace hapticd::test {
namespace {

constexpr std::size_t kPlaces = Outbox::kPlaces;

TEST(OutboxShares, EachMayHaveAsManyAsAreLeft) {
  Outbox outbox;
  std::size_t left = kPlaces;
  for (std::uint64_t one = 1; left > 1; ++one) {
    std::size_t had = 0;
    for (; outbox.hasRoomFor(one); ++had) outbox.push(Command{}, one);
    EXPECT_EQ(had, left / 2) << "half of what is left, by client " << one;
    EXPECT_EQ(outbox.of(one), had);
    left -= had;
    EXPECT_TRUE(outbox.hasRoomFor(one + 1)) << "one place is always somebody else's";
  }
}

TEST(OutboxShares, ManyWhoFillItTogetherHaveEquallyMuch) {
  for (const std::size_t givers : {2u, 3u, 7u, 64u}) {
    Outbox outbox;
    for (bool any = true; any;) {
      any = false;
      for (std::uint64_t one = 1; one <= givers; ++one) {
        if (!outbox.hasRoomFor(one)) continue;
        outbox.push(Command{}, one);
        any = true;
      }
    }
    for (std::uint64_t one = 1; one <= givers; ++one)
      EXPECT_NEAR(static_cast<double>(outbox.of(one)), static_cast<double>(kPlaces) / (givers + 1.0), 1.0);
    EXPECT_TRUE(outbox.hasRoomFor(givers + 1));
  }
}

TEST(OutboxShares, WhatHasGoneIsCountedNoMore) {
  Outbox outbox;
  for (std::uint64_t round = 1; round <= 3 * Outbox::kMostGivers; ++round) {  // More than there are rows at a time.
    outbox.push(Command{});
    for (std::uint64_t one = round; one < round + 3; ++one) outbox.push(Command{}, one);
    EXPECT_EQ(outbox.of(round), 1u);
    outbox.pop();
    EXPECT_EQ(outbox.of(round), 1u) << "the daemon's own was nobody's";
    while (!outbox.empty()) outbox.pop();
    EXPECT_EQ(outbox.of(round), 0u);
  }
  for (std::uint64_t one = 1; one <= Outbox::kMostGivers; ++one) outbox.push(Command{}, one);
  std::uint64_t late = Outbox::kMostGivers;
  while (outbox.hasRoomFor(++late)) outbox.push(Command{}, late);
  EXPECT_EQ(outbox.of(Outbox::kOthers), (kPlaces - Outbox::kMostGivers) / 2) << "who comes late shares one share";
  EXPECT_EQ(outbox.of(Outbox::kMostGivers + 1), 0u) << "the first of them, too";
  EXPECT_TRUE(outbox.hasRoomFor(1));
  outbox.push(Command{}, ~std::uint64_t{3});
  EXPECT_EQ(outbox.of(~std::uint64_t{3}), 1u) << "not so what has a share of its own";
  for (int i = 0; i < 3; ++i) outbox.pop();
  EXPECT_TRUE(outbox.hasRoomFor(late)) << "a row is free again";
  while (!outbox.empty()) outbox.pop();
  EXPECT_EQ(outbox.of(Outbox::kOthers), 0u);
}

TEST(OutboxShares, TheDaemonsOwnCountsInAllAlone) {
  Outbox outbox;
  for (std::size_t i = 0; i < kPlaces; ++i) {
    EXPECT_TRUE(outbox.hasRoomFor(0));
    outbox.push(Command{});
  }
  EXPECT_FALSE(outbox.hasRoomFor(0));
  EXPECT_FALSE(outbox.hasRoomFor(1));
}

/** A scene with one object, whose first client floods the servo. */
struct Flood : testing::Test {
  void SetUp() override {
    ObjectSpec object;
    object.name = "it";
    object.shape.kind = ShapeKind::kSphere;
    object.shape.size.x() = 0.01;
    object.keep = true;
    ASSERT_TRUE(bench.core.scene().create(object, bench.core.client(bench.connection)).ok());
  }
  Result<void> move(std::uint64_t by) {
    return bench.core.editFor(by, [&] { return bench.core.scene().setPose("it", {}); });
  }
  void flood() {
    std::size_t moved = 0;
    while (move(bench.connection) && moved < 2 * kPlaces) ++moved;
    ASSERT_GE(moved, kPlaces / 2);
    ASSERT_LT(moved, kPlaces);
  }
  Bench bench;
  const std::uint64_t other = *bench.core.connect(102, 1001, false);
};

TEST_F(Flood, KeepsNobodyElseFromEditingOrArming) {
  Session* const session = bench.live(other);
  flood();
  EXPECT_EQ(move(bench.connection).error().code, ErrorCode::kWouldBlock);
  EXPECT_TRUE(move(other).ok());
  EXPECT_TRUE(
      bench.core.editFor(other, [&] { return bench.core.setRadius(bench.device(), 0.001, bench.core.client(other)); })
          .ok());
  EXPECT_EQ(
      bench.core
          .editFor(bench.connection,
                   [&] { return bench.core.setRadius(bench.device(), 0.001, bench.core.client(bench.connection)); })
          .error()
          .code,
      ErrorCode::kTimeout);
  std::optional<ErrorCode> answer;
  bench.core.arm(session->id, [&](const Result<void>& r) { answer = r ? ErrorCode::kOk : r.error().code; });
  EXPECT_FALSE(answer.has_value()) << "it waits for the servo, and is not refused";
  bench.step(static_cast<int>(kPlaces / kControlCommandsPerCycle));
  EXPECT_EQ(answer, ErrorCode::kOk);
  EXPECT_TRUE(move(bench.connection).ok()) << "what waited has been taken";
}

TEST_F(Flood, OfEditsOfManyLeavesRoomToArmToStopAndToDisarm) {
  Session* const session = bench.live(other);
  while (bench.device().link->accepting()) bench.device().applyRadius();
  ASSERT_EQ(move(other).error().code, ErrorCode::kWouldBlock);
  std::optional<ErrorCode> answer;
  bench.core.arm(session->id, [&](const Result<void>& r) { answer = r ? ErrorCode::kOk : r.error().code; });
  bench.step(static_cast<int>(kPlaces / kControlCommandsPerCycle) + 5);
  ASSERT_EQ(answer, ErrorCode::kOk);
  for (const bool stop : {true, false}) {
    while (bench.device().link->accepting()) bench.device().applyRadius();
    ASSERT_TRUE((stop ? bench.core.stop("", bench.connection) : bench.core.disarm(session->id)).ok());
    bench.step(5);  // 64 orders in flight at 16 a cycle
    EXPECT_EQ(bench.sample().flags & HD_SAMPLE_ARMED, 0u);
    bench.step(600);
    ASSERT_TRUE(bench.arm(session->id).ok());
  }
}

/** Every method by which a client edits, asked of the daemon as by a client. */
TEST_F(Flood, CountsForWhoeverAskedByWhicheverMethod) {
  kj::EventLoop loop;
  kj::WaitScope wait_scope(loop);
  using Ask = std::function<ErrorCode(proto::Scene::Client&, proto::Daemon::Client&)>;
  const auto codeOf = [&](auto request) {
    return static_cast<ErrorCode>(request.send().wait(wait_scope).getStatus().getCode());
  };
  const auto named = [&](auto request) {
    request.setName("it");
    return codeOf(kj::mv(request));
  };
  const auto set = [&](proto::Daemon::Client& daemon, const char* uri) {
    auto request = daemon.setRequest();
    request.setUri(uri);
    return codeOf(kj::mv(request));
  };
  const std::vector<std::pair<const char*, Ask>> methods = {
      {"setPose",
       [&](auto& scene, auto&) {
         auto request = scene.setPoseRequest();
         request.initPose().initQ().setW(1);
         return named(kj::mv(request));
       }},
      {"setMaterial", [&](auto& scene, auto&) { return named(scene.setMaterialRequest()); }},
      {"setFlags", [&](auto& scene, auto&) { return named(scene.setFlagsRequest()); }},
      {"setSurface", [&](auto& scene, auto&) { return named(scene.setSurfaceRequest()); }},
      {"setShape",
       [&](auto& scene, auto&) {
         auto request = scene.setShapeRequest();
         request.initShape().setKind(proto::ShapeKind::GROUP);
         return named(kj::mv(request));
       }},
      {"create",
       [&](auto& scene, auto&) {
         auto request = scene.createRequest();
         auto object = request.initObject();
         object.setName("another");
         object.initPose().initQ().setW(1);
         object.initShape().setKind(proto::ShapeKind::GROUP);
         return codeOf(kj::mv(request));
       }},
      {"set of an object", [&](auto&, auto& daemon) { return set(daemon, "/objects/it/pos?value=0,0,0"); }},
      {"set of a device", [&](auto&, auto& daemon) { return set(daemon, "/devices/test/radius?value=0.001"); }},
      {"set of the world", [&](auto&, auto& daemon) { return set(daemon, "/world/gravity?value=0,0,-1"); }},
      {"remove", [&](auto& scene, auto&) { return named(scene.removeRequest()); }},
  };
  flood();
  for (const auto& [what, ask] : methods) {
    SCOPED_TRACE(what);
    const auto askAs = [&, &ask = ask](std::uint64_t connection) {
      proto::Scene::Client scene = kj::heap<SceneServer>(bench.core, connection);
      proto::Daemon::Client daemon = kj::heap<DaemonServer>(bench.core, connection);
      return ask(scene, daemon);
    };
    const ErrorCode refused = askAs(bench.connection);
    EXPECT_TRUE(refused == ErrorCode::kWouldBlock || refused == ErrorCode::kTimeout) << static_cast<int>(refused);
    const std::size_t before = bench.device().link->posted();
    EXPECT_EQ(askAs(std::string_view(what) == "remove" ? bench.administration : other), ErrorCode::kOk);
    EXPECT_GT(bench.device().link->posted(), before);
  }
}

}  // namespace
}  // namespace hapticd::test
