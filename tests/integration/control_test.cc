// The control socket end to end: a daemon on its sockets, a client in bare Cap'n Proto.
#include <fcntl.h>

#include <list>
#include <nlohmann/json.hpp>

#include "rt/ring/command_ring.h"
#include "rt/ring/state.h"
#include "rt/scene/scene.h"
#include "tests/integration/raw_client.h"
#include "tests/integration/running_daemon.h"

namespace hapticd::test {
namespace {

class Control : public ::testing::Test {
 protected:
  RunningDaemon daemon;
  Loop loop;
  RawClient client{loop, daemon.control()};
  RawClient admin{loop, daemon.admin()};

  nlohmann::json get(const char* path) {
    auto request = client.daemon.getRequest();
    request.setPath(path);
    auto answer = loop.call(kj::mv(request));
    EXPECT_TRUE(good(answer.getStatus())) << path;
    return nlohmann::json::parse(answer.getJson().cStr(), nullptr, false);
  }
  ErrorCode set(const char* uri) {
    auto request = client.daemon.setRequest();
    request.setUri(uri);
    return code(loop.call(kj::mv(request)).getStatus());
  }
  proto::Scene::Client scene() { return loop.call(client.daemon.sceneRequest()).getScene(); }
  std::uint32_t sphere(proto::Scene::Client in, const char* name, const char* parent = "") {
    auto request = in.createRequest();
    auto object = request.initObject();
    object.setName(name);
    object.setParent(parent);
    object.initShape().setKind(proto::ShapeKind::SPHERE);
    object.getShape().initSize().setX(0.02);
    auto answer = loop.call(kj::mv(request));
    EXPECT_TRUE(good(answer.getStatus()));
    return answer.getId();
  }
  proto::DaemonState::Reader state() {
    held_.push_back(loop.call(client.daemon.stateRequest()));
    return held_.back().getState();
  }

