// The panel over lines that a test moves, and real servos behind it, all stepped by hand.
#include "daemon/panel/panel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <thread>

#include "drivers/gpio/safety_contact.h"
#include "tests/support/eventually.h"
#include "tests/support/time.h"

namespace hapticd::test {
namespace {

constexpr std::int64_t kStart = 1'000'000'000;

/** Lines as a test sets them. */
struct Board {
  std::array<std::atomic<int>, 6> level;   ///< 1, 0 or kLost.
  std::atomic<bool> broken{false};         ///< wait() fails.
  std::atomic<std::size_t> refuses{1000};  ///< The line that can be set no more.
};

class FakeLines final : public Lines {
 public:
  explicit FakeLines(Board& board) : board_(board) {}
  [[nodiscard]] int wait(std::int64_t timeout_ns, LineEdge*, int) noexcept override {
    std::this_thread::sleep_for(std::chrono::nanoseconds(std::min<std::int64_t>(timeout_ns, kMs)));
    return board_.broken ? kLost : 0;
  }
  [[nodiscard]] int get(std::size_t line) noexcept override { return board_.level[line]; }
  [[nodiscard]] bool set(std::size_t line, bool active) noexcept override {
    if (line == board_.refuses) return false;
    board_.level[line] = active ? 1 : 0;
    return true;
  }

 private:
  Board& board_;
};

enum : std::size_t { kStop, kDeadman, kHome, kEnable, kHeartbeat, kLed };

class PanelTest : public testing::Test {
 protected:
  PanelTest() {
    for (const char* role : {"stop", "deadman", "home", "enable", "heartbeat", "led"}) {
      LineConfig line;
      line.role = line.name = role;
      line.debounce_ms = 1;
      config.push_back(line);
    }
  }
  void make() { panel = std::make_unique<Panel>(config, std::make_unique<FakeLines>(board), safety, now); }
  /** An edge arrives now. */
  void edge(std::size_t line, bool active) {
    board.level[line] = active ? 1 : 0;
    const LineEdge e{line, active};
    panel->step(now, &e, 1);
  }
  /** Time passes in steps of the panel's own patience; the servo lives and has its amplifier on. */
  void pass(std::int64_t ns) {
    const std::int64_t end = now + ns;
    while (now < end && !panel->lost()) {
      now = std::min(end, now + std::max<std::int64_t>(panel->patience(now), 1));
      if (sign != nullptr && servo_lives) sign->cycles.fetch_add(1);
      panel->step(now, nullptr, 0);
    }
  }

  std::vector<LineConfig> config;
  /** A servo lives, and its amplifier is on. */
  void enable() {
    sign = safety.take();
    make();
    sign->enabled = true;
    pass(3 * Panel::kLook_ns + kMs);
    ASSERT_EQ(board.level[kEnable], 1);
    ASSERT_EQ(board.level[kLed], 1);
  }
  /** Whatever the outputs were. */
  void expectAllOff() {
    for (const std::size_t line : {kEnable, kHeartbeat, kLed}) EXPECT_EQ(board.level[line], 0) << line;
  }

