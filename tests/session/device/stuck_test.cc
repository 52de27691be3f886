// Drivers that do not come back: whoever closes them hears so, and nobody else's device waits.
#include <atomic>
#include <fstream>

#include "daemon/builder/build.h"
#include "daemon/device/device_closer.h"
#include "tests/session/bench.h"
#include "tests/session/still_device.h"
#include "tests/support/process/no_descriptors.h"
#include "tests/support/process/temporary_directory.h"
#include "tests/unit/builder/meshes.h"

namespace hapticd::test {
namespace {

template <class T>
ErrorCode codeOf(const Result<T>& result) {
  return result ? ErrorCode::kOk : result.error().code;
}

/** Where a device's driver stays while `shut`, and what was asked of it. Outlives the devices. */
struct Door {
  std::atomic<bool> shut{false};
  std::atomic<int> inside{0}, safe{0}, closed{0};

  void pass() noexcept {
    inside.fetch_add(1);
    shut.wait(true);
    inside.fetch_sub(1);
  }
  void open() noexcept {
    shut.store(false);
    shut.notify_all();
  }
  ~Door() { open(); }
};

class StuckDevice final : public StillDevice {
 public:
  StuckDevice(std::string uri, Door& reading, Door& closing, Door* opening = nullptr)
      : StillDevice("stuck", std::move(uri)), reading_(reading), closing_(closing), opening_(opening) {}
  Result<void> open() override {
    if (opening_ != nullptr) opening_->pass();
    return {};
  }
  void giveUp() noexcept override {}
  void read(std::int64_t now_ns, DeviceSample& sample) HD_RT override {
    reading_.pass();
    StillDevice::read(now_ns, sample);
  }
  void close() noexcept override {
    closing_.pass();
    closing_.closed.fetch_add(1);
  }
  void safe() noexcept override { closing_.safe.fetch_add(1); }

