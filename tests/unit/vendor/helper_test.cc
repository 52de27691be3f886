// A device through a real hapticd-vendor with the played SDK in it: its life, and each way it can die. What the SDK
// does is seen in a file that both processes map. Nothing here is timed: each wait ends when what it waits for has
// happened.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <thread>

#include "drivers/vendor/helper_device.h"
#include "drivers/vendor/helper_protocol.h"
#include "drivers/vendor/serve.h"
#include "drivers/vendor/vendor_driver.h"
#include "tests/fakes/vendor_sdk/fake_sdk.h"
#include "tests/support/stepped/push.h"
#include "tests/support/time.h"

namespace hapticd {
namespace {

using ::testing::HasSubstr;
constexpr int kPatience_ms = 20'000;

class Helper : public ::testing::Test {
 protected:
  Helper() {
    const int file = ::mkstemp(path_.data());
    EXPECT_EQ(::ftruncate(file, sizeof(fake_sdk::State)), 0);
    state_ = static_cast<fake_sdk::State*>(
        ::mmap(nullptr, sizeof(fake_sdk::State), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0));
    ::close(file);
    state_->version_major = 3;
    state_->system_type = 33;
    state_->calibrated = true;
    for (int i = 0; i < 9; i += 4) state_->rotation[i] = 1;
    ::setenv("FAKE_SDK_STATE", path_.c_str(), 1);
    ::setenv("FAKE_SDK_THREAD", "1", 1);
  }
  ~Helper() override {
    device_.reset();
    ::munmap(state_, sizeof(fake_sdk::State));
    ::unlink(path_.c_str());
  }

  static HelperOptions options() { return {"", HAPTICD_VENDOR_PROGRAM}; }
  static std::string uriOf(const char* scheme, const char* sdk = FAKE_VENDOR_SDK) {
    return std::string(scheme) + "://default?sdk=" + sdk;
  }
  void make(const std::string& uri, const HelperOptions& from = options()) {
    DeviceInfo info;
    info.uri = uri;
    device_ = std::make_unique<HelperDevice>(info, from, clock_);
  }
  void open(const char* scheme = "dhd") {
    make(uriOf(scheme));
    const auto opened = device_->open();
    ASSERT_TRUE(opened.ok()) << toString(opened.error());
  }
  /** Cycles of a servo that pushes, until that is so. */
  template <class Condition>
  bool until(double newtons, Condition condition) {
    for (int i = 0; i < kPatience_ms; ++i) {
      device_->read(clock_.now(), sample_);
      DeviceCommand command;
      command.enabled = newtons != 0;
      command.force = Vec3(0, 0, newtons);
      device_->write(clock_.now(), command);
      if (condition()) return true;
      clock_.sleepUntil(clock_.now() + kMs);
    }
    return false;
  }
  /** Without a servo. */
  template <class Condition>
  bool silentUntil(Condition condition) {
    for (int i = 0; i < kPatience_ms && !condition(); ++i) clock_.sleepUntil(clock_.now() + kMs);
    return condition();
  }
  /** Up in dhd's axes is z; in HD's, y. */
  double pushed() { return state_->force[1] + state_->force[2]; }
  void pushing(double newtons = 2) {
    ASSERT_TRUE(until(newtons, [&] { return sample_.fresh; }));
    ASSERT_TRUE(until(newtons, [&] { return pushed() == newtons; }));
  }

