// What the service manager is told of servos that are stepped by hand.
#include "daemon/main/supervisor.h"

#include <gmock/gmock.h>
#include <sys/socket.h>
#include <sys/un.h>

#include "tests/session/bench.h"
#include "tests/session/still_device.h"
#include "tests/support/process/temporary_directory.h"

namespace hapticd::test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

/** A service manager that wants to hear of a watchdog every 3 s. */
class Manager {
 public:
  explicit Manager(const char* watchdog_us = "3000000") {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path_.copy(address.sun_path, sizeof address.sun_path - 1);
    EXPECT_EQ(bind(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    setenv("NOTIFY_SOCKET", path_.c_str(), 1);
    setenv("WATCHDOG_USEC", watchdog_us, 1);
  }
  Manager(const Manager&) = delete;
  Manager& operator=(const Manager&) = delete;
  ~Manager() {
    unsetenv("NOTIFY_SOCKET");
    unsetenv("WATCHDOG_USEC");
    close(socket_);
  }
  /** Since the last call, what begins with that. */
  std::vector<std::string> hears(std::string_view beginning = {}) {
    std::vector<std::string> all;
    char text[512];
    for (ssize_t n; (n = recv(socket_, text, sizeof text, MSG_DONTWAIT)) >= 0;) {
      std::string one(text, static_cast<std::size_t>(n));
      if (one.starts_with(beginning)) all.push_back(std::move(one));
    }
    return all;
  }

 private:
  TemporaryDirectory directory_;
  std::string path_ = directory_.path() + "/notify";
  int socket_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
};

class SupervisorTest : public testing::Test {
 protected:
  explicit SupervisorTest(const char* watchdog_us = "3000000") : manager(watchdog_us) {}
  void openSecond() {
    const auto opened = bench.core.devices().openGroup({"second", {"test://second"}, 1000});
    ASSERT_TRUE(opened.ok()) << toString(opened.error());
  }
  void run(int periods) {
    for (int i = 0; i < periods; ++i) {
      bench.step();
      supervisor.step();
    }
  }
  /** Only the first servo does. */
  void runFirst(int periods) {
    for (int i = 0; i < periods; ++i) {
      bench.core.devices().links().front()->group().step();
      bench.core.poll();
      supervisor.step();
    }
  }
  Manager manager;
  Bench bench;
  Supervisor supervisor{bench.core, true};
};

TEST_F(SupervisorTest, IsReadyWhenTheLastServoHasRunCleanCycles) {
  run(50);
  openSecond();
  const auto& links = bench.core.devices().links();
  while (links[1]->cycles() + 1 < Supervisor::kCleanCycles) run(1);
  EXPECT_GT(links[0]->cycles(), Supervisor::kCleanCycles);
  EXPECT_FALSE(supervisor.ready());
  EXPECT_THAT(manager.hears(), IsEmpty()) << "no watchdog and no status before it is ready";
  run(1);
  EXPECT_TRUE(supervisor.ready());
  EXPECT_THAT(manager.hears("READY"), ElementsAre("READY=1"));
  run(2000);
  EXPECT_THAT(manager.hears("READY"), IsEmpty()) << "once";
}

TEST_F(SupervisorTest, PingsThriceInTheWatchdogsTimeWhileEveryServoRuns) {
  openSecond();
  run(100);
  EXPECT_THAT(manager.hears("WATCHDOG"), ElementsAre("WATCHDOG=1"));
  run(5990);
  EXPECT_EQ(manager.hears("WATCHDOG").size(), 5u);
  run(20);
  EXPECT_THAT(manager.hears("WATCHDOG"), ElementsAre("WATCHDOG=1"));
}

TEST_F(SupervisorTest, DoesNotPingWhileOneServoStandsStill) {
  openSecond();
  run(1500);
  EXPECT_THAT(manager.hears("WATCHDOG"), ElementsAre("WATCHDOG=1", "WATCHDOG=1"));
  runFirst(1000);  // The second has run since the last ping.
  EXPECT_THAT(manager.hears("WATCHDOG"), ElementsAre("WATCHDOG=1"));
  runFirst(5000);
  EXPECT_THAT(manager.hears("WATCHDOG"), IsEmpty());
  run(1000);
  EXPECT_THAT(manager.hears("WATCHDOG"), ElementsAre("WATCHDOG=1")) << "it runs again";
}

TEST_F(SupervisorTest, AServoThatIsNewDoesNotStandStill) {
  run(1100);
  manager.hears();
  openSecond();
  runFirst(1000);
  EXPECT_THAT(manager.hears("WATCHDOG"), ElementsAre("WATCHDOG=1"));
}

TEST_F(SupervisorTest, SaysEachSecondHowDevicesAre) {
  openSecond();
  const std::string names[] = {bench.device(0).name, bench.device(1).name};
  const std::string note = bench.core.devices().realtime() ? "" : "; not real-time";
  const auto status = [&](const char* first) {
    run(1000);
    EXPECT_THAT(manager.hears("STATUS"), ElementsAre("STATUS=" + names[0] + " 1000 Hz, 0 missed, " + first + "; " +
                                                     names[1] + " 1000 Hz, 0 missed, disarmed" + note));
  };
  run(200);
  EXPECT_EQ(manager.hears("STATUS").size(), 1u);
  status("disarmed");
  const Session* session = bench.live();
  ASSERT_TRUE(bench.arm(session->id).ok());
  status("armed");
  ASSERT_TRUE(bench.core.stop("test://first", bench.connection).ok());
  status(std::string(faultText(HD_FAULT_STOP_LINE)).c_str());
}

TEST_F(SupervisorTest, SaysThatTheDaemonStops) {
  supervisor.stopping();
  EXPECT_THAT(manager.hears(), ElementsAre("STOPPING=1"));
}

TEST_F(SupervisorTest, SaysNothingToNobodyWhoAsked) {
  Supervisor silent(bench.core, false);
  for (int i = 0; i < 1200; ++i) bench.step(), silent.step();
  EXPECT_TRUE(silent.ready());
  silent.stopping();
  EXPECT_THAT(manager.hears(), IsEmpty());
}

struct WithoutWatchdog : SupervisorTest {
  WithoutWatchdog() : SupervisorTest("0") {}
};

TEST_F(WithoutWatchdog, IsReadyButDoesNotPing) {
  run(3000);
  EXPECT_TRUE(supervisor.ready());
  EXPECT_THAT(manager.hears("WATCHDOG"), IsEmpty());
}

/** Does not answer. */
struct Dead final : StillDevice {
  explicit Dead(std::string uri) : StillDevice("dead", std::move(uri)) {}
  Result<void> open() override { return silence(); }
  void giveUp() noexcept override {}
  void close() noexcept override {}
};

TEST(SupervisorWithoutDevices, IsReadyAndSaysWhatIsMissing) {
  Manager manager;
  ManualClock clock{1'000'000'000};
  CoreOptions options;
  options.config = Bench::relaxed();
  options.config.groups = {{"left", {"a://dead"}, 1000, {}}, {"right", {"b://dead"}, 1000, {}}};
  options.threads = false;
  Core core(options, clock);
  core.devices().setFactory([](std::string_view uri) -> Result<std::unique_ptr<Device>> {
    return std::unique_ptr<Device>(std::make_unique<Dead>(std::string(uri)));
  });
  ASSERT_TRUE(core.openConfigured([] { return false; }).ok());
  while (!core.wanted().settled()) core.poll();
  Supervisor supervisor(core, true);
  supervisor.step();
  EXPECT_TRUE(supervisor.ready());
  EXPECT_THAT(manager.hears("READY"), ElementsAre("READY=1"));
  clock.advance(2'000'000'000);
  supervisor.step();
  EXPECT_THAT(manager.hears("STATUS"), ElementsAre(testing::StartsWith("STATUS=a://dead missing; b://dead missing")));
}

}  // namespace
}  // namespace hapticd::test