 private:
  Door& reading_;
  Door& closing_;
  Door* opening_;
};

struct Stuck : testing::Test {
  Stuck() {
    bench.core.devices().setFactory([this](std::string_view uri) -> Result<std::unique_ptr<Device>> {
      return std::unique_ptr<Device>(std::make_unique<StuckDevice>(std::string(uri), reading, closing));
    });
  }
  Door reading, closing;
  Bench bench;  // first to go
};

TEST_F(Stuck, ADriverThatDoesNotCloseHoldsUpNobody) {
  ASSERT_TRUE(bench.core.openDevice("test://stuck", bench.administration).ok());
  bench.step(3);
  closing.shut.store(true);
  const auto closed = bench.core.closeDevice("test://stuck", bench.administration);
  ASSERT_FALSE(closed.ok());
  EXPECT_EQ(closed.error().code, ErrorCode::kTimeout);
  EXPECT_EQ(closed.error().where, "test://stuck");
  EXPECT_EQ(closing.safe, 1);
  EXPECT_EQ(closing.inside, 1);
  // It is gone from the list, and the device that is left serves on.
  EXPECT_EQ(bench.core.devices().devices().size(), 1u);
  const Session* session = bench.live();
  ASSERT_NE(session, nullptr);
  EXPECT_TRUE(bench.arm(session->id).ok());
  // Nobody has it before its driver has come back, whichever way it is asked for.
  EXPECT_EQ(codeOf(bench.core.openDevice("test://stuck", bench.administration)), ErrorCode::kDeviceBusy);
  EXPECT_EQ(codeOf(bench.core.devices().openGroup({"again", {"test://stuck"}, 1000})), ErrorCode::kDeviceBusy);
  int refused = 0;
  bench.core.openDevice("test://stuck", bench.administration, [&](const Result<OpenDevice*>& device) {
    refused += !device && device.error().code == ErrorCode::kDeviceBusy ? 1 : 0;
  });
  EXPECT_EQ(refused, 1);
  closing.open();
  while (bench.core.devices().isClosing("test://stuck")) bench.step();
  EXPECT_EQ(closing.closed, 1);
  EXPECT_TRUE(bench.core.openDevice("test://stuck", bench.administration).ok());
}

/** As where memory may not be locked any more: its servo is stopped and the device closed again. */
TEST_F(Stuck, NorOneWhoseServoCouldNotBeGivenTheMeshes) {
  BuildMonitor monitor;
  const auto built = buildSnapshot(upload(torus(12, 8), HD_MESH_DEFORMABLE), monitor);
  ASSERT_TRUE(built.ok());
  ASSERT_TRUE(bench.core.meshes().add(std::move(*built->memfd.share()), {}).ok());
  closing.shut.store(true);
  {
    const NoDescriptors none;
    EXPECT_EQ(codeOf(bench.core.openDevice("test://stuck", bench.administration)), ErrorCode::kSystem);
  }
  EXPECT_TRUE(bench.core.devices().isClosing("test://stuck"));
  EXPECT_EQ(closing.inside, 1);
  closing.open();
  while (bench.core.devices().isClosing("test://stuck")) bench.step();
  EXPECT_TRUE(bench.core.openDevice("test://stuck", bench.administration).ok());
}

/** Should the daemon die meanwhile, hapticd-safe is to bring it to zero: only its driver knows whether it is. */
TEST_F(Stuck, WhatWasArmedStaysListedUntilItsDriverHasClosedIt) {
  const TemporaryDirectory folder;
  const std::string path = folder.path() + "/armed";
  auto list = ArmedList::open(path);
  ASSERT_TRUE(list.ok());
  bench.core.keepArmed(std::move(*list));
  const auto listed = [&] {
    std::ifstream file(path);
    return armedIn(std::string(std::istreambuf_iterator<char>(file), {}));
  };
  auto session = bench.core.openSession("test://stuck", bench.administration, "tester", HD_SHM_MAJOR, HD_SHM_MINOR);
  ASSERT_TRUE(session.ok());
  bench.client = std::make_unique<ClientSide>(**session);
  ASSERT_TRUE(bench.core.sessions().mapped((*session)->id).ok());
  bench.step(4);
  ASSERT_TRUE(bench.arm((*session)->id).ok());
  bench.core.sessions().end((*session)->id, "test");
  bench.step(20);
  closing.shut.store(true);
  EXPECT_EQ(codeOf(bench.core.closeDevice("test://stuck", bench.administration)), ErrorCode::kTimeout);
  bench.core.setAsleep(true);  // There is none to be stopped.
  bench.core.setAsleep(false);
  bench.step(300);
  EXPECT_EQ(listed(), std::vector<std::string>{"test://stuck"});
  closing.open();
  while (bench.core.devices().isClosing("test://stuck")) bench.step();
  bench.step();
  EXPECT_EQ(listed(), std::vector<std::string>());
}

TEST_F(Stuck, TheEndNamesItAndDoesNotWait) {
  ASSERT_TRUE(bench.core.openDevice("test://stuck", bench.administration).ok());
  closing.shut.store(true);
  EXPECT_EQ(bench.core.closeAll(), std::vector<std::string>{"test://stuck"});
  EXPECT_TRUE(bench.core.devices().links().empty());
  closing.open();  // Else ~Core would wait for it.
}

/** A device that stays in open() until its door opens, whoever gives it up. */
struct StuckOpening : testing::Test {
  StuckOpening() {
    bench.core.devices().setFactory([this](std::string_view uri) -> Result<std::unique_ptr<Device>> {
      Door* const door = uri == "test://stuck" ? &opening : nullptr;
      return std::unique_ptr<Device>(std::make_unique<StuckDevice>(std::string(uri), never, closing, door));
    });
    opening.shut.store(true);
  }
  void begin(const std::vector<std::string>& uris) {
    bench.core.devices().openGroup({"slow", uris, 1000}, [this](const Result<void>&) { ++answers; });
    while (opening.inside == 0) bench.step();
  }
  Door opening, never, closing;
  int answers = 0;
  Bench bench;  // first to go
};

TEST_F(StuckOpening, TheEndNamesItAndDoesNotWait) {
  begin({"test://stuck"});
  EXPECT_EQ(bench.core.closeAll(), std::vector<std::string>{"test://stuck"});
  EXPECT_TRUE(bench.core.devices().links().empty()) << "the other device is closed";
  EXPECT_EQ(opening.inside, 1);
  EXPECT_EQ(closing.safe, 0) << "nothing is called beside open()";
  opening.open();  // Else ~Core would wait for it.
}

TEST_F(StuckOpening, WhatWasOpenedBeforeItIsClosedEvenIfItDoesNotClose) {
  begin({"test://before", "test://stuck"});
  closing.shut.store(true);
  EXPECT_EQ(bench.core.closeAll(), (std::vector<std::string>{"test://stuck", "test://before"}));
  EXPECT_EQ(closing.inside, 1);
  EXPECT_EQ(closing.safe, 1);
  EXPECT_EQ(answers, 0);
  closing.open();
  opening.open();
}

/** Devices that were named on the command line must open, but a daemon that is told to end ends. */
TEST(StuckStart, IsGivenUpWhenTheDaemonIsToldToEnd) {
  Door opening, never, closing;
  opening.shut.store(true);
  MonotonicClock clock;
  CoreOptions options;
  options.config = Bench::relaxed();
  options.config.groups = {{"default", {"test://stuck"}, 1000}};
  options.epoch = 42;
  options.threads = false;
  options.devices_required = true;
  Core core(options, clock);
  core.devices().setFactory([&](std::string_view uri) -> Result<std::unique_ptr<Device>> {
    return std::unique_ptr<Device>(std::make_unique<StuckDevice>(std::string(uri), never, closing, &opening));
  });
  EXPECT_TRUE(core.openConfigured([&] { return opening.inside == 0; }).ok());
  EXPECT_EQ(core.closeAll(), std::vector<std::string>{"test://stuck"});
  opening.open();
}

/** With threads: two groups, of which one servo can be kept inside its driver. */
struct StuckServo : testing::Test {
  StuckServo() : core(options(), clock) {
    core.devices().setFactory([this](std::string_view uri) -> Result<std::unique_ptr<Device>> {
      Door& door = uri == "test://stuck" ? reading : never;
      return std::unique_ptr<Device>(std::make_unique<StuckDevice>(std::string(uri), door, closing));
    });
    for (const char* uri : {"test://stuck", "test://other"}) {
      const auto opened = core.devices().openGroup({uri + 7, {uri}, 1000});
      EXPECT_TRUE(opened.ok()) << toString(opened.error());
    }
    administration = *core.connect(101, 0, true);
  }
  static CoreOptions options() {
    CoreOptions o;
    o.config = Bench::relaxed();
    o.config.servo.lock_memory = false;
    o.epoch = 42;
    return o;
  }
  [[nodiscard]] const GroupLink& link(std::size_t i) { return *core.devices().links()[i]; }
  /** Polls until that servo has gone on. */
  void awaitCycles(std::size_t i) {
    for (const std::uint64_t from = link(i).cycles(); link(i).cycles() < from + 3;) core.poll();
  }
  void shut() {
    awaitCycles(0);
    reading.shut.store(true);
    while (reading.inside == 0) core.poll();
    // Inside for good, not on its way out.
    for (std::uint64_t seen = link(0).cycles() + 1; seen != link(0).cycles();) {
      seen = link(0).cycles();
      awaitCycles(1);
    }
  }
  Door reading, never, closing;
  MonotonicClock clock;
  Core core;
  std::uint64_t administration = 0;
};

TEST_F(StuckServo, ClosingItIsRefusedAndTheOthersGoOn) {
  shut();
  for (int i = 0; i < 2; ++i) {
    const auto closed = core.closeDevice("test://stuck", administration);
    ASSERT_FALSE(closed.ok());
    EXPECT_EQ(closed.error().code, ErrorCode::kTimeout);
    EXPECT_EQ(closed.error().where, "test://stuck");
    EXPECT_EQ(closing.safe, 1) << "told to come to zero once; the second answer comes at once";
  }
  EXPECT_EQ(core.devices().devices().size(), 2u) << "its servo may still write: nothing of it is given away";
  EXPECT_EQ(closing.closed, 0) << "close() is never called beside read()";
  awaitCycles(1);
  // Comes it back, it serves on, and closes as any other.
  reading.open();
  awaitCycles(0);
  EXPECT_TRUE(core.closeDevice("test://stuck", administration).ok());
  EXPECT_EQ(core.devices().devices().size(), 1u);
  EXPECT_EQ(closing.closed, 1);
  awaitCycles(0);  // The other's, which is the first now.
}

TEST_F(StuckServo, TheEndNamesItAndClosesTheOthers) {
  shut();
  EXPECT_EQ(core.closeAll(), std::vector<std::string>{"test://stuck"});
  EXPECT_EQ(closing.closed, 1);
  reading.open();  // Else ~Core would wait for it.
}

}  // namespace
}  // namespace hapticd::test