  std::string path_ = ::testing::TempDir() + "hapticd-sdk-XXXXXX";
  fake_sdk::State* state_;
  MonotonicClock clock_;
  std::unique_ptr<HelperDevice> device_;
  DeviceSample sample_;
};

TEST_F(Helper, ReadingsComeAndForcesGo) {
  for (const char* scheme : {"dhd", "openhaptics"}) {
    open(scheme);
    EXPECT_THAT(device_->info().model, HasSubstr("played"));
    EXPECT_EQ(device_->info().uri, uriOf(scheme));
    EXPECT_NE(device_->helper(), 0);
    state_->place[0] = std::strcmp(scheme, "dhd") == 0 ? 0.02 : 20;
    pushing();
    EXPECT_EQ(device_->calibration(), Calibration::kDone);
    EXPECT_TRUE(until(2, [&] { return sample_.p.norm() == 0.02; }));
    EXPECT_TRUE(until(2, [&] { return device_->roundTrip()->summary().count > 0; })) << scheme;
    device_->close();
    EXPECT_EQ(pushed(), 0);
    EXPECT_FALSE(state_->force_on);
    EXPECT_EQ(state_->owner, 0);
  }
}

TEST_F(Helper, SafeIsZeroAgainstAServoThatGoesOn) {
  open();
  pushing();
  device_->safe();
  EXPECT_TRUE(until(2, [&] { return pushed() == 0; }));
  const int calls = state_->force_calls;
  EXPECT_TRUE(until(2, [&] { return pushed() != 0 || state_->force_calls > calls + 20; }));
  EXPECT_EQ(pushed(), 0);
}

TEST_F(Helper, ASilentServoLosesItsForce) {
  open();
  pushing();
  EXPECT_TRUE(silentUntil([&] { return pushed() == 0; }));
  EXPECT_FALSE(state_->force_on);
}

TEST_F(Helper, ADaemonThatDiesLeavesZero) {
  open();
  pushing();
  // What the kernel does for a dead daemon: its end of the socket closes. Its last order stands in the memory.
  const pid_t helper = device_->helper();
  std::atomic<bool> stop{false};
  std::thread servo([&] {
    while (!stop) device_->write(clock_.now(), test::push(Vec3(0, 0, 2)));
  });
  device_->close();
  stop = true;
  servo.join();
  EXPECT_EQ(pushed(), 0);
  EXPECT_EQ(state_->closed, 1);
  EXPECT_NE(::kill(helper, 0), 0) << "and no process stays behind";
}

TEST_F(Helper, AHelperThatIsKilledIsAFaultAndTheNextZeroesTheDevice) {
  open();
  pushing();
  const pid_t first = device_->helper();
  ::kill(first, SIGKILL);
  // The motors hold what they were told last; the servo goes on pushing until its guard has seen the fault.
  EXPECT_TRUE(until(2, [&] { return (sample_.status & kDeviceGone) != 0; }));
  EXPECT_FALSE(sample_.fresh);
  EXPECT_TRUE(until(0, [&] { return state_->opened == 2 && pushed() == 0; }));
  EXPECT_TRUE(until(0, [&] { return sample_.fresh && sample_.status == kDeviceOk; }));
  EXPECT_NE(device_->helper(), first);
  pushing(1);
}

TEST_F(Helper, ADeathBetweenTwoReadingsIsToldAllTheSame) {
  open();
  pushing();
  const pid_t first = device_->helper();
  ::kill(first, SIGKILL);
  const auto back = [&] {
    return device_->helper() != 0 && device_->helper() != first && device_->calibration() == Calibration::kDone;
  };
  ASSERT_TRUE(silentUntil(back));
  device_->read(clock_.now(), sample_);
  EXPECT_NE(sample_.status & kDeviceGone, 0u);
  EXPECT_FALSE(sample_.fresh);
  EXPECT_TRUE(until(0, [&] { return sample_.fresh && sample_.status == kDeviceOk; })) << "once";
}

TEST_F(Helper, AHelperThatIsStoppedIsSilence) {
  open();
  pushing();
  ::kill(device_->helper(), SIGSTOP);
  int silent = 0;
  EXPECT_TRUE(until(2, [&] { return (silent = sample_.fresh ? 0 : silent + 1) == 30; }));
  ::kill(device_->helper(), SIGCONT);
  EXPECT_TRUE(until(0, [&] { return sample_.fresh && pushed() == 0; }));
}

TEST_F(Helper, ALibraryThatHangsEndsItsProcess) {
  for (const char* scheme : {"dhd", "openhaptics"}) {
    open(scheme);
    pushing();
    state_->hangs = true;
    EXPECT_TRUE(until(2, [&] { return (sample_.status & kDeviceGone) != 0; }));
    state_->hangs = false;
    EXPECT_TRUE(until(0, [&] { return sample_.fresh && sample_.status == kDeviceOk && pushed() == 0; }));
    device_->close();
  }
}

TEST_F(Helper, UnplugIsToldAndReplugFound) {
  for (const char* scheme : {"dhd", "openhaptics"}) {
    open(scheme);
    pushing();
    state_->unplugged = true;
    EXPECT_TRUE(until(2, [&] { return (sample_.status & kDeviceGone) != 0; }));
    EXPECT_EQ(device_->calibration(), Calibration::kNeeded) << "told at once";
    state_->unplugged = false;
    EXPECT_TRUE(until(0, [&] { return sample_.fresh && sample_.status == kDeviceOk && pushed() == 0; }));
    device_->close();
  }
}

/** Its figures, limits and lease are not those of whatever else is plugged in. */
TEST_F(Helper, AnotherDoesNotTakeItsPlace) {
  open();
  pushing();
  state_->unplugged = true;
  EXPECT_TRUE(until(2, [&] { return (sample_.status & kDeviceGone) != 0; }));
  state_->system_type = 60;
  state_->unplugged = false;
  int heard = 0, looks = 0;
  EXPECT_TRUE(until(0, [&] {
    heard += sample_.fresh ? 1 : 0;
    return ++looks > 3 * HelperDevice::kRetry_ms;
  }));
  EXPECT_EQ(heard, 0);
  EXPECT_NE(sample_.status & kDeviceGone, 0u);
  EXPECT_EQ(pushed(), 0);
  state_->system_type = 33;
  EXPECT_TRUE(until(0, [&] { return sample_.fresh && sample_.status == kDeviceOk; }));
}

TEST_F(Helper, OneThatIsUnpluggedAndDoesNotComeBackIsOff) {
  for (const char* scheme : {"dhd", "openhaptics"}) {
    open(scheme);
    pushing();
    EXPECT_FALSE(device_->isOff());
    state_->unplugged = true;
    EXPECT_TRUE(until(2, [&] { return (sample_.status & kDeviceGone) != 0; }));
    EXPECT_TRUE(until(0, [&] { return device_->isOff(); })) << scheme;
    device_->close();
    state_->unplugged = false;
  }
}

TEST_F(Helper, AnOpeningThatHangsCanBeGivenUp) {
  state_->hangs = true;
  make(uriOf("dhd"));
  std::thread other([&] {
    while (state_->calls == 0) std::this_thread::yield();
    device_->giveUp();
  });
  EXPECT_FALSE(device_->open().ok());
  other.join();
  state_->hangs = false;
}

TEST_F(Helper, AnOpeningThatHangsEndsItsProcessWhenTheDaemonIsGone) {
  state_->hangs = true;
  int pair[2];
  ASSERT_EQ(::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, pair), 0);
  const pid_t pid = ::fork();
  ASSERT_GE(pid, 0);
  if (pid == 0) {
    ::close(pair[0]);
    const std::atomic<bool> stop{false};
    ::_exit(serveVendor(pair[1], stop, 50));
  }
  ::close(pair[1]);
  SharedLinkMapping memory;
  ASSERT_TRUE(memory.make().ok());
  ASSERT_TRUE(sendRequest(pair[0], {uriOf("dhd"), 1}, memory.descriptor()).ok());
  ASSERT_TRUE(silentUntil([&] { return state_->calls != 0; }));
  clock_.sleepUntil(clock_.now() + 200 * kMs);
  int status = 0;
  EXPECT_EQ(::waitpid(pid, &status, WNOHANG), 0) << "somebody waits for it";
  ::close(pair[0]);
  bool ended = false;
  EXPECT_TRUE(silentUntil([&] { return ended = ended || ::waitpid(pid, &status, WNOHANG) == pid; }));
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 3) << status;
  if (!ended) ::kill(pid, SIGKILL);
  state_->hangs = false;
}

