// Clients that are stopped, killed and gone mad, as real processes on a real daemon, beside one that is honest.
#include <gtest/gtest.h>
#include <sys/mman.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <hapticclient/hapticclient.hpp>
#include <thread>
#include <vector>

#include "tests/hostile/attacker.h"
#include "tests/integration/raw_client.h"
#include "tests/support/eventually.h"
#include "tests/support/process/child_process.h"
#include "tests/support/process/daemon_fixture.h"
#include "tests/support/random.h"

namespace hapticd::test {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

haptic_local_model floorAtZero() {
  haptic_local_model plane{};
  plane.kind = HAPTIC_MODEL_PLANE;
  plane.lease_ns = 10'000'000'000;
  plane.normal[2] = 1;
  plane.material = {1000, 2, 0, 0};
  return plane;
}

double magnitude(const float (&force)[3]) { return std::hypot(force[0], force[1], force[2]); }

/** For a child: what it cannot go on without. */
template <class T>
T need(haptic::Result<T> result) {
  if (!result) _exit(3);
  return std::move(*result);
}

class HostileProcess : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(daemon_.running()) << daemon_.log();
    auto connected = haptic::Client::connect({daemon_.socket(), "honest"});
    ASSERT_TRUE(connected) << connected.error().message();
    client_ = std::move(*connected);
    events_.emplace(need(client_.subscribe(1u << HAPTIC_EVENT_FAULT | 1u << HAPTIC_EVENT_LEASE_LOST)));
    session_ = need(client_.openSession("sim"));
    ASSERT_TRUE(session_.arm());
    ASSERT_TRUE(eventually([&] {
      const auto sample = session_.latest();
      return sample && (sample->flags & HAPTIC_SAMPLE_ARMED) != 0 && (sample->flags & HAPTIC_SAMPLE_RAMPING) == 0;
    }));
    drain();
    history_.clear();  // of before it was armed
    lost_ = 0;
    ASSERT_TRUE(eventually([&] { return !history_.empty(); }));
  }
  void TearDown() override {
    if (HasFailure()) std::fputs(daemon_.log().c_str(), stderr);
  }

  /** Taking in the honest session's history meanwhile. */
  template <class Condition>
  bool eventually(Condition&& condition) {
    return test::eventually([&] {
      drain();
      return condition();
    });
  }
  void drain() {
    std::vector<haptic_sample> room(1024);
    const auto got = session_.drain(room, lost_);
    if (got) history_.insert(history_.end(), got->begin(), got->end());
  }
  haptic::Reply<haptic_status> status() { return need(client_.status()); }
  /** The honest client has kept its lease, no device has faulted, and each period is in the history or counted. */
  void expectUnharmed() {
    drain();
    for (auto event = events_->next(milliseconds(0)); event; event = events_->next(milliseconds(0))) {
      EXPECT_TRUE(std::string(event->device) != "sim") << haptic_event_name(event->kind) << " " << event->text;
    }
    const auto now = status();
    EXPECT_STREQ(now->devices[0]->lease_holder, "honest");
    EXPECT_EQ(now->devices[0]->fault, 0u);
    EXPECT_TRUE(session_.alive());
    // A sample's `missed` is as of the cycle before it: from the one after the first to the last.
    const std::size_t n = history_.size();
    ASSERT_GT(n, 3u);
    EXPECT_EQ(history_[n - 2].tick - history_[0].tick + 1,
              n - 1 + lost_ + (history_[n - 1].missed - history_[1].missed));
    for (const haptic_sample& sample : history_) ASSERT_NE(sample.flags & HAPTIC_SAMPLE_ARMED, 0u) << sample.tick;
  }

  // A busy test machine is no fault.
  DaemonFixture daemon_{{.program = HAPTICD_PROGRAM, .config = "[guard]\narm_ramp_ms = 100\ndevice_stale_ms = 1000\n"}};
  haptic::Client client_{nullptr};
  std::optional<haptic::Events> events_;
  haptic::Session session_{nullptr};
  std::vector<haptic_sample> history_;
  std::uint64_t lost_ = 0;
};

