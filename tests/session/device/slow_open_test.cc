// A device that takes its time to open: the control thread goes on, and everybody gets an answer.
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <condition_variable>
#include <mutex>
#include <optional>
#include <string>

#include "daemon/builder/build.h"
#include "daemon/device/device_opener.h"
#include "tests/session/bench.h"
#include "tests/session/still_device.h"
#include "tests/support/shape/texture_upload.h"
#include "tests/unit/builder/meshes.h"

namespace hapticd::test {
namespace {

/** Opens when the test lets it. */
struct Gate {
  std::mutex mutex;
  std::condition_variable changed;
  bool opened = false, entered = false, given_up = false;
  int closed = 0;

  void open() {
    const std::lock_guard lock(mutex);
    opened = true;
    changed.notify_all();
  }
  void awaitEntered() {
    std::unique_lock lock(mutex);
    changed.wait(lock, [&] { return entered; });
  }
};

class SlowDevice final : public StillDevice {
 public:
  SlowDevice(Gate& gate, std::string uri, bool refuses)
      : StillDevice("slow", std::move(uri)), gate_(gate), refuses_(refuses) {}
  Result<void> open() override {
    std::unique_lock lock(gate_.mutex);
    gate_.entered = true;
    gate_.changed.notify_all();
    gate_.changed.wait(lock, [&] { return gate_.opened || gate_.given_up; });
    if (refuses_ || gate_.given_up) return silence();
    return {};
  }
  void giveUp() noexcept override {
    const std::lock_guard lock(gate_.mutex);
    gate_.given_up = true;
    gate_.changed.notify_all();
  }
  void close() noexcept override { ++gate_.closed; }