TEST_F(Helper, WhyItDoesNotOpenIsTold) {
  make(uriOf("dhd", "/nowhere/libdhd.so.3"));
  const auto absent = device_->open();
  ASSERT_FALSE(absent.ok());
  EXPECT_EQ(absent.error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(toString(absent.error()), HasSubstr("/nowhere/libdhd.so.3"));

  state_->unplugged = true;
  make(uriOf("dhd"));
  EXPECT_THAT(toString(device_->open().error()), HasSubstr("no device found"));
  state_->unplugged = false;

  state_->crashes = true;
  EXPECT_THAT(toString(device_->open().error()), HasSubstr("may have crashed"));
  state_->crashes = false;
  EXPECT_TRUE(device_->open().ok()) << "and the next attempt is a new process";

  make(uriOf("dhd"), {"", "/nowhere/hapticd-vendor"});
  EXPECT_EQ(device_->open().error().code, ErrorCode::kNotFound);
  make(uriOf("sim"));
  EXPECT_EQ(device_->open().error().code, ErrorCode::kUnsupported);
}

TEST_F(Helper, AFreshProcessZeroesWhatADeadOneHasArmed) {
  state_->force_on = true;
  state_->force[2] = 2;
  const auto uri = parseDeviceUri(uriOf("dhd"));
  ASSERT_TRUE(uri.ok());
  EXPECT_TRUE(zeroVendor(*uri, options()).ok());
  EXPECT_EQ(pushed(), 0);
  EXPECT_FALSE(state_->force_on);
  state_->unplugged = true;
  EXPECT_FALSE(zeroVendor(*uri, options()).ok());
}

// As under systemd: whoever listens starts the program with the connection as its standard input.
TEST_F(Helper, ComesBySystemdsSocketToo) {
  const std::string path = path_ + ".sock";
  const int listener = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strcpy(address.sun_path, path.c_str());
  ASSERT_EQ(::bind(listener, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  ASSERT_EQ(::listen(listener, 1), 0);
  pid_t pid = 0;
  std::thread manager([&] {
    const int connection = ::accept4(listener, nullptr, nullptr, SOCK_CLOEXEC);
    posix_spawn_file_actions_t files;
    ::posix_spawn_file_actions_init(&files);
    ::posix_spawn_file_actions_adddup2(&files, connection, STDIN_FILENO);
    std::string program = HAPTICD_VENDOR_PROGRAM;
    char* const arguments[] = {program.data(), nullptr};
    EXPECT_EQ(::posix_spawn(&pid, program.c_str(), &files, nullptr, arguments, environ), 0);
    ::posix_spawn_file_actions_destroy(&files);
    ::close(connection);
  });
  make(uriOf("dhd"), {path, "/nowhere"});
  const auto opened = device_->open();
  manager.join();
  ASSERT_TRUE(opened.ok()) << toString(opened.error());
  EXPECT_EQ(device_->helper(), 0);
  pushing();
  device_->close();
  EXPECT_EQ(::waitpid(pid, nullptr, 0), pid) << "it ends when the daemon hangs up";
  EXPECT_EQ(pushed(), 0);
  ::close(listener);
  ::unlink(path.c_str());
}

TEST_F(Helper, WhatIsNoRequestIsRefused) {
  for (const std::size_t size : {0, 1, 100, 5000}) {
    auto process = HelperProcess::start(options());
    ASSERT_TRUE(process.ok());
    const std::string noise(size, 'x');
    ASSERT_EQ(::send(process->socket(), noise.data(), size, MSG_NOSIGNAL), static_cast<ssize_t>(size));
    const auto answer = receiveAnswer(process->socket(), kPatience_ms);
    ASSERT_TRUE(answer.ok());
    EXPECT_EQ(answer.value().opened.error().code, ErrorCode::kVersionMismatch);
  }
}

TEST(HelperAnswers, NoiseIsNoAnswerAndFiguresAreNumbers) {
  int pair[2];
  ASSERT_EQ(::socketpair(AF_UNIX, SOCK_SEQPACKET, 0, pair), 0);
  EXPECT_EQ(receiveAnswer(pair[0], 0).error().code, ErrorCode::kTimeout);
  ASSERT_EQ(::send(pair[1], "hello", 5, 0), 5);
  EXPECT_EQ(receiveAnswer(pair[0], 0).error().code, ErrorCode::kVersionMismatch);
  HelperAnswer bad;
  bad.info.max_force = std::numeric_limits<double>::infinity();
  ASSERT_TRUE(sendAnswer(pair[1], bad).ok());
  EXPECT_EQ(receiveAnswer(pair[0], 0).error().code, ErrorCode::kInternal);
  HelperAnswer odd;
  odd.opened = Error{static_cast<ErrorCode>(0xFFF0), "a", "b", "c"};
  ASSERT_TRUE(sendAnswer(pair[1], odd).ok());
  EXPECT_EQ(toString(receiveAnswer(pair[0], 0).value().opened.error()),
            toString(Error{ErrorCode::kInternal, "a", "b", "c"}));
  std::vector<std::uint8_t> lie(1 << 16);  // A number that is none of ours, and ends like one that is.
  ASSERT_TRUE(sendAnswer(pair[1], odd).ok());
  lie.resize(static_cast<std::size_t>(::recv(pair[0], lie.data(), lie.size(), 0)));
  const std::uint32_t number = 0x10000;
  std::memcpy(lie.data() + 16, &number, sizeof number);  // Behind the head.
  ASSERT_EQ(::send(pair[1], lie.data(), lie.size(), 0), static_cast<ssize_t>(lie.size()));
  EXPECT_EQ(receiveAnswer(pair[0], 0).value().opened.error().code, ErrorCode::kInternal)
      << "no refusal is \"no error\"";
  HelperAnswer good;
  good.info.model = "a\nmodel" + std::string(1000, 'x');
  good.info.max_workspace_upper = Vec3(1, 2, 3);
  good.info.actuated_gripper = true;
  ASSERT_TRUE(sendAnswer(pair[1], good).ok());
  const auto got = receiveAnswer(pair[0], 0);
  ASSERT_TRUE(got.ok());
  EXPECT_EQ(got.value().info.model.substr(0, 9), "a modelxx");
  EXPECT_EQ(got.value().info.max_workspace_upper, Vec3(1, 2, 3));
  EXPECT_TRUE(got.value().info.actuated_gripper);
  ::close(pair[1]);
  EXPECT_EQ(receiveAnswer(pair[0], 0).error().code, ErrorCode::kDeviceGone);
  ::close(pair[0]);
}

}  // namespace
}  // namespace hapticd
