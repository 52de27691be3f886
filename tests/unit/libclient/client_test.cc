// Connecting, calls and their failures, reconnecting, forks.
#include <signal.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "tests/unit/libclient/fixture.h"

namespace hapticd::test {
namespace {

using std::chrono::milliseconds;

class ClientTest : public WithFakeDaemon {};

TEST_F(ClientTest, ShakesHandsAndTellsWhoItIs) {
  start({.epoch = 77});
  auto client = connect();
  ASSERT_TRUE(client) << client.error().message();
  EXPECT_TRUE(client->connected());
  EXPECT_EQ(daemon_->seen().client_name, "tester");
  auto info = client->daemon();
  ASSERT_TRUE(info);
  EXPECT_STREQ((*info)->version, "9.9");
  EXPECT_EQ((*info)->epoch, 77u);
  EXPECT_EQ((*info)->socket, socket());
  EXPECT_EQ((*info)->size, sizeof(haptic_daemon_info));
}

TEST_F(ClientTest, AnEmptyPathIsNoSearch) {
  start();
  ASSERT_EQ(setenv("HAPTICD_SOCKET", socket().c_str(), 1), 0);  // Which a search would find.
  haptic_connect_options options = HAPTIC_CONNECT_OPTIONS_INIT;
  options.socket = "";
  haptic_client* client = nullptr;
  haptic_error error = HAPTIC_ERROR_INIT;
  EXPECT_EQ(haptic_connect(&options, &client, &error), HAPTIC_INVALID_ARGUMENT);
  EXPECT_EQ(client, nullptr);
  EXPECT_STREQ(error.where, "haptic_connect_options.socket");
  EXPECT_STREQ(error.what, "is empty");
  options.socket = nullptr;
  EXPECT_EQ(haptic_connect(&options, &client, &error), HAPTIC_OK) << error.what;
  haptic_disconnect(client);
  unsetenv("HAPTICD_SOCKET");
}

TEST_F(ClientTest, AProgramThatNamesNothingGoesByANameThatTheDaemonTakes) {
  start();
  const std::string longest(62, 'a');
  const std::pair<std::string, std::string> names[] = {{"tester", "tester"},
                                                       {longest + "bcd", longest + "bc"},
                                                       {longest + "b\u00e9", longest + "b"},
                                                       {"caf\xe9", "caf?"},
                                                       {"caf\u00e9 \u20ac\U0001f600", "caf\u00e9 \u20ac\U0001f600"},
                                                       {"a\x1b[m\x7f", "a?[m?"},
                                                       {"\u009b"
                                                        "31m\xc2",
                                                        "??31m?"},
                                                       {"\xed\xa0\x80\xc0\xaf", "?????"}};
  char* const before = program_invocation_short_name;
  for (auto [name, told] : names) {
    program_invocation_short_name = name.data();
    const auto client = haptic::Client::connect({socket(), {}, false, std::chrono::seconds(10)});
    program_invocation_short_name = before;
    ASSERT_TRUE(client) << client.error().message();
    EXPECT_EQ(daemon_->seen().client_name, told);
  }
}

TEST_F(ClientTest, WhoWaitsForEverIsAnswered) {
  start();
  constexpr auto kForEver = std::chrono::nanoseconds::max();
  auto client = haptic::Client::connect({socket(), "tester", false, kForEver});
  ASSERT_TRUE(client) << client.error().message();
  EXPECT_TRUE(client->devices());
  EXPECT_TRUE(client->setTimeout(kForEver));
  EXPECT_TRUE(client->devices());
}

TEST_F(ClientTest, StatisticsTellWhatTheCollideThreadCouldNotDo) {
  start();
  auto client = connect();
  ASSERT_TRUE(client) << client.error().message();
  const auto statistics = client->statistics();
  ASSERT_TRUE(statistics) << statistics.error().message();
  EXPECT_EQ((*statistics)->missed, 5u);
  EXPECT_EQ((*statistics)->collide_queries, 700u);
  EXPECT_EQ((*statistics)->collide_exhausted, 20u);
  EXPECT_EQ((*statistics)->collide_unsent, 3u);
}

TEST_F(ClientTest, NobodyThereIsDisconnectedAndNamesThePath) {
  const auto client = connect();
  ASSERT_FALSE(client);
  EXPECT_EQ(client.code(), HAPTIC_DISCONNECTED);
  EXPECT_EQ(client.error().where, socket());
  EXPECT_NE(client.error().remedy, "");
}

TEST_F(ClientTest, TheEnvironmentNamesTheSocket) {
  start();
  setenv("HAPTICD_SOCKET", socket().c_str(), 1);
  const auto client = haptic::Client::connect();
  unsetenv("HAPTICD_SOCKET");
  EXPECT_TRUE(client) << client.error().message();
}

/** Whatever keeps the user's own daemon from answering, the machine's is asked. */
TEST_F(ClientTest, TheSearchGoesOnWhereTheFirstSocketCannotBeOne) {
  const std::string runtime = directory_.path() + "/runtime", file = directory_.path() + "/file";
  std::filesystem::create_directories(runtime + "/hapticd");
  std::ofstream(file) << "no folder";
  const int deaf = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);  // As of a daemon that was stopped.
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::string path = runtime + "/hapticd/control.sock";
  path.copy(address.sun_path, sizeof address.sun_path - 1);
  ASSERT_EQ(bind(deaf, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  ASSERT_EQ(listen(deaf, 8), 0);
  const char* const before = getenv("XDG_RUNTIME_DIR");
  const std::string kept = before == nullptr ? "" : before;
  unsetenv("HAPTICD_SOCKET");
  for (const std::string& folder : {runtime, file, directory_.path() + "/" + std::string(90, 'x')}) {
    setenv("XDG_RUNTIME_DIR", folder.c_str(), 1);
    const auto client = haptic::Client::connect({"", "tester", false, milliseconds(50)});
    const bool stopped = folder == runtime;  // It is the one; another has other devices.
    if (client && !stopped) continue;        // This machine has a daemon.
    ASSERT_FALSE(client);
    const bool goes_on = client.error().where.find("/run/hapticd/control.sock") != std::string::npos;
    EXPECT_EQ(goes_on, !stopped) << client.error().message();
    EXPECT_EQ(client.code(), stopped ? HAPTIC_TIMEOUT : HAPTIC_DISCONNECTED) << client.error().message();
  }
  before == nullptr ? unsetenv("XDG_RUNTIME_DIR") : setenv("XDG_RUNTIME_DIR", kept.c_str(), 1);
  close(deaf);
}

TEST_F(ClientTest, AnotherMajorVersionIsRefused) {
  start({.protocol_major = 2});
  const auto client = connect();
  EXPECT_EQ(client.code(), HAPTIC_VERSION_MISMATCH);
  EXPECT_NE(client.error().what.find("protocol 2"), std::string::npos) << client.error().what;
}

TEST_F(ClientTest, TheAdministrationSocketIsNotMistaken) {
  start();
  auto client = haptic::Client::connect({socket(), "tester", true, std::chrono::seconds(10)});
  EXPECT_EQ(client.code(), HAPTIC_PERMISSION_DENIED);
  daemon_->script([](Script& script) { script.administration = true; });
  client = haptic::Client::connect({socket(), "tester", true, std::chrono::seconds(10)});
  ASSERT_TRUE(client) << client.error().message();
  EXPECT_EQ((*client->daemon())->administration, 1u);
}

TEST_F(ClientTest, ListsDevicesWithTheirDataSheets) {
  start();
  auto client = connect();
  ASSERT_TRUE(client);
  auto devices = client->devices();
  ASSERT_TRUE(devices);
  ASSERT_EQ(haptic::items(*devices).size(), 2u);
  const haptic_device_info& one = *haptic::items(*devices)[0];
  EXPECT_STREQ(one.uri, "sim://one");
  EXPECT_EQ(one.open, 1u);
  EXPECT_EQ(one.max_force, 8);
  EXPECT_EQ(one.abilities, unsigned{HAPTIC_SENSES_POSITION | HAPTIC_HAS_DEADMAN});
  EXPECT_EQ(one.workspace_upper[2], 0.1);
  EXPECT_STREQ(haptic::items(*devices)[1]->uri, "sim://two");
}

TEST_F(ClientTest, TextsAreTheCallers) {
  start();
  auto client = connect();
  ASSERT_TRUE(client);
  auto json = client->get("/objects/C/pos");
  ASSERT_TRUE(json);
  EXPECT_EQ(*json, R"({"path": "/objects/C/pos"})");
}

TEST_F(ClientTest, WhatAnOlderDaemonLacksIsUnsupported) {
  start();
  auto client = connect();
  ASSERT_TRUE(client);
  EXPECT_EQ(client->dump().code(), HAPTIC_UNSUPPORTED);
  EXPECT_TRUE(client->get("/x")) << "the connection stands";
}

TEST_F(ClientTest, ASilentDaemonIsATimeoutAndTheConnectionStands) {
  start({.dawdle = true});
  auto client = connect();
  ASSERT_TRUE(client);
  ASSERT_TRUE(client->setTimeout(milliseconds(50)));
  const auto before = std::chrono::steady_clock::now();
  EXPECT_EQ(client->devices().code(), HAPTIC_TIMEOUT);
  EXPECT_GE(std::chrono::steady_clock::now() - before, milliseconds(50));
  ASSERT_TRUE(client->setTimeout(std::chrono::seconds(10)));
  EXPECT_TRUE(client->get("/x"));
}

TEST_F(ClientTest, ARefusalOfTheSceneComesWhole) {
  start();
  auto client = connect();
  ASSERT_TRUE(client);
  haptic_object object = HAPTIC_OBJECT_INIT;
  object.name = "taken";
  auto made = client->scene().create(object);
  ASSERT_FALSE(made);
  EXPECT_EQ(made.code(), HAPTIC_ALREADY_EXISTS);
  EXPECT_EQ(made.error().message(), "taken: exists (choose another name)");
  object.name = nullptr;
  EXPECT_EQ(client->scene().create(object).error().where, "haptic_object.name");
  object.name = "fine";
  object.shape.kind = 99;
  EXPECT_EQ(client->scene().create(object).error().where, "shape.kind");
  object.shape.kind = HAPTIC_SHAPE_SPHERE;
  made = client->scene().create(object);
  ASSERT_TRUE(made);
  EXPECT_EQ(made->id(), 65537u);
  EXPECT_EQ((*made->state())->object->material.stiffness, 123);
  made->release();
}

/** For this library, where a newer one may have a field that its program uses. */
TEST_F(ClientTest, ReservedFieldsThatAreSetAreRefused) {
  start();
  auto client = connect();
  ASSERT_TRUE(client);
  haptic_client* const c = client->get();
  haptic_shape shape{};
  haptic_object object = HAPTIC_OBJECT_INIT;
  object.name = "fine";
  haptic_surface surface = HAPTIC_SURFACE_INIT;
  haptic_effect effect = HAPTIC_EFFECT_INIT;
  haptic_events_options options = HAPTIC_EVENTS_OPTIONS_INIT;
  haptic_device_limits limits{};
  limits.size = sizeof limits;
  shape.reserved = object.shape.reserved = surface.reserved = effect.reserved = options.reserved = limits.reserved = 1;
  haptic_events* events = nullptr;
  haptic_error error = HAPTIC_ERROR_INIT;
  const auto refused = [&](int code) {
    EXPECT_EQ(code, HAPTIC_UNSUPPORTED) << error.where << ": " << error.what;
    return std::string(error.where);
  };
  EXPECT_EQ(refused(haptic_object_set_shape(c, "fine", &shape, &error)), "haptic_shape.reserved");
  EXPECT_EQ(refused(haptic_object_create(c, &object, nullptr, &error)), "haptic_shape.reserved");
  EXPECT_EQ(refused(haptic_object_set_surface(c, "fine", &surface, &error)), "haptic_surface.reserved");
  EXPECT_EQ(refused(haptic_object_set_effect(c, "fine", &effect, &error)), "haptic_effect.reserved");
  EXPECT_EQ(refused(haptic_events_open(c, &options, &events, &error)), "haptic_events_options.reserved");
  EXPECT_EQ(refused(haptic_device_set_limits(c, "", &limits, nullptr, &error)), "haptic_device_limits.reserved");
}

TEST_F(ClientTest, ComesBackAfterTheDaemonRestarted) {
  start();
  auto client = connect();
  ASSERT_TRUE(client);
  daemon_ = nullptr;
  ASSERT_TRUE(eventually([&] { return !client->connected(); }));
  EXPECT_EQ(client->devices().code(), HAPTIC_DISCONNECTED);
  EXPECT_EQ(client->reconnect().code(), HAPTIC_DISCONNECTED);
  restart(2);
  const auto back = client->reconnect();
  ASSERT_TRUE(back) << back.error().message();
  EXPECT_EQ((*client->daemon())->epoch, 2u);
  EXPECT_TRUE(client->devices());
  EXPECT_TRUE(client->reconnect()) << "a standing connection is left alone";
}

/** Which the library's thread may come to later than the call that found it out. */
TEST_F(ClientTest, NoConnectionStandsOnceACallHasFoundTheDaemonGone) {
  for (int i = 0; i < 30; ++i) {
    start();
    auto client = connect();
    ASSERT_TRUE(client);
    std::vector<haptic::Session> sessions;
    for (int s = 0; s < 4; ++s) {
      auto session = client->openSession();
      ASSERT_TRUE(session);
      sessions.push_back(std::move(*session));
    }
    std::thread killer([&] {
      std::this_thread::sleep_for(std::chrono::microseconds(300 * i));
      daemon_ = nullptr;
    });
    while (client->devices()) {
    }
    EXPECT_EQ(client->reconnect().code(), HAPTIC_DISCONNECTED);
    killer.join();
  }
}

TEST_F(ClientTest, ManyThreadsMayCall) {
  start();
  auto client = connect();
  ASSERT_TRUE(client);
  std::atomic<int> good{0};
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&] {
      for (int k = 0; k < 25; ++k) good += client->devices().ok() ? 1 : 0;
    });
  }
  for (auto& thread : threads) thread.join();
  EXPECT_EQ(good, 100);
}