 private:
  Gate& gate_;
  bool refuses_;
};

struct SlowBench {
  explicit SlowBench(bool refuses = false, const Config& config = Bench::relaxed()) : bench(config) {
    bench.core.devices().setFactory([this, refuses](std::string_view) -> Result<std::unique_ptr<Device>> {
      return std::unique_ptr<Device>(std::make_unique<SlowDevice>(gate, "slow://1", refuses));
    });
  }
  /** Polls, which is all that moves an opening on, until its answer is there. */
  template <class Condition>
  void until(Condition condition) {
    while (!condition()) bench.step(1);
  }
  Gate gate;  // before the bench: its devices go first
  Bench bench;
};

/** Whether one that opens has `busy` things made for its servo aside before it is there. */
template <class Busy>
bool isWaitedFor(SlowBench& slow, Busy&& busy) {
  slow.gate.open();
  int answers = 0;
  bool waited = false;
  slow.bench.core.openDevice("slow://1", slow.bench.connection, [&](const Result<OpenDevice*>& device) {
    EXPECT_TRUE(device.ok()) << toString(device.error());
    ++answers;
  });
  slow.until([&] {
    waited = waited || busy();
    return answers == 1;
  });
  return waited;
}

/** Each by another text, which is kept and looked through from then on. */
TEST(SlowOpen, ManyWaitForItAndNotAnyNumber) {
  SlowBench slow;
  std::size_t opened = 0, refused = 0;
  constexpr std::size_t kTooMany = 3;
  for (std::size_t i = 0; i <= DeviceManager::kMostWaiting + kTooMany; ++i) {
    slow.bench.core.openDevice("slow://1?text=" + std::to_string(i), slow.bench.connection,
                               [&](const Result<OpenDevice*>& device) {
                                 opened += device ? 1 : 0;
                                 refused += !device && device.error().code == ErrorCode::kQuotaExceeded ? 1 : 0;
                               });
  }
  EXPECT_EQ(refused, kTooMany);
  slow.gate.open();
  slow.until([&] { return opened + refused == DeviceManager::kMostWaiting + kTooMany + 1; });
  EXPECT_EQ(refused, kTooMany);
}

/** What is made aside may be there before anybody looks: seldom ten times in a row. */
template <class Try>
bool isSeen(Try&& waits) {
  for (int i = 0; i < 10; ++i) {
    if (waits()) return true;
  }
  return false;
}

TEST(SlowOpen, WaitsForVibrationsAtTheRateOfItsServo) {
  for (const double rate_hz : {1000.0, 2000.0}) {  // The bench's own servo has 1000 Hz.
    Config config = Bench::relaxed();
    config.servo.rate_hz = rate_hz;
    const auto waits = [&] {
      SlowBench slow(false, config);
      auto& textures = slow.bench.core.scene().textures();
      EXPECT_TRUE(textures.add(*parseTexture(vibrationUpload()), {}).ok());
      return isWaitedFor(slow, [&] { return textures.busy(); });
    };
    EXPECT_EQ(isSeen(waits), rate_hz != 1000);
  }
}

TEST(SlowOpen, WaitsForTheCopyOfALargeMeshThatItsServoNeeds) {
  BuildMonitor monitor;
  const auto built = buildSnapshot(upload(torus(240, 120), HD_MESH_DEFORMABLE), monitor);
  ASSERT_TRUE(built.ok());
  const auto waits = [&] {
    SlowBench slow;
    EXPECT_TRUE(slow.bench.core.meshes().add(std::move(*built->memfd.share()), {}).ok());
    return isWaitedFor(slow, [&] { return slow.bench.core.meshes().busy(); });
  };
  EXPECT_TRUE(isSeen(waits)) << "control made it itself";
}

/** Each is copied, and goes, in no time, but not all of them. */
TEST(SlowOpen, SoDoManySmallMeshes) {
  BuildMonitor monitor;
  const auto built = buildSnapshot(upload(torus(60, 40), HD_MESH_DEFORMABLE), monitor);
  ASSERT_TRUE(built.ok());
  std::vector<std::uint64_t> ids;
  const auto fill = [&](MeshStore& meshes) {
    ids.clear();
    for (std::uint64_t bytes = 0; bytes < 3 * kLargeBytes; bytes += meshes.find(ids.back())->bytes) {
      ids.push_back(*meshes.add(std::move(*built->memfd.share()), {}));
      ASSERT_LT(meshes.find(ids.back())->bytes, kLargeBytes);
    }
  };
  const auto waits = [&] {
    SlowBench slow;
    fill(slow.bench.core.meshes());
    return isWaitedFor(slow, [&] { return slow.bench.core.meshes().busy(); });
  };
  EXPECT_TRUE(isSeen(waits)) << "control made them itself";
  Bench bench;
  MeshStore& meshes = bench.core.meshes();
  fill(meshes);
  ASSERT_TRUE(bench.core.openDevice("test://other").ok());
  while (meshes.busy()) bench.step();
  ASSERT_TRUE(bench.core.closeDevice("test://other", bench.administration).ok());
  EXPECT_TRUE(meshes.busy()) << "the copies of its servo go aside";
  while (meshes.busy()) bench.step();
  for (const std::uint64_t id : ids) ASSERT_TRUE(meshes.drop(id, Client{.administration = true}).ok());
  bool seen = false;
  for (int i = 0; i < 100 && !seen; ++i) {
    bench.step();
    seen = meshes.busy();
  }
  EXPECT_TRUE(seen) << "and so do they";
}

/** Its threads find no processor: the group ends after all was made ready for it. */
TEST(SlowOpen, WhatWasMadeForAServoThatDoesNotStartGoes) {
  BuildMonitor monitor;
  const auto built = buildSnapshot(upload(torus(240, 120), HD_MESH_DEFORMABLE), monitor);
  ASSERT_TRUE(built.ok());
  Gate gate;
  gate.open();
  MonotonicClock clock;
  CoreOptions options;
  options.config = Bench::relaxed();
  options.config.servo.lock_memory = false;
  options.epoch = 42;
  Core core(options, clock);
  core.devices().setFactory([&](std::string_view uri) -> Result<std::unique_ptr<Device>> {
    return std::unique_ptr<Device>(std::make_unique<SlowDevice>(gate, std::string(uri), false));
  });
  ASSERT_TRUE(core.meshes().add(std::move(*built->memfd.share()), {}).ok());
  std::optional<Result<void>> answer;
  core.devices().openGroup({"nowhere", {"slow://1"}, 1000, {1'000'000}},
                           [&](const Result<void>& opened) { answer = opened; }, {});
  bool made = false;
  while (!answer) {
    core.poll();
    made = made || core.meshes().busy();
  }
  ASSERT_FALSE(answer->ok());
  EXPECT_EQ(answer->error().where, "cpus");
  EXPECT_TRUE(made);
  while (core.meshes().busy()) core.poll();
  EXPECT_FALSE(core.meshes().readyForServo()) << "its copy has gone";
}

/** Of a user who may have no more threads; in a child, which gives that right up. */
TEST(SlowOpen, WithoutAThreadForItTheAnswerIsAnError) {
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    const rlimit none{1, 1};
    if (::geteuid() == 0 && ::setresuid(65534, 65534, 65534) != 0) ::_exit(2);
    if (::setrlimit(RLIMIT_NPROC, &none) != 0) ::_exit(3);
    Gate gate;
    gate.open();
    DeviceOpener opener;
    int refused = 0;
    opener.start(std::make_unique<SlowDevice>(gate, "slow://1", false), [&](DeviceOpener::Opened device) {
      refused += !device && device.error().code == ErrorCode::kSystem ? 1 : 0;
    });
    opener.poll();
    opener.start(std::make_unique<SlowDevice>(gate, "slow://2", false), [](const DeviceOpener::Opened&) {});
    EXPECT_TRUE(opener.stop(0).stuck.empty());
    ::_exit(refused == 1 && opener.size() == 0 && gate.closed == 0 ? 0 : 4);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
}

TEST(SlowOpen, OthersAreServedMeanwhile) {
  SlowBench slow;
  Core& core = slow.bench.core;
  OpenDevice* opened = nullptr;
  core.openDevice("slow://1", slow.bench.administration, [&](const Result<OpenDevice*>& device) {
    ASSERT_TRUE(device.ok());
    opened = *device;
  });
  slow.gate.awaitEntered();
  slow.bench.step(20);
  EXPECT_EQ(opened, nullptr);
  EXPECT_TRUE(core.busy()) << "the answer must not wait for the next idle look";
  // A client of the device that is open does all it wants.
  const Session* session = slow.bench.live();
  ASSERT_NE(session, nullptr);
  EXPECT_TRUE(slow.bench.arm(session->id).ok());
  EXPECT_TRUE(core.stop("", slow.bench.connection).ok());
  EXPECT_EQ(core.devices().find("slow://1").error().code, ErrorCode::kNotFound);
  slow.gate.open();
  slow.until([&] { return opened != nullptr; });
  EXPECT_EQ(opened->info().uri, "slow://1");
  EXPECT_EQ(core.devices().devices().size(), 2u);
  EXPECT_FALSE(core.devices().opening());
}

TEST(SlowOpen, WhoAsksMeanwhileWaitsForTheSame) {
  SlowBench slow;
  Core& core = slow.bench.core;
  std::vector<OpenDevice*> answers;
  std::vector<Session*> sessions;
  core.openDevice("slow://1", slow.bench.connection,
                  [&](const Result<OpenDevice*>& device) { answers.push_back(*device); });
  core.openDevice("slow://again", slow.bench.connection,
                  [&](const Result<OpenDevice*>& device) { answers.push_back(*device); });
  core.openSession("slow://1", slow.bench.connection, "tester", HD_SHM_MAJOR, HD_SHM_MINOR,
                   [&](const Result<Session*>& session) { sessions.push_back(*session); });
  EXPECT_EQ(core.devices().opening(), 1u);
  slow.gate.open();
  slow.until([&] { return !sessions.empty(); });
  ASSERT_EQ(answers.size(), 2u);
  EXPECT_EQ(answers[0], answers[1]);
  EXPECT_EQ(sessions[0]->device, answers[0]);
  EXPECT_EQ(*core.devices().find("slow://again"), answers[0]);
  bool at_once = false;
  core.openDevice("slow://1", slow.bench.connection, [&](const Result<OpenDevice*>&) { at_once = true; });
  EXPECT_TRUE(at_once) << "it is open";
}

TEST(SlowOpen, ARefusalReachesAllWhoWaitAndTheNextTriesAgain) {
  SlowBench slow(true);
  Core& core = slow.bench.core;
  int refusals = 0;
  const auto refused = [&](const Result<OpenDevice*>& device) {
    EXPECT_EQ(device.error().code, ErrorCode::kDeviceGone);
    ++refusals;
  };
  core.openDevice("slow://1", slow.bench.connection, refused);
  core.openDevice("slow://1", slow.bench.connection, refused);
  slow.gate.open();
  slow.until([&] { return refusals == 2; });
  core.openDevice("slow://1", slow.bench.connection, refused);
  EXPECT_EQ(core.devices().opening(), 1u);
  slow.until([&] { return refusals == 3; });
  EXPECT_EQ(core.devices().devices().size(), 1u);
}

TEST(SlowOpen, AClientThatHasLeftGetsNoSession) {
  SlowBench slow;
  Core& core = slow.bench.core;
  const auto guest = core.connect(1, 1000, false);
  ASSERT_TRUE(guest.ok());
  bool answered = false;
  core.openSession("slow://1", *guest, "guest", HD_SHM_MAJOR, HD_SHM_MINOR, [&](const Result<Session*>& session) {
    EXPECT_FALSE(session.ok());
    answered = true;
  });
  core.disconnect(*guest);
  slow.gate.open();
  slow.until([&] { return answered; });
  EXPECT_EQ(core.devices().devices().back()->sessions, 0u);
}

TEST(SlowOpen, ADaemonThatEndsDoesNotWaitForIt) {
  SlowBench slow;
  bool answered = false;
  slow.bench.core.openDevice("slow://1", slow.bench.connection, [&](const Result<OpenDevice*>&) { answered = true; });
  slow.gate.awaitEntered();
  slow.bench.core.devices().closeAll();
  EXPECT_TRUE(slow.gate.given_up);
  EXPECT_FALSE(answered);
  EXPECT_EQ(slow.bench.core.devices().opening(), 0u);
}

}  // namespace
}  // namespace hapticd::test