  Board board{{1, 1, 0, 0, 0, 0}};
  SafetyLines safety;
  SafetyLines::Sign* sign = nullptr;
  bool servo_lives = true;
  std::int64_t now = kStart;
  std::unique_ptr<Panel> panel;
};

TEST_F(PanelTest, StartsWithWhatTheLinesSay) {
  make();
  EXPECT_FALSE(safety.stopAt(now));
  EXPECT_FALSE(safety.deadman_open);
  panel.reset();
  EXPECT_TRUE(safety.stop) << "without a panel nobody says that the stop is closed";
  board.level[kStop] = 0;
  make();
  EXPECT_TRUE(safety.stopAt(now));
}

TEST_F(PanelTest, HasLookedBeforeAnyServoAsks) {
  safety.stop = true;
  safety.deadman_open = true;
  make();
  EXPECT_FALSE(safety.stopAt(now));
  EXPECT_FALSE(safety.deadman_open);
  EXPECT_TRUE(safety.stopAt(now + SafetyLines::kDeaf_ns + 1));
}

TEST_F(PanelTest, ItsEndPutsOutputsOffAndLeavesInputsAlone) {
  for (int looks = 0; looks < 2; ++looks) {  // The heartbeat is on after one of them.
    enable();
    pass(looks * Panel::kLook_ns);
    panel.reset();
    expectAllOff();
    EXPECT_EQ(board.level[kStop], 1);
    EXPECT_EQ(board.level[kDeadman], 1);
    SafetyLines::giveBack(sign);
  }
}

TEST_F(PanelTest, TheStopActsAfterItsDebounceAndNoLater) {
  make();
  edge(kStop, false);
  EXPECT_LE(panel->patience(now), kMs) << "it must not sleep beyond the debounce";
  pass(kMs - 1);
  EXPECT_FALSE(safety.stop);
  pass(1);
  EXPECT_TRUE(safety.stop);
}

TEST_F(PanelTest, AnEdgeThatGotLostIsSeenAtTheNextLook) {
  make();
  board.level[kStop] = 0;  // no edge is told
  pass(Panel::kLook_ns + kMs);
  EXPECT_TRUE(safety.stop);
}

TEST_F(PanelTest, DeadmanAndHomeButtonAreTold) {
  make();
  edge(kHome, true);
  pass(SafetyContact::kSettle_ns);
  EXPECT_EQ(safety.buttons, 1u);
  EXPECT_EQ(safety.button_count, 1u);
  edge(kDeadman, false);
  pass(kMs);
  EXPECT_TRUE(safety.deadman_open);
  EXPECT_FALSE(safety.stop);
}

TEST_F(PanelTest, EachHomeButtonHasItsBit) {
  config[kLed].role = "home";
  make();
  EXPECT_EQ(safety.button_count, 2u);
  for (const std::uint32_t pressed : {0u, 2u, 3u, 1u, 0u}) {
    edge(kHome, (pressed & 1) != 0);
    edge(kLed, (pressed & 2) != 0);
    pass(SafetyContact::kSettle_ns);
    EXPECT_EQ(safety.buttons, pressed);
  }
}

/** Told by their edges alone: at each look the level is as it was. */
TEST_F(PanelTest, ALooseWireIsAStop) {
  config[kStop].debounce_ms = 5;
  make();
  const LineEdge edges[] = {{kStop, false}, {kStop, true}, {kStop, false}, {kStop, true}};
  panel->step(now, edges, 2);
  EXPECT_FALSE(safety.stop);
  panel->step(now += kMs, edges + 2, 2);
  EXPECT_TRUE(safety.stop);
}

TEST_F(PanelTest, WhatALookSeesIsToldAtOnce) {
  config[kStop].debounce_ms = 0;
  make();
  board.level[kStop] = 0;
  panel->step(now, nullptr, 0);
  EXPECT_TRUE(safety.stop);
}

TEST_F(PanelTest, OutputsFollowTheServos) {
  sign = safety.take();
  make();
  pass(3 * Panel::kLook_ns);
  EXPECT_EQ(board.level[kEnable], 0);
  sign->enabled = true;
  pass(2 * Panel::kLook_ns);
  EXPECT_EQ(board.level[kEnable], 1);
  EXPECT_EQ(board.level[kLed], 1);
  const int before = board.level[kHeartbeat];
  pass(Panel::kLook_ns);
  EXPECT_NE(board.level[kHeartbeat], before);
  sign->enabled = false;
  pass(Panel::kLook_ns);
  EXPECT_EQ(board.level[kEnable], 0);
}

TEST_F(PanelTest, AServoThatStandsStillLosesEnableAndHeartbeat) {
  sign = safety.take();
  make();
  sign->enabled = true;
  pass(3 * Panel::kLook_ns);
  ASSERT_EQ(board.level[kEnable], 1);
  servo_lives = false;
  pass(2 * Panel::kLook_ns);
  EXPECT_EQ(board.level[kEnable], 0);
  const int still = board.level[kHeartbeat];
  for (int i = 0; i < 10; ++i) {
    pass(Panel::kLook_ns);
    EXPECT_EQ(board.level[kHeartbeat], still);
  }
}

TEST_F(PanelTest, AServoThatIsBeingStartedOrIsGoneTakesNoOthersAmplifierOff) {
  sign = safety.take();
  make();
  sign->enabled = true;
  pass(3 * Panel::kLook_ns);
  ASSERT_EQ(board.level[kEnable], 1);
  for (int round = 0; round < 2; ++round) {  // The second time it gets the sign of one that has lived.
    SafetyLines::Sign* const other = safety.take();
    ASSERT_NE(other, sign);
    for (int look = 0; look < 5; ++look) {  // Its threads are made, its device is asked for the first time.
      const int before = board.level[kHeartbeat];
      pass(Panel::kLook_ns);
      ASSERT_EQ(board.level[kEnable], 1) << "round " << round << ", look " << look;
      ASSERT_NE(board.level[kHeartbeat], before);
    }
    other->cycles = 20;
    pass(Panel::kLook_ns);
    ASSERT_EQ(board.level[kEnable], 1);
    pass(2 * Panel::kLook_ns);
    ASSERT_EQ(board.level[kEnable], 0) << "one that has begun and stands still does";
    SafetyLines::giveBack(other);
    pass(Panel::kLook_ns);
    ASSERT_EQ(board.level[kEnable], 1);
  }
}

TEST_F(PanelTest, TheStopTakesTheEnableLineWithIt) {
  config[kStop].debounce_ms = 0;
  sign = safety.take();
  make();
  sign->enabled = true;
  pass(3 * Panel::kLook_ns + kMs);
  ASSERT_EQ(board.level[kEnable], 1);
  edge(kStop, false);
  EXPECT_EQ(board.level[kEnable], 0) << "at the edge, not at the next look";
}

TEST_F(PanelTest, ALineThatIsLostIsAStopForGood) {
  make();
  board.level[kStop] = Lines::kLost;
  pass(2 * Panel::kLook_ns);
  EXPECT_TRUE(panel->lost());
  EXPECT_TRUE(safety.stop);
  board.level[kStop] = 1;
  for (int i = 0; i < 10; ++i) panel->step(now += Panel::kLook_ns, nullptr, 0);
  EXPECT_TRUE(safety.stop);
}

TEST_F(PanelTest, WhatLosesALinePutsAllOutputsOff) {
  for (const std::size_t refuses : {kEnable, kHeartbeat, kLed}) {
    safety.stop = false;
    board.refuses = 1000;
    enable();
    board.level[kHeartbeat] = 1;
    board.refuses = refuses;
    board.level[kStop] = refuses == kHeartbeat ? 1 : 0;  // What the other two show changes with the stop.
    pass(50 * Panel::kLook_ns);
    EXPECT_TRUE(panel->lost()) << refuses;
    EXPECT_TRUE(safety.stop);
    for (const std::size_t line : {kEnable, kHeartbeat, kLed}) {
      if (line != refuses) {
        EXPECT_EQ(board.level[line], 0) << refuses << ": " << line;
      }
    }
    panel.reset();
    board.level[kStop] = 1;
    SafetyLines::giveBack(sign);
  }
}

TEST_F(PanelTest, TheDeadmanSwitchTakesTheEnableLineWithIt) {
  config[kDeadman].debounce_ms = 0;
  enable();
  edge(kDeadman, false);
  EXPECT_EQ(board.level[kEnable], 0) << "at the edge, not at the next look";
  EXPECT_FALSE(safety.stop);
  pass(10 * Panel::kLook_ns);
  EXPECT_EQ(board.level[kEnable], 0) << "though the servo's amplifier is on";
}

TEST_F(PanelTest, AnEdgeDoesNotPutOffTheNextLook) {
  enable();
  pass(panel->patience(now));
  now += 3 * kMs;
  edge(kHome, true);
  EXPECT_LE(panel->patience(now), Panel::kLook_ns - 3 * kMs);
}

/** One that comes late asks for no wait, rather than for one that is over. */
TEST_F(PanelTest, IsNeverPatientForLessThanNoTime) {
  make();
  panel->step(now, nullptr, 0);
  EXPECT_EQ(panel->patience(now), Panel::kLook_ns);
  EXPECT_EQ(panel->patience(now + Panel::kLook_ns), 0);
  EXPECT_EQ(panel->patience(now + 100 * Panel::kLook_ns), 0);
}

TEST_F(PanelTest, TheLightBlinksTwiceASecondWhileTheStopIsOpen) {
  make();
  edge(kStop, false);
  pass(Panel::kLook_ns);
  int changes = 0;
  for (int i = 0; i < 200; ++i) {
    const int before = board.level[kLed];
    pass(Panel::kLook_ns);
    changes += board.level[kLed] != before ? 1 : 0;
  }
  EXPECT_EQ(changes, 8) << "in two seconds";
}

TEST_F(PanelTest, MayHaveOutputsAlone) {
  LineConfig enables = config[kEnable], shows = config[kLed];
  config = {enables, shows};
  sign = safety.take();
  make();
  sign->enabled = true;
  pass(3 * Panel::kLook_ns);
  EXPECT_EQ(board.level[0], 1);
  panel.reset();
  EXPECT_EQ(board.level[0], 0);
  safety.stop = false;
  make();
  pass(3 * Panel::kLook_ns);
  ASSERT_EQ(board.level[0], 1);
  board.refuses = 1;
  sign->enabled = false;
  pass(3 * Panel::kLook_ns);
  EXPECT_TRUE(panel->lost());
  EXPECT_EQ(board.level[0], 0);
}

/** Whatever the order of the lines: those that show() has yet to come to stay off as well. */
TEST_F(PanelTest, NoOutputGoesOnAfterOneThatRefuses) {
  for (const std::size_t next : {kEnable, kHeartbeat, kLed}) {
    const std::vector<LineConfig> all = config;
    config = {all[next == kLed ? kEnable : kLed], all[next]};
    for (std::atomic<int>& level : board.level) level = 0;
    safety.stop = false;
    sign = safety.take();
    make();
    board.refuses = 0;
    sign->enabled = true;
    pass(3 * Panel::kLook_ns);
    EXPECT_TRUE(panel->lost()) << next;
    EXPECT_EQ(board.level[1], 0) << next;
    panel.reset();
    SafetyLines::giveBack(sign);
    board.refuses = 1000;
    config = all;
  }
}

/** A stop whose sense is turned round would be closed when its wire is cut. */
TEST(PanelLines, AreTakenAsTheConfigurationSays) {
  std::vector<LineConfig> config;
  for (const char* role : {"stop", "deadman", "home", "enable", "heartbeat", "led"}) {
    for (const bool active_low : {false, true}) {
      for (const char* bias : {"as-is", "pull-up", "pull-down", "none"}) {
        LineConfig line;
        line.role = role;
        line.chip = std::string("chip of ") + role;
        line.name = std::string(role) + bias;
        line.active_low = active_low;
        line.bias = bias;
        config.push_back(line);
      }
    }
  }
  const std::vector<LineRequest> requests = lineRequests(config);
  ASSERT_EQ(requests.size(), config.size());
  for (std::size_t i = 0; i < config.size(); ++i) {
    EXPECT_EQ(requests[i].chip, config[i].chip);
    EXPECT_EQ(requests[i].name, config[i].name);
    EXPECT_EQ(requests[i].active_low, config[i].active_low);
    EXPECT_EQ(requests[i].output, i / 8 >= kEnable) << config[i].role;
    constexpr LineBias kBias[] = {LineBias::kAsIs, LineBias::kPullUp, LineBias::kPullDown, LineBias::kNone};
    EXPECT_EQ(requests[i].bias, kBias[i % 4]) << config[i].bias;
  }
}

/** With the machine's clock; as an ordinary thread, for that priority is none. */
class PanelThread : public PanelTest {
 protected:
  bool start(bool allow_no_rt) {
    now = clock.now();
    make();
    return panel->start(0, allow_no_rt, clock).ok();
  }
  /** Ends the panel; whether it has looked since it was made. */
  bool looked() {
    const std::int64_t first = safety.looked_ns;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    const bool looks = safety.looked_ns != first;
    panel.reset();
    return looks;
  }
  MonotonicClock clock;
};

TEST_F(PanelThread, LooksUntilItsEnd) {
  ASSERT_TRUE(start(true));
  for (const bool open : {true, false}) {
    board.level[kStop] = open ? 0 : 1;
    EXPECT_TRUE(eventually([&] { return safety.stop == open; })) << open;
  }
  panel.reset();
  EXPECT_TRUE(safety.stop);
}

TEST_F(PanelThread, IsAStopWhenItsLinesAreGone) {
  ASSERT_TRUE(start(true));
  const std::int64_t first = safety.looked_ns;
  ASSERT_TRUE(eventually([&] { return safety.looked_ns != first; }));
  EXPECT_FALSE(panel->lost());
  board.broken = true;
  EXPECT_TRUE(eventually([&] { return panel->lost(); }));
  EXPECT_TRUE(safety.stop);
}

TEST_F(PanelThread, WithoutTheRightsItNeedsItDoesNotBegin) {
  EXPECT_FALSE(start(false));
  EXPECT_FALSE(looked());
}

TEST_F(PanelTest, APanelThatNoLongerLooksIsAStop) {
  make();
  pass(Panel::kLook_ns);
  EXPECT_FALSE(safety.stopAt(now + SafetyLines::kDeaf_ns));
  EXPECT_TRUE(safety.stopAt(now + SafetyLines::kDeaf_ns + 1));
}

}  // namespace
}  // namespace hapticd::test
