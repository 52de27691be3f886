// A daemon that hangs up at the worst moment.
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <atomic>
#include <hapticclient/hapticclient.hpp>
#include <thread>

#include "tests/support/process/daemon_fixture.h"
#include "tests/support/process/temporary_directory.h"

namespace hapticd::test {
namespace {

sockaddr_un addressOf(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof address.sun_path - 1);
  return address;
}

/** Between a client and the daemon: hands on what they say, one connection after the other, and cuts when told. */
class Cutter {
 public:
  explicit Cutter(std::string daemon) : daemon_(std::move(daemon)), listener_(socket(AF_UNIX, SOCK_STREAM, 0)) {
    const sockaddr_un address = addressOf(path());
    EXPECT_EQ(bind(listener_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    EXPECT_EQ(listen(listener_, 4), 0);
    thread_ = std::thread([this] { run(); });
  }
  ~Cutter() {
    shutdown(listener_, SHUT_RDWR);
    cut_next_ = true;
    thread_.join();
    close(listener_);
  }
  Cutter(const Cutter&) = delete;
  Cutter& operator=(const Cutter&) = delete;

  [[nodiscard]] std::string path() const { return directory_.path() + "/cut.sock"; }
  /** The daemon's next word still comes through. */
  void cutAfterNextWord() { cut_next_ = true; }

 private:
  void run() {
    for (int client = -1; (client = accept(listener_, nullptr, nullptr)) >= 0;) {
      const int daemon = socket(AF_UNIX, SOCK_STREAM, 0);
      const sockaddr_un address = addressOf(daemon_);
      if (connect(daemon, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) between(client, daemon);
      close(daemon);
      close(client);
      cut_next_ = false;
    }
  }
  void between(int client, int daemon) {
    for (;;) {
      pollfd both[] = {{client, POLLIN, 0}, {daemon, POLLIN, 0}};
      if (poll(both, 2, 10'000) <= 0) return;
      char room[65536];
      for (const pollfd& from : both) {
        if (from.revents == 0) continue;
        const ssize_t n = recv(from.fd, room, sizeof room, 0);
        if (n <= 0) return;
        const bool last = from.fd == daemon && cut_next_;
        if (send(from.fd == daemon ? client : daemon, room, static_cast<std::size_t>(n), MSG_NOSIGNAL) != n) return;
        if (last) return;
      }
    }
  }

  std::string daemon_;
  TemporaryDirectory directory_;
  int listener_;
  std::atomic<bool> cut_next_{false};
  std::thread thread_;
};

/** What waits for events must hear of it, and a new link must renew them, however soon after the answer it comes. */
TEST(Cut, ASubscriptionThatWasJustAnsweredHearsOfIt) {
  DaemonFixture daemon{{.program = HAPTICD_PROGRAM, .config = {}}};
  ASSERT_TRUE(daemon.running()) << daemon.log();
  Cutter cutter(daemon.socket());
  auto client = haptic::Client::connect({cutter.path(), "cut", false});
  ASSERT_TRUE(client) << client.error().message();
  int opened = 0;
  for (int round = 0; round < 20; ++round) {
    cutter.cutAfterNextWord();
    auto events = client->subscribe();
    if (events) {
      ++opened;
      auto event = events->next(std::chrono::seconds(1));
      while (event) event = events->next(std::chrono::seconds(1));  // What came with the answer.
      EXPECT_EQ(event.error().code, HAPTIC_DISCONNECTED) << "round " << round;
    }
    ASSERT_TRUE(client->reconnect());
    if (events) {
      const std::string name = "told" + std::to_string(round);
      haptic_object object = HAPTIC_OBJECT_INIT;
      object.name = name.c_str();
      ASSERT_TRUE(client->scene().create(object));
      auto event = events->next(std::chrono::seconds(2));
      while (event && event->object != name) event = events->next(std::chrono::seconds(2));
      EXPECT_TRUE(event) << "round " << round;
    }
  }
  EXPECT_GT(opened, 0);
}

}  // namespace
}  // namespace hapticd::test
