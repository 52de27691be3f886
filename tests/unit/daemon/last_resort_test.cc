// A daemon that dies of a signal zeroes its devices first. Each death is a child's.
#include "daemon/armed/last_resort.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <functional>
#include <list>

#include "daemon/device/device_group.h"
#include "daemon/scene/scene_model.h"
#include "rt/cycle/realtime.h"
#include "tests/support/process/child_process.h"

namespace hapticd::test {
namespace {

/** Says its name when it is brought to zero. */
class Speaking final : public Device {
 public:
  Speaking(std::string name, std::function<void(const std::string&)> say, int dies_in_close = 0)
      : name_(std::move(name)), say_(std::move(say)), dies_in_close_(dies_in_close) {}
  [[nodiscard]] const DeviceInfo& info() const noexcept override { return info_; }
  [[nodiscard]] Result<void> open() override { return {}; }
  void close() noexcept override {
    if (dies_in_close_ != 0) raise(dies_in_close_);
  }
  void read(std::int64_t, DeviceSample&) noexcept override {}
  void write(std::int64_t, const DeviceCommand&) noexcept override {}
  void safe() noexcept override { say_(name_); }

 private:
  DeviceInfo info_;
  std::string name_;
  std::function<void(const std::string&)> say_;
  int dies_in_close_;
};

/** What a daemon of two devices, a and b, says when it `dies`; a third one was closed before. */
template <class Dies>
std::string lastWords(Dies dies) {
  ChildProcess child([dies](const auto& say) {
    const rlimit none{0, 0};
    setrlimit(RLIMIT_CORE, &none);
    for (int each = 1; each < NSIG; ++each) std::signal(each, SIG_DFL);  // Under nohup, say, some are ignored.
    installLastResort();
    Speaking a("a", say), b("b", say), closed("c", say);
    { const LastResort former(closed); }
    const LastResort holds_a(a), holds_b(b);
    dies();
  });
  return child.all();
}

TEST(LastResort, EveryDeviceIsZeroedOnceAndTheSignalStillKills) {
  // All of signal(7) that end a process, but for those that the daemon ends of in good order, or ignores.
  for (const int signal :
       {SIGHUP,  SIGQUIT,   SIGILL,  SIGTRAP,   SIGABRT, SIGBUS, SIGFPE, SIGUSR1, SIGSEGV,  SIGUSR2,
        SIGALRM, SIGSTKFLT, SIGXCPU, SIGVTALRM, SIGPROF, SIGIO,  SIGPWR, SIGSYS,  SIGRTMIN, SIGRTMAX}) {
    EXPECT_EQ(lastWords([signal] { raise(signal); }), "abkilled by signal " + std::to_string(signal));
  }
}

TEST(LastResort, WhatIsIgnoredStaysSo) {
  EXPECT_EQ(lastWords([] {
              raise(SIGWINCH);
              raise(SIGCHLD);
            }),
            "");
}

/** As SIGHUP under nohup: whoever closes the terminal wants the daemon to go on. */
TEST(LastResort, WhatWasIgnoredBeforeItStaysSo) {
  ChildProcess child([](const auto& say) {
    std::signal(SIGHUP, SIG_IGN);
    installLastResort();
    Speaking a("a", say);
    const LastResort holds_a(a);
    raise(SIGHUP);
    say("lives");
  });
  EXPECT_EQ(child.all(), "lives");
}

TEST(LastResort, ACleanEndCallsNothing) {
  EXPECT_EQ(lastWords([] {}), "");
}

/** From the start of its group until it is closed: then its driver alone speaks with it. */
TEST(LastResort, HoldsWhatAGroupHas) {
  const auto dies = [](bool in_close) {
    return ChildProcess([in_close](const auto& say) {
             const rlimit none{0, 0};
             setrlimit(RLIMIT_CORE, &none);
             installLastResort();
             std::vector<std::unique_ptr<Device>> devices;
             devices.push_back(std::make_unique<Speaking>("a", say, in_close ? SIGTRAP : 0));
             devices.push_back(std::make_unique<Speaking>("b", say));
             GroupOptions options;
             options.threads = false;
             MeshTable meshes;
             MonotonicClock clock;
             const auto group = DeviceGroup::start(options, std::move(devices), meshes, clock);
             if (!in_close) raise(SIGTRAP);
           })
        .all();
  };
  const std::string killed = "killed by signal " + std::to_string(SIGTRAP);
  EXPECT_EQ(dies(false), "ab" + killed);
  EXPECT_EQ(dies(true), "a" + killed);
}

TEST(LastResort, HoldsAsManyAsThereMayBe) {
  constexpr std::size_t kAll = kMaxGroups * HD_MAX_DEVICES;
  ChildProcess child([](const auto& say) {
    const rlimit none{0, 0};
    setrlimit(RLIMIT_CORE, &none);
    installLastResort();
    std::list<Speaking> devices;
    std::list<LastResort> holds;
    for (std::size_t i = 0; i < kAll; ++i) holds.emplace_back(devices.emplace_back("x", say));
    raise(SIGTRAP);
  });
  EXPECT_EQ(child.all(), std::string(kAll, 'x') + "killed by signal " + std::to_string(SIGTRAP));
}

TEST(LastResort, AServoThatNeverWaitsIsEndedWithItsDevicesAtZero) {
  const bool may = ChildProcess([](const auto&) { _exit(becomeRealtime(1) ? 0 : 1); }).all().empty();
  if (!may) GTEST_SKIP() << "no right to real-time scheduling";
  const std::string words = lastWords([] {
    const rlimit limit{20'000, 1'000'000};  // microseconds
    if (setrlimit(RLIMIT_RTTIME, &limit) != 0 || !becomeRealtime(1)) _exit(2);
    volatile int turns = 0;
    for (;;) turns = turns + 1;
  });
  EXPECT_EQ(words, "abkilled by signal " + std::to_string(SIGXCPU));
}

}  // namespace
}  // namespace hapticd::test
