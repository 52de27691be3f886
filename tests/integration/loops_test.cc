// What ControlServer goes on with when it has no memory for a moment.
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <new>

#include "daemon/control/core.h"
#include "daemon/rpc/listen_socket.h"
#include "daemon/rpc/server.h"
#include "tests/integration/raw_client.h"
#include "tests/support/process/temporary_directory.h"

namespace hapticd::test {
namespace {

/** Has no memory for the next delay of that length. */
class ForgetfulTimer final : public kj::Timer {
 public:
  explicit ForgetfulTimer(kj::Timer& timer) : timer_(timer) {}
  void forget(kj::Duration delay) { forgotten_ = delay; }
  [[nodiscard]] bool forgot() const { return forgotten_ == kNever; }

  kj::TimePoint now() const override { return timer_.now(); }
  kj::Promise<void> atTime(kj::TimePoint time) override { return timer_.atTime(time); }
  kj::Promise<void> afterDelay(kj::Duration delay) override {
    if (delay == forgotten_) {
      forgotten_ = kNever;
      throw std::bad_alloc();
    }
    return timer_.afterDelay(delay);
  }

 private:
  static constexpr kj::Duration kNever = 0 * kj::SECONDS;
  kj::Timer& timer_;
  kj::Duration forgotten_ = kNever;
};

int descriptorsInUse() {
  return static_cast<int>(std::distance(std::filesystem::directory_iterator("/proc/self/fd"), {}));
}

class Loops : public testing::Test {
 protected:
  Loops() {
    log::setLevel(log::Level::kOff);
    options.threads = false;
    server.onStep([this] { ++steps; });
    auto socket = ListenSocket::bind(path, 0600, {});
    EXPECT_TRUE(socket.ok());
    server.serve(std::move(*socket->share()), false);
    listening = std::move(*socket);
  }
  ~Loops() noexcept override { log::setLevel(log::Level::kInfo); }

  /** It waits to be accepted. */
  [[nodiscard]] UniqueFd connected() const {
    UniqueFd fd(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
    connect(fd);
    return fd;
  }
  void connect(const UniqueFd& fd) const {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    EXPECT_EQ(::connect(fd.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  }

  TemporaryDirectory directory;
  std::string path = directory.path() + "/control.sock";
  Loop loop;
  MonotonicClock clock;
  CoreOptions options;
  Core core{options, clock};
  ForgetfulTimer timer{loop.io.provider->getTimer()};
  ControlServer server{core, *loop.io.lowLevelProvider, timer};
  ListenSocket listening;
  int steps = 0;
};

TEST_F(Loops, TheStepsGoOn) {
  ASSERT_TRUE(loop.until([this] { return steps > 2; }));
  timer.forget(5 * kj::MILLISECONDS);
  ASSERT_TRUE(loop.until([this] { return timer.forgot(); }));
  const int before = steps;
  EXPECT_TRUE(loop.until([&] { return steps > before + 2; }));
}

TEST_F(Loops, ConnectionsAreTakenAgain) {
  const UniqueFd early(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  rlimit all{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &all), 0);
  const rlimit few{3, all.rlim_max};
  loop.pause(20);
  timer.forget(100 * kj::MILLISECONDS);
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &few), 0);
  connect(early);
  const bool forgot = loop.until([this] { return timer.forgot(); });
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &all), 0);
  ASSERT_TRUE(forgot);
  RawClient client(loop, path);
  bool answered = false;
  const auto state =
      client.daemon.stateRequest().send().then([&](auto&&) { answered = true; }).eagerlyEvaluate(nullptr);
  EXPECT_TRUE(loop.until([&] { return answered; }));
}

/** Whose connect() was through before somebody removed the socket. */
TEST_F(Loops, WhoWaitsInASocketThatIsReplacedIsServed) {
  const int open_before = descriptorsInUse();
  const UniqueFd early = connected(), earlier = connected();
  ASSERT_EQ(std::remove(path.c_str()), 0);
  ASSERT_TRUE(listening.renew().ok());
  server.serve(std::move(*listening.share()), false);
  const UniqueFd late = connected();
  EXPECT_TRUE(loop.until([&] { return core.clients().all().size() == 3; })) << core.clients().all().size();
  for (const UniqueFd* each : {&early, &earlier, &late}) {
    char byte = 0;
    EXPECT_TRUE(::recv(each->get(), &byte, 1, MSG_DONTWAIT) < 0 && errno == EAGAIN) << "it is not hung up on";
  }
  const int before = steps;
  ASSERT_TRUE(loop.until([&] { return steps > before + 4; }));
  EXPECT_EQ(descriptorsInUse(), open_before + 6) << "both ends of three connections: the former socket is closed";
}

/** Accepted in the very turn of the loop in which a step finds that nobody waits any more. */
TEST_F(Loops, WhoIsAcceptedAsAStepLooksIsServed) {
  ASSERT_TRUE(loop.until([this] { return steps > 2; }));
  for (int round = 0; round < 20; ++round) {
    const std::size_t before = core.clients().all().size();
    const UniqueFd early = connected();
    ASSERT_EQ(std::remove(path.c_str()), 0);
    ASSERT_TRUE(listening.renew().ok());
    server.serve(std::move(*listening.share()), false);
    ::usleep(10'000);  // The next step is overdue.
    EXPECT_TRUE(loop.until([&] { return core.clients().all().size() > before; }, 1)) << "in round " << round;
    server.closeAll();
  }
}

}  // namespace
}  // namespace hapticd::test