TEST_F(HostileProcess, AStoppedClientsShareFadesStaysGoneAndComesBackWithoutAJump) {
  const auto share = [](const haptic_sample& s) {
    return std::hypot(magnitude(s.by_source[HAPTIC_SOURCE_LOCAL_MODEL]), magnitude(s.by_source[HAPTIC_SOURCE_CLIENT]));
  };
  ChildProcess pusher([&](auto say) {
    auto client = need(haptic::Client::connect({daemon_.socket(), "stopped"}));
    auto session = need(client.openSession("sim"));
    need(session.push(floorAtZero()));
    haptic_client_force sideways{};
    sideways.lease_ns = 10'000'000'000;
    sideways.force[0] = 1;
    need(session.push(sideways));
    say("!");
    for (;;) pause();
  });
  ASSERT_TRUE(pusher.saysSomething());
  ASSERT_TRUE(session_.push(haptic_intent{0, 0, {0, 0, -0.01}, {1, 0, 0, 0}, 0}));
  // The hand (400 N/m) wants 1 cm into 1000 N/m: 2.86 N, and 1 N sideways.
  ASSERT_TRUE(eventually([&] { return share(history_.back()) > 2.9; }));

  history_.clear();
  pusher.signal(SIGSTOP);
  drain();
  ASSERT_TRUE(eventually([&] { return !history_.empty() && share(history_.back()) == 0; })) << "it fades";
  const std::size_t gone = history_.size();
  const std::uint64_t gone_tick = history_.back().tick;
  EXPECT_LT(gone_tick - history_.front().tick, 3000u) << "by its heartbeat (250 ms), not by the model's lease";
  ASSERT_TRUE(eventually([&] { return history_.back().tick > gone_tick + 200; })) << "the servo goes on";
  // What the hand did before the loss is not of interest: from the first sample of the fade to its end.
  std::size_t fade = gone - 1;
  while (fade > 0 && share(history_[fade - 1]) >= share(history_[fade])) --fade;
  EXPECT_GT(share(history_[fade]), 2.5) << "not one rise on the way from there to zero";
  for (std::size_t i = gone; i < history_.size(); ++i) ASSERT_EQ(share(history_[i]), 0.0) << "it stays there";

  const std::size_t stopped = history_.size();
  pusher.signal(SIGCONT);
  ASSERT_TRUE(eventually([&] { return share(history_.back()) > 2.9; })) << "it comes back";
  const std::uint64_t back_tick = history_.back().tick;
  ASSERT_TRUE(eventually([&] { return history_.back().tick > back_tick + 100; }));
  double most = 0;
  for (std::size_t i = stopped; i < history_.size(); ++i) {
    const haptic_sample& before = history_[i - 1];
    const double elapsed_ms = static_cast<double>(history_[i].t_ns - before.t_ns) * 1e-6;
    // The hand stands 1 cm deep, where all of the plane would be 10 N at once; over 50 ms it is 0.2 N per millisecond.
    const double rise = share(history_[i]) - share(before);
    most = std::max(most, rise);
    EXPECT_LE(rise, 0.5 * std::max(1.0, elapsed_ms)) << "at tick " << history_[i].tick;
  }
  RecordProperty("largest_rise_mN", static_cast<int>(most * 1e3));
  expectUnharmed();
}

// What each killed client has come to; it is killed within the next step.
enum Step : unsigned { kStarted, kConnected, kOpened, kPushed, kArmed, kObject, kHalfMesh, kBuilding, kSteps };

