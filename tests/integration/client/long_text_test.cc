// A text beyond any measure is refused by the library: the daemon would hang up, and sessions would end with it.
#include <gtest/gtest.h>

#include <hapticclient/hapticclient.hpp>

#include "tests/support/process/daemon_fixture.h"

namespace hapticd::test {
namespace {

TEST(LongText, IsRefusedWhereverOneIsTakenAndNothingIsLost) {
  DaemonFixture daemon({.program = HAPTICD_PROGRAM});
  ASSERT_TRUE(daemon.running()) << daemon.log();
  auto client = haptic::Client::connect({daemon.socket(), "wordy", false});
  ASSERT_TRUE(client) << client.error().message();
  auto session = client->openSession();
  ASSERT_TRUE(session) << session.error().message();

  const std::string text(3 << 20, 'a');
  haptic_object object = HAPTIC_OBJECT_INIT;
  object.name = text.c_str();
  haptic_device_limits limits{};
  limits.size = sizeof limits;
  int fd = -1;
  haptic_object_state* state = nullptr;
  haptic_surface surface = HAPTIC_SURFACE_INIT;
  haptic_effect effect = HAPTIC_EFFECT_INIT;
  haptic_client* const c = client->get();
  const int codes[] = {
      client->get(text).code(),
      client->set(text).code(),
      client->openDevice(text).code(),
      client->closeDevice(text).code(),
      client->stop(text).code(),
      client->setLimits(text, limits).code(),
      client->statistics(text).code(),
      client->record(text).code(),
      client->openSession(text).code(),
      client->openSession({}, text).code(),
      haptic_object_create(c, &object, nullptr, nullptr),
      haptic_object_find(c, text.c_str(), &state, nullptr),
      haptic_object_remove(c, text.c_str(), nullptr),
      haptic_object_set_surface(c, text.c_str(), &surface, nullptr),
      haptic_object_set_effect(c, text.c_str(), &effect, nullptr),
      haptic_object_volume_file(c, text.c_str(), &fd, nullptr),
      haptic::Client::connect({daemon.socket(), text, false}).code(),
  };
  for (std::size_t i = 0; i < std::size(codes); ++i) EXPECT_EQ(codes[i], HAPTIC_INVALID_ARGUMENT) << i;
  EXPECT_TRUE(client->connected());
  EXPECT_TRUE(session->alive());
  EXPECT_NE(client->get(text).error().remedy.find("131072 bytes"), std::string::npos);

  // What is long and no more is the daemon's to refuse, who says where.
  EXPECT_EQ(client->get(std::string(70'000, 'a')).error().where, "byte 4096");
}

}  // namespace
}  // namespace hapticd::test