TEST_F(ClientTest, TheProgramKeepsItsSignals) {
  struct sigaction before {};
  sigaction(SIGPIPE, nullptr, &before);
  start();
  struct sigaction mine {};
  mine.sa_handler = SIG_DFL;
  sigaction(SIGPIPE, &mine, nullptr);
  const auto client = connect();
  ASSERT_TRUE(client);
  struct sigaction after {};
  sigaction(SIGPIPE, nullptr, &after);
  EXPECT_EQ(after.sa_handler, SIG_DFL);
  sigaction(SIGPIPE, &before, nullptr);
}

TEST_F(ClientTest, AChildOfForkIsRefusedAndHoldsNothing) {
  start();
  auto client = connect();
  ASSERT_TRUE(client);
  auto session = client->openSession();
  ASSERT_TRUE(session);
  int gate[2];
  ASSERT_EQ(pipe(gate), 0);
  const pid_t child = fork();
  if (child == 0) {
    int bad = 0;
    haptic_sample sample;
    bad |= client->connected() ? 1 : 0;
    bad |= client->devices().code() != HAPTIC_DISCONNECTED ? 2 : 0;
    bad |= haptic_session_latest(session->get(), &sample) != HAPTIC_DISCONNECTED ? 4 : 0;
    char byte;
    close(gate[1]);
    (void)!read(gate[0], &byte, 1);  // until the parent has looked
    haptic_session_close(session->get());
    _exit(bad);
  }
  close(gate[0]);
  EXPECT_TRUE(client->devices()) << "the parent goes on";
  // If the child held the socket, the daemon would not see the parent go.
  *session = haptic::Session(nullptr);
  *client = haptic::Client(nullptr);
  EXPECT_TRUE(eventually([&] { return daemon_->seen().open_sessions == 0; }));
  close(gate[1]);
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

}  // namespace
}  // namespace hapticd::test
