// A child of fork() closes every handle that it got from its parent: nothing of the parent's ends, nor does the child.
#include <gtest/gtest.h>
#include <hapticclient/hapticclient.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <thread>

#include "tests/support/process/daemon_fixture.h"

namespace hapticd::test {
namespace {

TEST(Fork, AChildMayCloseAllHandlesAndTheParentGoesOn) {
  DaemonFixture daemon({.program = HAPTICD_PROGRAM});
  ASSERT_TRUE(daemon.running()) << daemon.log();
  haptic_error error{};
  error.size = sizeof error;
  haptic_connect_options options = HAPTIC_CONNECT_OPTIONS_INIT;
  const std::string socket = daemon.socket();
  options.socket = socket.c_str();
  haptic_client* client = nullptr;
  haptic_session* session = nullptr;
  haptic_recording* recording = nullptr;
  haptic_upload* upload = nullptr;
  haptic_events* events = nullptr;
  ASSERT_EQ(haptic_connect(&options, &client, &error), HAPTIC_OK) << error.what;
  ASSERT_EQ(haptic_session_open(client, nullptr, &session, &error), HAPTIC_OK) << error.what;
  ASSERT_EQ(haptic_recording_start(client, nullptr, &recording, &error), HAPTIC_OK) << error.what;
  ASSERT_EQ(haptic_upload_begin(client, 3, 1, 0, &upload, &error), HAPTIC_OK) << error.what;
  ASSERT_EQ(haptic_events_open(client, nullptr, &events, &error), HAPTIC_OK) << error.what;

  const pid_t child = fork();
  if (child == 0) {
    haptic_recording_close(recording);
    haptic_upload_close(upload);
    haptic_events_close(events);
    haptic_session_close(session);
    haptic_disconnect(client);
    _exit(0);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status)) << "signal " << WTERMSIG(status);

  EXPECT_EQ(haptic_session_check(session), HAPTIC_OK);
  EXPECT_EQ(haptic_recording_stop(recording, nullptr, &error), HAPTIC_OK) << error.what;
  haptic_status* now = nullptr;
  EXPECT_EQ(haptic_get_status(client, &now, &error), HAPTIC_OK) << error.what;
  haptic_free(now);
  haptic_events_close(events);
  haptic_upload_close(upload);
  haptic_recording_close(recording);
  haptic_session_close(session);
  haptic_disconnect(client);
}

TEST(Fork, AChildIsRefusedWhereItHasNoMemory) {
  DaemonFixture daemon({.program = HAPTICD_PROGRAM});
  ASSERT_TRUE(daemon.running()) << daemon.log();
  haptic_error error = HAPTIC_ERROR_INIT;
  haptic_connect_options options = HAPTIC_CONNECT_OPTIONS_INIT;
  const std::string socket = daemon.socket();
  options.socket = socket.c_str();
  haptic_client* client = nullptr;
  haptic_session* session = nullptr;
  haptic_upload* upload = nullptr;
  ASSERT_EQ(haptic_connect(&options, &client, &error), HAPTIC_OK) << error.what;
  ASSERT_EQ(haptic_session_open(client, nullptr, &session, &error), HAPTIC_OK) << error.what;
  ASSERT_EQ(haptic_upload_begin(client, 3, 1, HAPTIC_MESH_VOLUME, &upload, &error), HAPTIC_OK) << error.what;

  const pid_t child = fork();
  if (child == 0) {
    haptic_acks acks;
    haptic_session_info* session_info = nullptr;
    haptic_daemon_info* daemon_info = nullptr;
    int wrong = 0;
    wrong |= haptic_session_acks(session, &acks) == HAPTIC_DISCONNECTED ? 0 : 1;
    wrong |= haptic_upload_vertices(upload) == nullptr ? 0 : 2;
    wrong |= haptic_upload_triangles(upload) == nullptr ? 0 : 4;
    wrong |= haptic_upload_weld(upload, 0.001, nullptr) == HAPTIC_DISCONNECTED ? 0 : 8;
    wrong |= haptic_upload_volume(upload, 0.001, 0, nullptr) == HAPTIC_DISCONNECTED ? 0 : 16;
    wrong |= haptic_session_describe(session, &session_info, nullptr) == HAPTIC_DISCONNECTED ? 0 : 32;
    wrong |= haptic_get_daemon_info(client, &daemon_info, nullptr) == HAPTIC_DISCONNECTED ? 0 : 64;
    // Nor did the daemon end it, as one is told that may open it again.
    bool told = haptic_session_disarm(session, &error) == HAPTIC_DISCONNECTED && error.where[0] == 'p';
    haptic_error push = HAPTIC_ERROR_INIT;
    const haptic_clear_model none{};
    told = told && haptic_push_clear_model(session, &none, nullptr) == HAPTIC_DISCONNECTED;
    told = told && haptic_push_refusal(session, &push) == HAPTIC_DISCONNECTED && push.where[0] == 'p';
    wrong |= told ? 0 : 128;
    _exit(wrong);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status)) << "signal " << WTERMSIG(status);
  EXPECT_EQ(WEXITSTATUS(status), 0);
  EXPECT_EQ(haptic_upload_weld(upload, 0.001, &error), HAPTIC_OK) << error.what;
  haptic_upload_close(upload);
  haptic_session_close(session);
  haptic_disconnect(client);
}

/** Of this process, of the first 256 descriptors. For a child of many threads: it calls nothing that takes a lock. */
int socketsOpen() {
  int count = 0;
  for (int fd = 0; fd < 256; ++fd) {
    struct stat info {};
    if (fstat(fd, &info) == 0 && S_ISSOCK(info.st_mode)) ++count;
  }
  return count;
}

TEST(Fork, AChildKeepsNoConnectionWheneverItIsBorn) {
  DaemonFixture daemon({.program = HAPTICD_PROGRAM});
  ASSERT_TRUE(daemon.running()) << daemon.log();
  const std::string socket = daemon.socket();
  const int before = socketsOpen();
  std::atomic<bool> over{false};
  std::atomic<int> connected{0};
  std::thread busy([&] {
    haptic_connect_options options = HAPTIC_CONNECT_OPTIONS_INIT;
    options.socket = socket.c_str();
    while (!over) {
      haptic_client* client = nullptr;
      if (haptic_connect(&options, &client, nullptr) == HAPTIC_OK) ++connected;
      haptic_disconnect(client);
    }
  });
  int kept = 0;
  for (int i = 0; i < 300; ++i) {
    const pid_t child = fork();
    if (child == 0) _exit(socketsOpen() == before ? 0 : 1);
    int status = 0;
    if (waitpid(child, &status, 0) != child || status != 0) ++kept;
  }
  over = true;
  busy.join();
  EXPECT_EQ(kept, 0);
  EXPECT_GT(connected, 10);
}

}  // namespace
}  // namespace hapticd::test