/** Goes through all steps, then pushes for ever. */
[[noreturn]] void liveUntilKilled(const std::string& socket, std::atomic<unsigned>& step) {
  auto client = need(haptic::Client::connect({socket, "victim"}));
  step = kConnected;
  auto opened = client.openSession("sim2");
  while (!opened) opened = client.openSession("sim2");  // those killed before it still fade: a quota
  haptic::Session session = std::move(*opened);
  step = kOpened;
  for (int i = 0; i < 20; ++i) (void)session.push(floorAtZero());
  step = kPushed;
  while (!session.arm().ok()) continue;  // the lease of the one before
  step = kArmed;
  haptic_object ball = HAPTIC_OBJECT_INIT;
  ball.name = "theirs";
  ball.shape.kind = HAPTIC_SHAPE_SPHERE;
  ball.shape.size[0] = 0.01;
  auto object = client.scene().create(ball);
  while (!object) object = client.scene().create(ball);
  step = kObject;
  auto upload = need(client.scene().beginUpload(100'000, 100'000));
  for (std::size_t i = 0; i < upload.vertices().size() / 2; ++i) upload.vertices()[i] = static_cast<float>(i % 977);
  step = kHalfMesh;
  for (std::size_t i = 0; i < upload.triangles().size(); ++i) {
    upload.triangles()[i] = static_cast<std::uint32_t>(i * 7919 % 50'000);
  }
  step = kBuilding;
  (void)upload.commit();
  for (;;) (void)session.push(floorAtZero());
}

TEST_F(HostileProcess, KilledAtAnyInstantNothingOfThemStaysAndNobodyElseNotices) {
  ASSERT_TRUE(client_.openDevice("sim://falcon")) << "theirs to arm";
  const auto descriptors = [&] {
    const std::filesystem::directory_iterator all("/proc/" + std::to_string(daemon_.pid()) + "/fd");
    return std::distance(begin(all), end(all));
  };
  const auto locked = status()->locked_bytes;
  const auto baseline = descriptors();
  void* shared = mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(shared, MAP_FAILED);
  auto& step = *new (shared) std::atomic<unsigned>(0);
  Random random(seedOf(2026));
  int alive = 0;
  for (unsigned round = 0; round < 40; ++round) {
    step = kStarted;
    ChildProcess victim([&](auto) { liveUntilKilled(daemon_.socket(), step); });
    ASSERT_TRUE(eventually([&] { return step >= round % kSteps; })) << "round " << round << ", step " << step;
    std::this_thread::sleep_for(std::chrono::microseconds(random.below(3000)));
    alive += victim.kill() ? 1 : 0;
  }
  EXPECT_EQ(alive, 40) << "each was killed, none gave up";
  EXPECT_TRUE(eventually([&] {
    const auto now = status();
    return now->client_count == 1 && now->objects == 0 && now->locked_bytes == locked && descriptors() == baseline;
  })) << status()->client_count
      << " sessions, " << status()->objects << " objects, " << status()->locked_bytes << " bytes (" << locked << "), "
      << descriptors() << " descriptors (" << baseline << ")";
  EXPECT_STREQ(status()->devices[1]->lease_holder, "");
  EXPECT_EQ(status()->devices[1]->armed, 0u);
  expectUnharmed();
  munmap(shared, 4096);
}

TEST_F(HostileProcess, AScribblerIsNamedAndEndedWhileAnHonestClientsPushesAreAllAcknowledged) {
  constexpr int kScribblers = 3;
  std::uint64_t last = 0;
  for (int i = 0; i < kScribblers; ++i) {
    ChildProcess scribbler([&](auto say) {
      Loop loop;
      RawClient raw(loop, daemon_.socket());
      LiveSession live(loop, raw);
      say("!");
      Random random(seedOf(static_cast<std::uint32_t>(i) + 1));
      auto* words = reinterpret_cast<volatile std::uint64_t*>(live.b->get());
      for (;;) words[random.below(sizeof(hd_region_b) / sizeof(std::uint64_t))] = random.bits();
    });
    ASSERT_TRUE(scribbler.saysSomething());
    const std::string named = "(pid " + std::to_string(scribbler.pid()) + ") broke the ring's protocol";
    int pushed = 0;
    ASSERT_TRUE(eventually([&] {
      const auto seq = session_.push(floorAtZero());
      if (seq) last = *seq;
      return ++pushed > 50 && daemon_.log().find(named) != std::string::npos && status()->client_count == 1;
    })) << "the scribbler's session is to end";
    EXPECT_TRUE(scribbler.kill()) << "it scribbles on, into what is its own";
  }
  ASSERT_TRUE(eventually([&] { return session_.acks()->applied_seq >= last; }));
  EXPECT_EQ(session_.acks()->received_seq, last);
  EXPECT_EQ(session_.acks()->rejected, 0u);
  EXPECT_EQ(session_.acks()->violations, 0u);
  expectUnharmed();
}

}  // namespace
}  // namespace hapticd::test
