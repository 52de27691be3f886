// Whatever a client asks for, and whichever allocation fails in it: the client is answered, the daemon goes on, the
// same works when there is memory again, nothing is left behind when the client has gone, and no device is armed whose
// lease nobody holds (ShortDaemon::step()).
#include <unistd.h>

#include <cstdint>
#include <string>

#include "tests/memory/short_daemon.h"
#include "tests/support/shape/texture_upload.h"

namespace hapticd::test {
namespace {

constexpr std::uint64_t kMostAllocations = 2000;

/** `prepare` with memory, then `order` without, and with again if it was refused. */
template <class Prepare, class Order>
void withoutAnyAllocation(Prepare&& prepare, Order&& order) {
  ShortDaemon daemon;
  const auto once = [&](Shortage* shortage) {
    prepare(daemon);
    daemon.shortage = shortage;
    const ErrorCode code = order(daemon);
    daemon.shortage = nullptr;
    if (shortage == nullptr || !shortage->struck()) {
      EXPECT_EQ(code, ErrorCode::kOk);
    } else {
      EXPECT_NE(code, ErrorCode::kTimeout) << "whoever waits must be answered";
      if (code != ErrorCode::kOk) {
        EXPECT_EQ(order(daemon), ErrorCode::kOk) << "after " << static_cast<int>(code);
      }
    }
    daemon.leave();
    daemon.come();
  };
  once(nullptr);  // What is made once for all is there now.
  once(nullptr);
  const std::int64_t allocations_before = allocations();
  const std::ptrdiff_t descriptors_before = ShortDaemon::descriptors();
  for (const auto lasts : {Shortage::Lasts::kOnce, Shortage::Lasts::kOn}) {
    bool struck = true;
    for (std::uint64_t n = 0; struck && n < kMostAllocations; ++n) {
      SCOPED_TRACE(fmt::format("allocation {}{}", n, lasts == Shortage::Lasts::kOn ? " and all that follow" : ""));
      Shortage shortage(n, lasts);
      once(&shortage);
      struck = shortage.struck();
      if (testing::Test::HasFailure()) return;
    }
    EXPECT_FALSE(struck);
  }
  EXPECT_EQ(ShortDaemon::descriptors(), descriptors_before);
  EXPECT_LT(allocations() - allocations_before, 8) << "of some thousand orders";
}

void nothing(ShortDaemon&) {}

ErrorCode openSession(ShortDaemon& daemon) {
  auto request = daemon.daemon.openSessionRequest();
  request.setUri("");
  request.setClientName("a tester with a name that is long");
  request.setLayoutMajor(HD_SHM_MAJOR);
  request.setLayoutMinor(HD_SHM_MINOR);
  return daemon.ask(request.send(), [&](auto& response) {
    daemon.held.push_back(response.getSession());
    daemon.held.push_back(
        daemon.shortened<proto::Session>(kj::heap<SessionServer>(daemon.core(), response.getInfo().getId())));
  });
}

proto::Session::Client sessionOf(ShortDaemon& daemon) { return daemon.held.back().castAs<proto::Session>(); }

ErrorCode becomeLive(ShortDaemon& daemon) { return daemon.ask(sessionOf(daemon).mappedRequest().send()); }

Session& theSession(ShortDaemon& daemon) { return *daemon.core().sessions().all().front(); }

void withSession(ShortDaemon& daemon) {
  ASSERT_EQ(openSession(daemon), ErrorCode::kOk);
  daemon.bench.client = std::make_unique<ClientSide>(theSession(daemon));
}

void withLiveSession(ShortDaemon& daemon) {
  withSession(daemon);
  ASSERT_EQ(becomeLive(daemon), ErrorCode::kOk);
  ASSERT_TRUE(daemon.until([&] { return theSession(daemon).state == Session::State::kLive; }));
}

ErrorCode arm(ShortDaemon& daemon) { return daemon.ask(sessionOf(daemon).armRequest().send()); }

void withArmedDevice(ShortDaemon& daemon) {
  withLiveSession(daemon);
  ASSERT_EQ(arm(daemon), ErrorCode::kOk);
}

bool isOff(ShortDaemon& daemon) {
  hd_sample sample{};
  return daemon.core().devices().links().front()->latest(0, sample) && (sample.flags & HD_SAMPLE_ARMED) == 0;
}

TEST(AnyAllocation, OfOpeningADevice) {
  withoutAnyAllocation(nothing, [](ShortDaemon& daemon) {
    auto request = daemon.daemon.openDeviceRequest();
    request.setUri("test://second-of-a-longer-name");
    return daemon.ask(request.send());
  });
}

TEST(AnyAllocation, OfListingDevices) {
  withoutAnyAllocation(nothing,
                       [](ShortDaemon& daemon) { return daemon.ask(daemon.daemon.listDevicesRequest().send()); });
}

TEST(AnyAllocation, OfOpeningASession) { withoutAnyAllocation(nothing, openSession); }

TEST(AnyAllocation, OfHandingOutRegions) {
  withoutAnyAllocation(withSession, [](ShortDaemon& daemon) {
    return daemon.ask(sessionOf(daemon).regionsRequest().send(), [&](auto& response) {
      daemon.held.insert(daemon.held.begin(), response.getA());
      daemon.held.insert(daemon.held.begin(), response.getB());
    });
  });
}

TEST(AnyAllocation, OfBecomingLive) {
  withoutAnyAllocation(withSession, [](ShortDaemon& daemon) {
    const ErrorCode code = becomeLive(daemon);
    if (code != ErrorCode::kOk) return code;
    return daemon.until([&] { return theSession(daemon).state == Session::State::kLive; }) ? code : ErrorCode::kTimeout;
  });
}

TEST(AnyAllocation, OfArming) {
  withoutAnyAllocation(withLiveSession, [](ShortDaemon& daemon) {
    const ErrorCode code = arm(daemon);
    daemon.step();
    daemon.step();
    if (code == ErrorCode::kOk) {
      EXPECT_FALSE(isOff(daemon));
    } else {
      EXPECT_TRUE(daemon.until([&] { return isOff(daemon); })) << "armed although it was refused";
      EXPECT_EQ(theSession(daemon).device->lease, 0u) << "a refusal leaves the lease as it was";
    }
    return code;
  });
}

TEST(AnyAllocation, OfDisarming) {
  withoutAnyAllocation(withArmedDevice, [](ShortDaemon& daemon) {
    const ErrorCode code = daemon.ask(sessionOf(daemon).disarmRequest().send());
    EXPECT_TRUE(daemon.until([&] { return isOff(daemon); }));
    return code;
  });
}

TEST(AnyAllocation, OfReleasingTheLease) {
  withoutAnyAllocation(withArmedDevice, [](ShortDaemon& daemon) {
    if (theSession(daemon).device->lease == 0) return ErrorCode::kOk;  // All but its answer was there before.
    const ErrorCode code = daemon.ask(sessionOf(daemon).releaseLeaseRequest().send());
    EXPECT_TRUE(code != ErrorCode::kOk || daemon.until([&] { return isOff(daemon); }));
    return code;
  });
}

TEST(AnyAllocation, OfStoppingEveryDevice) {
  withoutAnyAllocation(withArmedDevice, [](ShortDaemon& daemon) {
    const ErrorCode code = daemon.ask(daemon.daemon.stopRequest().send());
    EXPECT_TRUE(daemon.until([&] { return isOff(daemon); })) << "a stop needs no memory of ours";
    return code;
  });
}

TEST(AnyAllocation, OfStoppingOneDevice) {
  const char* const name = "a.device.with.a.long.name";  // No string holds it inline.
  const auto prepare = [&](ShortDaemon& daemon) {
    withArmedDevice(daemon);
    theSession(daemon).device->aliases = {name};
  };
  withoutAnyAllocation(prepare, [&](ShortDaemon& daemon) {
    auto request = daemon.daemon.stopRequest();
    request.setUri(name);
    const ErrorCode code = daemon.ask(request.send());
    EXPECT_TRUE(daemon.until([&] { return isOff(daemon); }));
    return code;
  });
}

/** A session that is dropped, or whose client dies, takes its force with it. */
TEST(AnyAllocation, OfTheEndOfASessionThatHasArmed) {
  withoutAnyAllocation(withArmedDevice, [](ShortDaemon& daemon) {
    const std::uint64_t id = theSession(daemon).id;
    const ErrorCode code = daemon.inLoop([&] { daemon.core().sessions().end(id, "the client has dropped it"); });
    EXPECT_TRUE(daemon.until([&] { return isOff(daemon); }));
    daemon.shortage = nullptr;
    EXPECT_TRUE(daemon.until([&] { return daemon.core().sessions().empty(); }));
    return code;
  });
}

TEST(AnyAllocation, OfTheDeathOfAClientThatHasArmed) {
  const auto prepare = [](ShortDaemon& daemon) {
    withArmedDevice(daemon);
    auto request = daemon.scene.createRequest();
    auto object = request.initObject();
    object.setName("an.object.with.a.long.name");
    object.initShape().setKind(proto::ShapeKind::PLANE);
    ASSERT_EQ(daemon.ask(request.send()), ErrorCode::kOk);
  };
  withoutAnyAllocation(prepare, [](ShortDaemon& daemon) {
    const auto die = [&] { daemon.core().disconnect(daemon.connection); };
    const ErrorCode code = daemon.inLoop(die);
    EXPECT_TRUE(daemon.until([&] { return isOff(daemon); }));
    daemon.shortage = nullptr;
    EXPECT_TRUE(daemon.until([&] { return daemon.core().clients().all().size() == 2; }));
    EXPECT_TRUE(daemon.until([&] { return daemon.core().scene().list().empty(); }));
    EXPECT_TRUE(daemon.until([&] { return daemon.core().sessions().empty(); }));
    return code;
  });
}

ErrorCode create(ShortDaemon& daemon) {
  auto request = daemon.scene.createRequest();
  auto object = request.initObject();
  object.setName("an.object.with.a.long.name");
  auto shape = object.initShape();
  shape.setKind(proto::ShapeKind::BOX);
  auto size = shape.initSize();
  size.setX(0.1);
  size.setY(0.1);
  size.setZ(0.1);
  const ErrorCode code = daemon.ask(request.send());
  const std::size_t there = daemon.core().scene().list().size();
  EXPECT_EQ(there, code == ErrorCode::kOk ? 1u : 0u) << "as it was answered";
  return code;
}

TEST(AnyAllocation, OfMakingAnObject) { withoutAnyAllocation(nothing, create); }

void withObject(ShortDaemon& daemon) { ASSERT_EQ(create(daemon), ErrorCode::kOk); }

TEST(AnyAllocation, OfMovingAnObject) {
  withoutAnyAllocation(withObject, [](ShortDaemon& daemon) {
    auto request = daemon.scene.setPoseRequest();
    request.setName("an.object.with.a.long.name");
    auto p = request.initPose().initP();
    p.setX(0.1);
    return daemon.ask(request.send());
  });
}

TEST(AnyAllocation, OfRemovingAnObject) {
  withoutAnyAllocation(withObject, [](ShortDaemon& daemon) {
    auto request = daemon.scene.removeRequest();
    request.setName("an.object.with.a.long.name");
    const ErrorCode code = daemon.ask(request.send());
    const std::size_t there = daemon.core().scene().list().size();
    EXPECT_EQ(there, code == ErrorCode::kOk ? 0u : 1u) << "as it was answered";
    return code;
  });
}

TEST(AnyAllocation, OfBeginningAnUpload) {
  withoutAnyAllocation(nothing, [](ShortDaemon& daemon) {
    auto request = daemon.scene.beginUploadRequest();
    request.setBytes(1000);
    const ErrorCode code =
        daemon.ask(request.send(), [&](auto& response) { daemon.held.push_back(response.getUpload()); });
    EXPECT_EQ(daemon.core().uploads().size(), code == ErrorCode::kOk ? 1u : 0u) << "one that nobody has stays";
    return code;
  });
}

TEST(AnyAllocation, OfATexture) {
  withoutAnyAllocation(nothing, [](ShortDaemon& daemon) {
    const auto bytes = reliefUpload(8, 8, std::vector<std::uint16_t>(64, 1000));
    const auto id = daemon.core().uploads().begin(bytes.size(), daemon.core().client(daemon.connection));
    EXPECT_TRUE(id.ok());
    EXPECT_EQ(::pwrite(daemon.core().uploads().region(*id)->get(), bytes.data(), bytes.size(), 0), std::ssize(bytes));
    auto server = kj::heap<UploadServer>(daemon.core(), ShortDaemon::kUser);
    server->hold(*id);
    auto upload = daemon.shortened<proto::Upload>(kj::mv(server));
    const ErrorCode code = daemon.ask(upload.commitTextureRequest().send());
    EXPECT_EQ(daemon.core().scene().textures().list().size(), code == ErrorCode::kOk ? 1u : 0u) << "as it was answered";
    return code;
  });
}

ErrorCode subscribe(ShortDaemon& daemon) {
  auto request = daemon.daemon.subscribeRequest();
  request.setListener(kj::heap<Listener>(daemon.heard));
  return daemon.ask(request.send(), [&](auto& response) { daemon.held.push_back(response.getSubscription()); });
}

TEST(AnyAllocation, OfSubscribing) { withoutAnyAllocation(nothing, subscribe); }

/** Whoever listens hears of each event, or that it is lost; and of those that come after. */
TEST(AnyAllocation, OfTellingWhatHappened) {
  const auto prepare = [](ShortDaemon& daemon) { ASSERT_EQ(subscribe(daemon), ErrorCode::kOk); };
  withoutAnyAllocation(prepare, [](ShortDaemon& daemon) {
    const std::uint64_t before = daemon.heard;
    const ErrorCode code = daemon.inLoop(
        [&] { daemon.core().publish(EventKind::kDeviceAdded, "a", "a text too long to lie in a string"); });
    EXPECT_EQ(code, ErrorCode::kOk) << "who publishes is in the middle of something";
    Shortage* const shortage = std::exchange(daemon.shortage, nullptr);
    daemon.core().publish(EventKind::kDeviceAdded, "b");
    EXPECT_TRUE(daemon.until([&] { return daemon.heard == before + 2; })) << daemon.heard - before;
    daemon.shortage = shortage;
    return code;
  });
}

TEST(AnyAllocation, OfRecording) {
  withoutAnyAllocation(nothing, [](ShortDaemon& daemon) {
    const ErrorCode code = daemon.ask(daemon.daemon.recordRequest().send(),
                                      [&](auto& response) { daemon.held.push_back(response.getRecording()); });
    daemon.shortage = nullptr;
    if (code != ErrorCode::kOk) {
      EXPECT_TRUE(daemon.until([&] { return daemon.core().recordings().size() == 0; }));
    }
    return code;
  });
}

TEST(AnyAllocation, OfLimits) {
  withoutAnyAllocation(withArmedDevice, [](ShortDaemon& daemon) {
    GuardLimits lower = theSession(daemon).device->limits;
    lower.force *= 0.99;
    auto request = daemon.daemon.setLimitsRequest();
    write(request.initLimits(), lower);
    return daemon.ask(request.send());
  });
}

TEST(AnyAllocation, OfReadingEverything) {
  withoutAnyAllocation(withObject, [](ShortDaemon& daemon) {
    ErrorCode code = daemon.ask(daemon.daemon.stateRequest().send());
    if (code == ErrorCode::kOk) code = daemon.ask(daemon.scene.listRequest().send());
    if (code == ErrorCode::kOk) code = daemon.ask(daemon.scene.listTexturesRequest().send());
    if (code == ErrorCode::kOk) code = daemon.ask(daemon.daemon.statisticsRequest().send());
    return code;
  });
}

/** A folder of each kind, a property, a dump: their JSON must be gone without memory, too. */
TEST(AnyAllocation, OfReadingAResource) {
  for (const char* const path : {"/", "/objects", "/objects/an.object.with.a.long.name/pose", "/_objects", "/devices",
                                 "/statistics", "/clients", "/config", "/world", "/nowhere"}) {
    SCOPED_TRACE(path);
    withoutAnyAllocation(withObject, [&](ShortDaemon& daemon) {
      auto request = daemon.daemon.getRequest();
      request.setPath(path);
      const ErrorCode code = daemon.ask(request.send());
      return code == ErrorCode::kNotFound && std::string_view(path) == "/nowhere" ? ErrorCode::kOk : code;
    });
  }
}

TEST(AnyAllocation, OfADump) {
  withoutAnyAllocation(withObject, [](ShortDaemon& daemon) { return daemon.ask(daemon.daemon.dumpRequest().send()); });
}

TEST(AnyAllocation, OfWritingAResource) {
  withoutAnyAllocation(withObject, [](ShortDaemon& daemon) {
    auto request = daemon.daemon.setRequest();
    request.setUri("/objects/an.object.with.a.long.name/pos?value=0,0,0.1");
    return daemon.ask(request.send());
  });
}

}  // namespace
}  // namespace hapticd::test