 private:
  std::list<capnp::Response<proto::Daemon::StateResults>> held_;  ///< Readers stay valid as long as these.
};

TEST_F(Control, HelloTellsWhoServesAndWhichSocketItWas) {
  for (auto* each : {&client, &admin}) {
    auto request = each->daemon.helloRequest();
    request.setClientName("tester");
    request.setProtocolMajor(proto::PROTOCOL_MAJOR);
    auto answer = loop.call(kj::mv(request));
    ASSERT_TRUE(good(answer.getStatus()));
    EXPECT_EQ(answer.getInfo().getEpoch(), 0x1234u);
    EXPECT_EQ(answer.getInfo().getPid(), getpid());
    EXPECT_EQ(answer.getInfo().getAdministration(), each == &admin);
  }
  auto wrong = client.daemon.helloRequest();
  wrong.setClientName("old");
  wrong.setProtocolMajor(99);
  EXPECT_EQ(code(loop.call(kj::mv(wrong)).getStatus()), ErrorCode::kVersionMismatch);
}

TEST_F(Control, ListsOpensAndReusesDevices) {
  auto devices = loop.call(client.daemon.listDevicesRequest());
  ASSERT_TRUE(good(devices.getStatus()));
  ASSERT_GE(devices.getDevices().size(), 1u);
  EXPECT_TRUE(devices.getDevices()[0].getOpen());
  const std::string name = devices.getDevices()[0].getName().cStr();
  EXPECT_EQ(name, "sim");
  for (const char* way : {"", "sim", devices.getDevices()[0].getUri().cStr()}) {
    auto request = client.daemon.openDeviceRequest();
    request.setUri(way);
    auto answer = loop.call(kj::mv(request));
    ASSERT_TRUE(good(answer.getStatus()));
    EXPECT_EQ(answer.getDevice().getName(), "sim") << way;
  }
  auto other = client.daemon.openDeviceRequest();
  other.setUri("sim://falcon");
  auto answer = loop.call(kj::mv(other));
  ASSERT_TRUE(good(answer.getStatus()));
  EXPECT_EQ(answer.getDevice().getName(), "sim2");
  const auto close = [&](auto& caller, const char* uri) {
    auto request = caller.closeDeviceRequest();
    request.setUri(uri);
    return code(loop.call(kj::mv(request)).getStatus());
  };
  EXPECT_EQ(close(client.daemon, "sim"), ErrorCode::kPermissionDenied) << "it is configured";
  EXPECT_EQ(close(client.daemon, "sim2"), ErrorCode::kOk) << "nobody else has asked for it";
  auto again = client.daemon.openDeviceRequest();
  again.setUri("sim://falcon");
  ASSERT_TRUE(good(loop.call(kj::mv(again)).getStatus()));
  auto too = admin.daemon.openDeviceRequest();
  too.setUri("sim://falcon");
  ASSERT_TRUE(good(loop.call(kj::mv(too)).getStatus()));
  EXPECT_EQ(close(client.daemon, "sim2"), ErrorCode::kPermissionDenied);
  EXPECT_EQ(close(admin.daemon, "sim2"), ErrorCode::kOk);
  auto none = client.daemon.openDeviceRequest();
  none.setUri("nosuch://device");
  EXPECT_NE(code(loop.call(kj::mv(none)).getStatus()), ErrorCode::kOk);
}

TEST_F(Control, ASessionsHandshakeGivesSealedRegionsThatLive) {
  LiveSession live(loop, client);
  constexpr int kExact = F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_FUTURE_WRITE | F_SEAL_SEAL;
  EXPECT_EQ(fcntl(live.a->fd(), F_GET_SEALS) & ~0x20, kExact);
  EXPECT_EQ(fcntl(live.b->fd(), F_GET_SEALS) & ~0x20, kExact);
  EXPECT_EQ(mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_SHARED, live.b->fd(), 0), MAP_FAILED);
  EXPECT_EQ((*live.a)->header.session_id, live.id);
  StateReader reader(live.a->get());
  hd_sample sample{};
  ASSERT_TRUE(loop.until([&] { return reader.latest(0, sample) && sample.tick > 0; }));
  const std::uint64_t tick = sample.tick;
  ASSERT_TRUE(loop.until([&] { return reader.latest(0, sample) && sample.tick > tick + 10; }));
  EXPECT_EQ(code(loop.call(live.session.regionsRequest()).getStatus()), ErrorCode::kInvalidArgument)
      << "a mapped session hands out no descriptor";
  ASSERT_EQ(state().getClients().size(), 1u);
  EXPECT_EQ(state().getClients()[0].getPid(), getpid());
}

TEST_F(Control, ArmDisarmAndTheLeaseAcrossTheSocket) {
  LiveSession first(loop, client);
  LiveSession second(loop, admin);
  CommandProducer beat(first.b->get(), first.a->get());
  beat.heartbeat(1);
  ASSERT_TRUE(good(loop.call(first.session.armRequest()).getStatus()));
  EXPECT_TRUE(state().getDevices()[0].getArmed());
  EXPECT_EQ(state().getDevices()[0].getLeaseHolder(), "raw");
  EXPECT_EQ(code(loop.call(second.session.armRequest()).getStatus()), ErrorCode::kLeaseHeld);
  EXPECT_EQ(code(loop.call(second.session.disarmRequest()).getStatus()), ErrorCode::kLeaseRequired);
  ASSERT_TRUE(good(loop.call(first.session.disarmRequest()).getStatus()));
  EXPECT_TRUE(loop.until([&] { return !state().getDevices()[0].getArmed(); }));
  ASSERT_TRUE(good(loop.call(first.session.releaseLeaseRequest()).getStatus()));
  EXPECT_TRUE(good(loop.call(second.session.acquireLeaseRequest()).getStatus()));
}

TEST_F(Control, DroppingTheConnectionEndsEverythingOfIt) {
  const ErrorCode none = ErrorCode::kOk;
  auto gone = std::make_unique<RawClient>(loop, daemon.control());
  auto live = std::make_unique<LiveSession>(loop, *gone);
  ASSERT_EQ(code(loop.call(live->session.armRequest()).getStatus()), none);
  sphere(loop.call(gone->daemon.sceneRequest()).getScene(), "theirs");
  sphere(scene(), "mine");
  EXPECT_EQ(state().getObjects(), 2u);
  const hd_region_a* a = live->a->get();
  live->session = nullptr;
  gone.reset();
  EXPECT_TRUE(loop.until([&] { return state().getClients().size() == 0 && state().getObjects() == 1; }));
  EXPECT_TRUE(loop.until([&] { return !state().getDevices()[0].getArmed(); }));
  EXPECT_EQ(a->acks.ended, 1u);
  EXPECT_EQ(state().getDevices()[0].getLeaseHolder(), "");
  EXPECT_EQ(get("/objects/mine/id").is_number(), true);
}

/** A user has so many Regions; who holds them all is told, and asks again. */
TEST_F(Control, AStreamThatIsRefusedIsNotLost) {
  auto begin = client.daemon.sceneRequest().send().getScene().beginUploadRequest();
  begin.setBytes(1000);
  auto upload = loop.call(kj::mv(begin));
  ASSERT_TRUE(good(upload.getStatus()));
  std::vector<proto::Region::Client> held;
  for (auto one = loop.call(upload.getUpload().regionRequest()); one.hasRegion();
       one = loop.call(upload.getUpload().regionRequest()))
    held.push_back(one.getRegion());
  auto recording = loop.call(client.daemon.recordRequest());
  ASSERT_TRUE(good(recording.getStatus()));
  EXPECT_EQ(code(loop.call(recording.getRecording().streamRequest()).getStatus()), ErrorCode::kQuotaExceeded);
  held.pop_back();
  EXPECT_TRUE(good(loop.call(recording.getRecording().streamRequest()).getStatus()));
  EXPECT_EQ(code(loop.call(recording.getRecording().streamRequest()).getStatus()), ErrorCode::kInvalidArgument)
      << "it was handed out";
}

TEST_F(Control, GetAndSetRoundTripByEveryName) {
  auto in = scene();
  sphere(in, "base");
  sphere(in, "tip", "base");
  ASSERT_EQ(set("/objects/base/pos?value=0,0,0.02"), ErrorCode::kOk);
  EXPECT_EQ(get("/objects/base/pos"), (nlohmann::json{0.0, 0.0, 0.02}));
  ASSERT_EQ(set("/_objects/base/tip/pos?value=0.1,0,0"), ErrorCode::kOk);
  EXPECT_EQ(get("/_objects/base/tip/worldpos"), (nlohmann::json{0.1, 0.0, 0.02}));
  EXPECT_EQ(get("/_objects"), (nlohmann::json{{"base", {{"tip", nlohmann::json::object()}}}}));
  ASSERT_EQ(set("/objects/tip/worldpos?value=0,0,0"), ErrorCode::kOk);
  EXPECT_EQ(get("/objects/tip/pos"), (nlohmann::json{0.0, 0.0, -0.02}));
  ASSERT_EQ(set("/objects/tip/stiffness?value=1234.5"), ErrorCode::kOk);
  EXPECT_EQ(get("/objects/tip/stiffness"), 1234.5);
  ASSERT_EQ(set("/objects/tip/enabled?value=false"), ErrorCode::kOk);
  EXPECT_EQ(get("/objects/tip/enabled"), false);
  EXPECT_EQ(get("/objects/tip/visible"), true);
  // The servo has it too: the answer comes from its board once the order has passed.
  EXPECT_TRUE(loop.until([&] { return get("/objects/tip/pos") == (nlohmann::json{0.0, 0.0, -0.02}); }));
  loop.pause(60);
  EXPECT_EQ(get("/objects/tip/pos"), (nlohmann::json{0.0, 0.0, -0.02}));
  EXPECT_EQ(get("/devices/sim/rate"), 1000.0);
  for (const char* path : {"/", "/objects", "/devices", "/devices/sim", "/statistics", "/statistics/sim", "/clients",
                           "/meshes", "/config"}) {
    EXPECT_FALSE(get(path).is_discarded()) << path;
  }
}

TEST_F(Control, AClientsPoseThroughTheRingIsWhatGetAnswers) {
  const std::uint32_t id = sphere(scene(), "moved");
  LiveSession live(loop, client);
  CommandProducer producer(live.b->get(), live.a->get());
  producer.heartbeat(1);
  const hd_object_pose pose = poseMessage(id, {{0, 0.25, 0}, Quat::Identity()});
  std::uint64_t seq = 0;
  ASSERT_EQ(producer.push(HD_COMMAND_OBJECT_POSE, std::as_bytes(std::span(&pose, 1)), 0, seq), ErrorCode::kOk);
  EXPECT_TRUE(loop.until([&] { return get("/objects/moved/pos") == (nlohmann::json{0.0, 0.25, 0.0}); }));
}

TEST_F(Control, ErrorsNameTheElementAndWhatIsNear) {
  sphere(scene(), "motor");
  const auto refused = [&](const char* path) {
    auto request = client.daemon.getRequest();
    request.setPath(path);
    auto answer = loop.call(kj::mv(request));
    return std::string(answer.getStatus().getWhere().cStr()) + " | " + answer.getStatus().getRemedy().cStr();
  };
  EXPECT_EQ(refused("/object").substr(0, 28), "/object | there is objects, ") << "the likeliest first";
  EXPECT_NE(refused("/objects/moter").find("motor"), std::string::npos);
  EXPECT_EQ(refused("/objects/motor/poss").substr(0, 19), "/objects/motor/poss");
  EXPECT_NE(refused("/objects/motor/poss").find("pos"), std::string::npos);
  EXPECT_EQ(set("/objects/motor/pos?value=1,2"), ErrorCode::kInvalidArgument);
  EXPECT_EQ(set("/objects/motor/pos?value=1,2,nan"), ErrorCode::kInvalidArgument);
  EXPECT_EQ(set("/objects/motor/pos?value=1,2,3,4"), ErrorCode::kInvalidArgument);
  EXPECT_EQ(set("/objects/motor/pos"), ErrorCode::kInvalidArgument);
  EXPECT_EQ(set("/objects/motor/id?value=3"), ErrorCode::kPermissionDenied);
  EXPECT_EQ(set("/devices/sim/armed?value=true"), ErrorCode::kPermissionDenied);
  EXPECT_EQ(set("/objects/motor/rot?value=1,1,0,0"), ErrorCode::kInvalidArgument);
  EXPECT_EQ(set("/objects/motor/friction_dynamic?value=9"), ErrorCode::kInvalidArgument);
  EXPECT_EQ(get("/objects/motor/pos"), (nlohmann::json{0.0, 0.0, 0.0})) << "nothing changed";
}

TEST_F(Control, RaisingLimitsAndResettingStatisticsNeedTheAdministrationSocket) {
  const auto limitsBy = [&](RawClient& by, double force) {
    auto request = by.daemon.setLimitsRequest();
    auto limits = request.initLimits();
    const auto now = state().getDevices()[0].getLimits();
    limits.setForce(force);
    limits.setTorque(now.getTorque());
    limits.setForceSlew(now.getForceSlew());
    limits.setTorqueSlew(now.getTorqueSlew());
    limits.setVelocity(now.getVelocity());
    limits.setPower(now.getPower());
    limits.setActivePower(now.getActivePower());
    limits.setGripperForce(now.getGripperForce());
    return code(loop.call(kj::mv(request)).getStatus());
  };
  const double before = state().getDevices()[0].getLimits().getForce();
  EXPECT_EQ(limitsBy(client, before / 2), ErrorCode::kLeaseRequired);
  EXPECT_EQ(limitsBy(admin, before / 2), ErrorCode::kOk);
  EXPECT_EQ(limitsBy(client, before), ErrorCode::kPermissionDenied);
  EXPECT_EQ(limitsBy(admin, before), ErrorCode::kOk);
  auto reset = client.daemon.statisticsRequest();
  reset.setReset(true);
  const auto refused = loop.call(kj::mv(reset));
  EXPECT_EQ(code(refused.getStatus()), ErrorCode::kPermissionDenied);
  EXPECT_NE(std::string(refused.getStatus().getRemedy().cStr()).find("admin.sock"), std::string::npos);
  ASSERT_TRUE(loop.until([&] { return state().getDevices()[0].getCycles() > 0; }));
  auto asked = admin.daemon.statisticsRequest();
  asked.setReset(true);
  auto answer = loop.call(kj::mv(asked));
  ASSERT_TRUE(good(answer.getStatus()));
  EXPECT_EQ(answer.getStatistics().getHistograms().size(), 7u);
  EXPECT_GT(answer.getStatistics().getCycles(), 0u);
}

TEST_F(Control, ConfigurationDoctorAndDumpAnswer) {
  auto toml = loop.call(client.daemon.configurationRequest());
  ASSERT_TRUE(good(toml.getStatus()));
  const auto parsed = parseConfig(toml.getToml().cStr(), "answer");
  ASSERT_TRUE(parsed.ok());
  EXPECT_EQ(*parsed, RunningDaemon::simulated());
  auto doctor = loop.call(client.daemon.doctorRequest());
  ASSERT_TRUE(good(doctor.getStatus()));
  EXPECT_GE(doctor.getChecks().size(), 8u);
  for (auto check : doctor.getChecks()) {
    EXPECT_GT(check.getName().size(), 0u);
    const bool red = check.getState() == proto::Check::State::RED;
    EXPECT_TRUE(!red || check.getRemedy().size() > 0) << check.getName().cStr();
  }
  auto dump = loop.call(client.daemon.dumpRequest());
  const auto json = nlohmann::json::parse(dump.getJson().cStr(), nullptr, false);
  EXPECT_EQ(json["daemon"]["version"], "0.1.0");
  EXPECT_TRUE(json["devices"].contains("sim"));
}

}  // namespace
}  // namespace hapticd::test
