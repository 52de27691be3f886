// The client library against a real daemon with a simulated hand.
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cmath>
#include <hapticclient/hapticclient.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tests/support/eventually.h"
#include "tests/support/process/daemon_fixture.h"

namespace hapticd::test {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

class ClientIntegration : public ::testing::Test {
 protected:
  void SetUp() override { ASSERT_TRUE(daemon_.running()) << daemon_.log(); }
  void TearDown() override {
    if (HasFailure()) std::fputs(daemon_.log().c_str(), stderr);
  }
  haptic::Client connect(const char* name, bool administration = false) {
    auto client =
        haptic::Client::connect({administration ? daemon_.adminSocket() : daemon_.socket(), name, administration});
    EXPECT_TRUE(client) << client.error().message();
    return client ? std::move(*client) : haptic::Client(nullptr);
  }
  static haptic::Session open(haptic::Client& client) {
    auto session = client.openSession();
    EXPECT_TRUE(session) << session.error().message();
    return session ? std::move(*session) : haptic::Session(nullptr);
  }
  static haptic_sample newest(const haptic::Session& session) {
    const auto sample = session.latest();
    EXPECT_TRUE(sample) << sample.error().message();
    return sample ? *sample : haptic_sample{};
  }
  static haptic_intent handAt(double z) { return {0, 0, {0, 0, z}, {1, 0, 0, 0}, 0}; }
  static haptic_local_model floorAt(double z) {
    haptic_local_model plane{};
    plane.kind = HAPTIC_MODEL_PLANE;
    plane.lease_ns = 5'000'000'000;
    plane.normal[2] = 1;
    plane.origin[2] = z;
    plane.material = {1000, 2, 0, 0};
    return plane;
  }

  DaemonFixture daemon_{{.program = HAPTICD_PROGRAM, .config = "[guard]\narm_ramp_ms = 100\n"}};
};

TEST_F(ClientIntegration, ASampleStandsAsSoonAsASessionIsOpen) {
  auto client = connect("eager");
  int missed = 0;
  for (int i = 0; i < 6; ++i) {  // As many as fit into the quota while those before fade.
    auto session = open(client);
    missed += session.latest() ? 0 : 1;
  }
  EXPECT_EQ(missed, 0);
}

TEST_F(ClientIntegration, ARecordingIsReadToItsEnd) {
  auto client = connect("recorder");
  auto session = open(client);
  auto recording = client.record();
  ASSERT_TRUE(recording) << recording.error().message();
  std::string stream;
  std::thread reading([&] {
    char buffer[4096];
    for (ssize_t n; (n = read(recording->fd(), buffer, sizeof buffer)) > 0;) stream.append(buffer, n);
  });
  const auto cycles = [&] { return session.counters()->cycles; };  // A tick may be one that was missed.
  const std::uint64_t begun = cycles();
  EXPECT_TRUE(eventually([&] { return cycles() > begun + 20; }));
  EXPECT_EQ(client.record().code(), HAPTIC_ALREADY_EXISTS);
  const auto end = recording->stop();
  reading.join();
  ASSERT_TRUE(end) << end.error().message();
  EXPECT_GE((*end)->cycles, 20u);
  EXPECT_EQ((*end)->lost, 0u);
  EXPECT_TRUE(stream.starts_with("HRBLOCK1"));
}

TEST_F(ClientIntegration, ASampleIsOfTheDeviceThatIsAskedFor) {
  auto client = connect("one");
  auto session = open(client);
  const auto first = session.latest(0);
  ASSERT_TRUE(first) << first.error().message();
  EXPECT_EQ(first->device, 0u);
  EXPECT_EQ(session.latest(1).code(), HAPTIC_INVALID_ARGUMENT) << "the group has one";
}

TEST_F(ClientIntegration, TwoClientsShareTheSceneAndOneHoldsTheLease) {
  auto first = connect("first");
  auto second = connect("second");
  auto a = open(first);
  auto b = open(second);
  ASSERT_TRUE(a.acquireLease());
  const auto refused = b.arm();
  EXPECT_EQ(refused.code(), HAPTIC_LEASE_HELD);
  EXPECT_NE(refused.error().message().find("first"), std::string::npos) << refused.error().message();

  haptic_object ball = HAPTIC_OBJECT_INIT;
  ball.name = "ball";
  ball.shape.kind = HAPTIC_SHAPE_SPHERE;
  ball.shape.size[0] = 0.01;
  ball.pose.p[2] = -0.05;
  {
    auto object = first.scene().create(ball);
    ASSERT_TRUE(object) << object.error().message();
    auto seen = second.scene().find("ball");
    ASSERT_TRUE(seen) << seen.error().message();
    EXPECT_EQ((*seen)->id, object->id());
    EXPECT_EQ((*seen)->object->pose.p[2], -0.05);
    EXPECT_EQ(second.scene().create(ball).code(), HAPTIC_ALREADY_EXISTS);
    auto status = second.status();
    ASSERT_TRUE(status);
    EXPECT_EQ((*status)->client_count, 2u);
    EXPECT_STREQ((*status)->devices[0]->lease_holder, "first");
  }
  EXPECT_EQ(second.scene().find("ball").code(), HAPTIC_NOT_FOUND) << "it went with its handle";

  a = haptic::Session(nullptr);
  EXPECT_TRUE(eventually([&] { return b.acquireLease().ok(); })) << "a closed session gives its lease back";
}

TEST_F(ClientIntegration, ComesBackAfterTheDaemonWasKilled) {
  auto client = connect("survivor");
  auto session = open(client);
  ASSERT_TRUE(session.arm());
  const std::uint64_t epoch = (*session.describe())->epoch;
  daemon_.kill();
  ASSERT_TRUE(eventually([&] { return !client.connected(); }));
  EXPECT_EQ(session.latest().code(), HAPTIC_DISCONNECTED);
  EXPECT_EQ(session.push(floorAt(0)).code(), HAPTIC_DISCONNECTED);
  EXPECT_EQ(client.reconnect().code(), HAPTIC_DISCONNECTED);

  ASSERT_TRUE(daemon_.start()) << daemon_.log();
  ASSERT_TRUE(client.reconnect());
  const auto back = session.reopen();
  ASSERT_TRUE(back) << back.error().message();
  EXPECT_NE((*session.describe())->epoch, epoch);
  ASSERT_TRUE(eventually([&] { return session.latest().ok(); }));
  EXPECT_EQ(newest(session).flags & HAPTIC_SAMPLE_ARMED, 0u) << "a restarted daemon holds still";
  EXPECT_TRUE(session.arm());
}

TEST_F(ClientIntegration, EverySampleIsInTheHistoryOrCountedLost) {
  auto client = connect("reader");
  auto session = open(client);
  std::vector<haptic_sample> room(HAPTIC_MODEL_SLOTS * 1024);
  std::uint64_t lost = 0;
  std::uint64_t last = 0;
  ASSERT_TRUE(eventually([&] {
    const auto got = session.drain(room, lost);
    if (got && !got->empty()) last = got->back().tick;
    return last != 0;
  }));
  lost = 0;
  const std::uint64_t read = session.counters()->cycles;
  ASSERT_TRUE(eventually([&] { return session.counters()->cycles > read + 1300; })) << "longer than the history is";
  const auto got = session.drain(room, lost);
  ASSERT_TRUE(got);
  ASSERT_FALSE(got->empty());
  EXPECT_GT(lost, 0u);
  // Ticks skipped by a late servo have no sample; they are counted in `missed`.
  const std::uint64_t between = got->front().tick - last - 1;
  EXPECT_GE(between, lost);
  EXPECT_LE(between - lost, session.counters()->missed);
  for (std::size_t i = 1; i < got->size(); ++i) ASSERT_GT((*got)[i].tick, (*got)[i - 1].tick);
}

TEST_F(ClientIntegration, AStopIsAnEventAndLatchesUntilArmedAgain) {
  auto client = connect("stopper");
  auto session = open(client);
  auto events = client.subscribe(1u << HAPTIC_EVENT_FAULT | 1u << HAPTIC_EVENT_ARMED);
  ASSERT_TRUE(events);
  ASSERT_TRUE(session.arm());
  auto event = events->next(seconds(10));
  ASSERT_TRUE(event);
  EXPECT_EQ(event->kind, unsigned{HAPTIC_EVENT_ARMED});
  ASSERT_TRUE(client.stop());
  event = events->next(seconds(10));
  ASSERT_TRUE(event);
  EXPECT_EQ(event->kind, unsigned{HAPTIC_EVENT_FAULT});
  EXPECT_EQ(event->value, unsigned{HAPTIC_FAULT_STOP_LINE});
  ASSERT_TRUE(eventually([&] { return (newest(session).flags & HAPTIC_SAMPLE_FAULT) != 0; }));
  ASSERT_TRUE(session.arm());
  EXPECT_TRUE(eventually([&] { return (newest(session).flags & HAPTIC_SAMPLE_ARMED) != 0; }));
  EXPECT_EQ(newest(session).fault, 0u);
}

TEST_F(ClientIntegration, APushedPlaneIsFeltAcknowledgedAndExpires) {
  auto client = connect("pusher");
  auto session = open(client);
  auto events = client.subscribe(1u << HAPTIC_EVENT_MODEL_EXPIRED);
  ASSERT_TRUE(events);
  ASSERT_TRUE(session.arm());
  ASSERT_TRUE(eventually([&] { return session.latest().ok(); }));
  haptic_local_model plane = floorAt(0);
  plane.slot = 3;
  plane.lease_ns = 1'500'000'000;
  const std::uint64_t at = newest(session).tick + 50;
  const auto seq = session.push(plane, {.at_tick = at});
  ASSERT_TRUE(seq);
  ASSERT_TRUE(eventually([&] { return session.acks()->applied_seq >= *seq; }));
  EXPECT_GE(session.acks()->applied_tick, at);
  EXPECT_EQ(session.model(3)->seq, *seq);
  ASSERT_TRUE(session.push(handAt(-0.01), {.latest = true}));
  // The hand (400 N/m) wants 1 cm into a plane of 1000 N/m: it is stopped at 400 / 1400 cm.
  EXPECT_TRUE(eventually([&] { return newest(session).by_source[HAPTIC_SOURCE_LOCAL_MODEL][2] > 2; }));
  const auto event = events->next(seconds(10));
  ASSERT_TRUE(event);
  EXPECT_EQ(event->value, 3u);
  EXPECT_TRUE(eventually([&] { return newest(session).by_source[HAPTIC_SOURCE_LOCAL_MODEL][2] == 0; }));
}

TEST_F(ClientIntegration, WhatTheDaemonRefusesIsInTheAcks) {
  auto client = connect("refused");
  auto session = open(client);
  const haptic_local_model plane = floorAt(0);
  const auto seq =
      session.push(plane, {.at_tick = newest(session).tick + 60'000});  // further ahead than the daemon allows
  ASSERT_TRUE(seq);
  ASSERT_TRUE(eventually([&] { return session.acks()->rejected == 1; }));
  EXPECT_EQ(session.acks()->last_rejected_seq, *seq);
  EXPECT_EQ(session.acks()->last_rejected_code, unsigned{HAPTIC_INVALID_ARGUMENT});
  EXPECT_TRUE(session.alive());
}

TEST_F(ClientIntegration, AStatusTellsWhatASessionHasPushed) {
  auto client = connect("pusher");
  auto session = open(client);
  haptic_local_model plane = floorAt(0);
  plane.lease_ns = 10'000'000'000;
  for (plane.slot = 1; plane.slot < 3; ++plane.slot) ASSERT_TRUE(session.push(plane));
  ASSERT_TRUE(session.push(plane, {.at_tick = newest(session).tick + 60'000}));
  const auto told = [&] {
    const auto status = client.status();
    const haptic_client_status& s = *(*status)->clients[0];
    return s.received == 3 && s.rejected == 1 && s.models == 2 && s.fade == 1;
  };
  EXPECT_TRUE(eventually(told)) << (*client.status())->clients[0]->models << " models";
  // By mailboxes as well: two targets, each with a newer value once the first was taken.
  const auto received = [&](std::uint64_t count) {
    return eventually([&] { return (*client.status())->clients[0]->received == count; });
  };
  const haptic_intent wish = HAPTIC_INTENT_INIT;
  plane.slot = 1;
  for (std::uint64_t count = 4; count < 8; ++count) {
    ASSERT_TRUE(count % 2 == 0 ? session.push(wish, {.latest = true}) : session.push(plane, {.latest = true}));
    ASSERT_TRUE(received(count)) << (*client.status())->clients[0]->received;
  }
}

TEST_F(ClientIntegration, LimitsFallFreelyAndRiseByAdministration) {
  auto client = connect("user");
  auto session = open(client);
  ASSERT_TRUE(session.acquireLease());
  haptic_device_limits limits{};
  for (double* limit : {&limits.force, &limits.torque, &limits.force_slew, &limits.torque_slew, &limits.velocity,
                        &limits.power, &limits.active_power, &limits.gripper_force}) {
    *limit = NAN;
  }
  const double before = (*client.status())->devices[0]->limits->force;
  limits.force = before / 2;
  auto now = client.setLimits("", limits);
  ASSERT_TRUE(now) << now.error().message();
  EXPECT_EQ(now->force, before / 2);
  EXPECT_GT(now->force_slew, 0) << "the others stay";
  haptic_device_limits unsized{};
  limits.size = sizeof limits;
  limits.force = before / 4;
  EXPECT_EQ(haptic_device_set_limits(client.get(), "", &limits, &unsized, nullptr), HAPTIC_INVALID_ARGUMENT);
  EXPECT_EQ((*client.status())->devices[0]->limits->force, before / 2) << "a refusal changes nothing";
  limits.force = before;
  EXPECT_EQ(client.setLimits("", limits).code(), HAPTIC_PERMISSION_DENIED);
  auto administrator = connect("administrator", true);
  now = administrator.setLimits("", limits);
  ASSERT_TRUE(now) << now.error().message();
  EXPECT_EQ(now->force, before);
  EXPECT_EQ(client.closeDevice("sim://default").code(), HAPTIC_PERMISSION_DENIED);
}

TEST_F(ClientIntegration, ResourcesByName) {
  auto client = connect("names");
  haptic_object box = HAPTIC_OBJECT_INIT;
  box.name = "box";
  box.shape = {HAPTIC_SHAPE_BOX, 0, {0.01, 0.01, 0.01}, 0};
  auto object = client.scene().create(box);
  ASSERT_TRUE(object);
  auto set = client.set("/objects/box/pos?value=0.01,0.02,-0.03");
  ASSERT_TRUE(set) << set.error().message();
  EXPECT_EQ((*object->state())->object->pose.p[2], -0.03);
  auto got = client.get("/objects/box/pos");
  ASSERT_TRUE(got);
  EXPECT_NE(got->find("0.02"), std::string::npos) << *got;
  EXPECT_EQ(client.get("/objects/nobody/pos").code(), HAPTIC_NOT_FOUND);
  EXPECT_FALSE(client.set("/objects/box/pos?value=nan,0,0"));
  EXPECT_EQ((*object->state())->object->pose.p[2], -0.03) << "a refusal changes nothing";
  EXPECT_TRUE(client.dump());
  EXPECT_TRUE(client.configuration());
  EXPECT_TRUE(client.doctor());
  auto statistics = client.statistics();
  ASSERT_TRUE(statistics) << statistics.error().message();
  EXPECT_GT((*statistics)->histogram_count, 0u);
}

TEST_F(ClientIntegration, AnUploadThatIsStillMappedIsRefusedUntilItIsNot) {
  auto client = connect("mapper");
  auto upload = client.scene().beginUpload(4, 4);
  ASSERT_TRUE(upload) << upload.error().message();
  const float vertices[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
  const std::uint32_t triangles[] = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
  std::copy(std::begin(vertices), std::end(vertices), upload->vertices().begin());
  std::copy(std::begin(triangles), std::end(triangles), upload->triangles().begin());
  // A second mapping of the same pages, as a program that clings to its mesh would have.
  const auto page_bytes = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  void* page = reinterpret_cast<void*>(reinterpret_cast<std::uintptr_t>(upload->vertices().data()) & ~(page_bytes - 1));
  void* second = mremap(page, 0, page_bytes, MREMAP_MAYMOVE);
  ASSERT_NE(second, MAP_FAILED);
  const auto refused = upload->commit();
  EXPECT_EQ(refused.code(), HAPTIC_STILL_MAPPED) << refused.error().message();
  munmap(second, page_bytes);
  const auto report = upload->commit();
  ASSERT_TRUE(report) << report.error().message();
  EXPECT_EQ((*report)->triangles, 4u);
  EXPECT_EQ((*report)->closed, 1u);
}

TEST_F(ClientIntegration, ABadMeshIsRefusedWithItsTriangle) {
  auto client = connect("careless");
  const std::vector<float> vertices = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  const auto report = client.scene().upload(vertices, std::vector<std::uint32_t>{0, 1, 2, 0, 1, 77});
  EXPECT_EQ(report.code(), HAPTIC_BAD_MESH);
  EXPECT_NE(report.error().message().find("triangle 1"), std::string::npos) << report.error().message();
  EXPECT_EQ((*client.scene().list())->count, 0u);
}

TEST_F(ClientIntegration, NumbersThatAreLeftOverAreRefused) {
  haptic::Client client = connect("arrays");
  haptic::Scene scene = client.scene();
  const std::vector<float> corners{0, 0, 0, 1, 0, 0, 0, 1, 0, 9};
  const std::vector<std::uint32_t> faces{0, 1, 2, 0};
  EXPECT_NE(scene.upload(corners, std::span(faces).first(3)).error().message().find("vertices: "), std::string::npos);
  EXPECT_NE(scene.upload(std::span(corners).first(9), faces).error().message().find("triangles: "), std::string::npos);
  EXPECT_TRUE(scene.upload(std::span(corners).first(9), std::span(faces).first(3)));
  const std::vector<std::uint16_t> grey(12, 30000);
  EXPECT_EQ(scene.uploadRelief(grey, 5).code(), HAPTIC_INVALID_ARGUMENT);
  EXPECT_EQ(scene.uploadRelief(grey, 0).code(), HAPTIC_INVALID_ARGUMENT);
  auto relief = scene.uploadRelief(grey, 4);
  ASSERT_TRUE(relief) << relief.error().message();
  EXPECT_EQ((*relief)->height, 3u);
}

TEST_F(ClientIntegration, TexturesComeAndGo) {
  haptic::Client client = connect("textures");
  EXPECT_TRUE(client.setTimeout(std::chrono::seconds(2)));
  EXPECT_FALSE(client.setTimeout(std::chrono::seconds(-2)));
  haptic::Scene scene = client.scene();
  const double a[] = {-0.5, 0.1};
  const haptic_vibration_model models[] = {{0.01, 0.2, 1, a}, {0.2, 0.2, 1, a}, {0.01, 2, 1, a}};
  const std::uint32_t faces[] = {0, 1, 2};
  haptic_vibration vibration{};
  vibration.size = sizeof vibration;
  vibration.order = 2;
  vibration.rate_hz = 10000;
  vibration.model_count = 3;
  vibration.triangle_count = 1;
  vibration.models = models;
  vibration.triangles = faces;
  auto made = scene.uploadVibration(vibration);
  ASSERT_TRUE(made) << made.error().message();
  EXPECT_EQ((*scene.textures())->count, 1u);
  EXPECT_TRUE(scene.dropTexture((*made)->id));
  EXPECT_EQ(scene.dropTexture((*made)->id).code(), HAPTIC_NOT_FOUND);
  EXPECT_EQ((*scene.textures())->count, 0u);
}

TEST_F(ClientIntegration, AnUploadIsCancelledWhileItBuilds) {
  auto client = connect("impatient");
  constexpr std::uint32_t kSide = 400;
  std::vector<float> vertices;
  std::vector<std::uint32_t> triangles;
  for (std::uint32_t i = 0; i <= kSide; ++i) {
    for (std::uint32_t k = 0; k <= kSide; ++k) {
      vertices.insert(vertices.end(), {1e-4f * static_cast<float>(i), 1e-4f * static_cast<float>(k), 0});
      const std::uint32_t a = i * (kSide + 1) + k;
      if (i < kSide && k < kSide) triangles.insert(triangles.end(), {a, a + kSide + 1, a + 1});
    }
  }
  int reports = 0;
  const auto report = client.scene().upload(vertices, triangles, 0, [&](float, const char*) { return ++reports < 2; });
  EXPECT_EQ(report.code(), HAPTIC_CANCELLED);
  const std::uint32_t first[] = {0, kSide + 1, 1};
  EXPECT_TRUE(client.scene().upload(vertices, first)) << "the builder serves on";
}

TEST_F(ClientIntegration, AnObjectMayOutliveItsClient) {
  haptic_object ball = HAPTIC_OBJECT_INIT;
  ball.name = "ball";
  ball.shape = {HAPTIC_SHAPE_SPHERE, 0, {0.01, 0, 0}, 0};
  std::optional<haptic::Object> object;
  std::optional<haptic::Scene> scene;
  {
    auto client = connect("short");
    scene = client.scene();
    auto made = scene->create(ball);
    ASSERT_TRUE(made);
    object = std::move(*made);
    EXPECT_TRUE(object->state());
  }
  EXPECT_EQ(object->setFlags(0).code(), HAPTIC_INVALID_ARGUMENT);
  EXPECT_EQ(scene->list().code(), HAPTIC_INVALID_ARGUMENT);
  object.reset();
}

TEST_F(ClientIntegration, WhatIsReleasedStaysAndCanBeChanged) {
  auto client = connect("releases");
  haptic_object ball = HAPTIC_OBJECT_INIT;
  ball.name = "ball";
  ball.shape = {HAPTIC_SHAPE_SPHERE, 0, {0.01, 0, 0}, 0};
  for (const bool released : {true, false}) {
    {
      auto object = client.scene().create(ball);
      ASSERT_TRUE(object);
      if (released) object->release();
      EXPECT_TRUE(object->setPose({{0, 0, -0.03}, {1, 0, 0, 0}}));
    }
    EXPECT_EQ(client.scene().find("ball").ok(), released);
    if (released) {
      ASSERT_TRUE(client.scene().remove("ball"));
    }
  }
}

TEST_F(ClientIntegration, AnEffectIsSetByItsFields) {
  haptic::Client client = connect("effects");
  haptic_object object = HAPTIC_OBJECT_INIT;
  object.name = "way";
  auto way = client.scene().create(object);
  ASSERT_TRUE(way) << way.error().message();
  haptic_effect guide = HAPTIC_EFFECT_INIT;
  guide.kind = HAPTIC_EFFECT_GUIDE;
  guide.stiffness = 1.0 / 3;
  guide.duration_s = 60;
  const std::array<double, 3> path[] = {{0, 0, 0}, {0.25, -0.5, 1e-30}};
  ASSERT_TRUE(way->setEffect(guide, path));
  const auto told = [&](const char* field) {
    const auto text = client.get(std::string("/objects/way/") + field);
    return text ? std::string(*text) : text.error().message();
  };
  EXPECT_EQ(told("effect"), "\"guide\"");
  EXPECT_EQ(told("effect_stiffness"), "0.3333333333333333") << "as it was given, to the bit";
  EXPECT_EQ(told("effect_duration_s"), "60.0");
  EXPECT_EQ(told("effect_path").substr(0, 28), "[[0.0,0.0,0.0],[0.25,-0.5,1.");
  ASSERT_TRUE(way->setEffect(HAPTIC_EFFECT_INIT));
  EXPECT_EQ(told("effect"), "\"none\"");
  EXPECT_EQ(told("effect_stiffness"), "200.0") << "all of it";
  EXPECT_EQ(told("effect_path"), "[]");

  const auto refused = [&](auto change) {
    haptic_effect effect = HAPTIC_EFFECT_INIT;
    change(effect);
    haptic_error error;
    EXPECT_EQ(haptic_object_set_effect(client.get(), "way", &effect, &error), HAPTIC_INVALID_ARGUMENT);
    return std::string(error.where) + ": " + error.what;
  };
  EXPECT_EQ(refused([](haptic_effect& e) { e.kind = 6; }), "haptic_effect.kind: is 6");
  EXPECT_EQ(refused([](haptic_effect& e) { e.damping = NAN; }), "haptic_effect.damping: is not finite");
  EXPECT_EQ(refused([](haptic_effect& e) { e.path_count = 2; }), "haptic_effect.path: is null");
  EXPECT_NE(refused([](haptic_effect& e) { e.reach = 0; }).find("effect.reach"), std::string::npos);
  double point[] = {0, 0, INFINITY};
  EXPECT_EQ(refused([&](haptic_effect& e) { e.path = point, e.path_count = 1; }), "haptic_effect.path_count: is 1");
  double line[] = {0, 0, 0, 0, INFINITY, 0};
  EXPECT_EQ(refused([&](haptic_effect& e) { e.path = line, e.path_count = 2; }),
            "haptic_effect.path, point 1: is not finite");
  std::vector<double> longest(96, -1.0 / 3);
  haptic_effect effect = HAPTIC_EFFECT_INIT;
  effect.path = longest.data();
  effect.path_count = 32;
  EXPECT_EQ(haptic_object_set_effect(client.get(), "way", &effect, nullptr), HAPTIC_OK) << "the longest there is";
  EXPECT_EQ(haptic_object_set_effect(client.get(), "a/b?c", &effect, nullptr), HAPTIC_NOT_FOUND);
  EXPECT_EQ(told("effect"), "\"none\"");
}

}  // namespace
}  // namespace hapticd::test
