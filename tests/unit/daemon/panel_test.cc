// The panel over lines that a test moves, and real servos behind it, all stepped by hand.
#include "daemon/panel/panel.h"

#include <gtest/gtest.h>

#include <random>

#include "drivers/gpio/safety_contact.h"
#include "tests/support/seeds.h"
#include "tests/support/time.h"

namespace hapticd::test {
namespace {

constexpr std::int64_t kStart = 1'000'000'000;

/** Opens a closed contact at `opens`, closes it after `for_ns`; says for how long it was then seen open from its edge
 * on. */
std::int64_t tripsAfter(std::int64_t debounce_ns, std::int64_t for_ns) {
  SafetyContact contact(debounce_ns, true);
  contact.see(false, kStart);
  for (std::int64_t t = 0; t < 100 * kMs; t += 10'000) {
    if (t == for_ns) contact.see(true, kStart + t);
    contact.pass(kStart + t);
    if (contact.open()) return t;
  }
  return -1;
}

TEST(SafetyContact, OpenForTheDebounceTimeIsOpenAndAShorterGlitchIsNot) {
  EXPECT_EQ(tripsAfter(2 * kMs, 50 * kMs), 2 * kMs);
  EXPECT_EQ(tripsAfter(2 * kMs, 1 * kMs), -1);
  EXPECT_EQ(tripsAfter(0, 10'000), 0) << "without a debounce the first edge counts";
}

TEST(SafetyContact, ALooseWireIsOpen) {
  SafetyContact contact(5 * kMs, true);
  contact.see(false, kStart);
  contact.see(true, kStart + kMs);
  EXPECT_FALSE(contact.open());
  contact.see(false, kStart + 2 * kMs);
  EXPECT_TRUE(contact.open());
}

TEST(SafetyContact, ClosesWhenItHasBeenQuietForAWhile) {
  SafetyContact contact(kMs, false);
  EXPECT_TRUE(contact.open());
  std::int64_t t = kStart;
  for (int i = 0; i < 10; ++i) contact.see(i % 2 == 0, t += 5 * kMs);  // bounces
  contact.see(true, t += 5 * kMs);
  contact.pass(t + SafetyContact::kSettle_ns - 1);
  EXPECT_TRUE(contact.open());
  EXPECT_EQ(contact.due(), t + SafetyContact::kSettle_ns);
  contact.pass(t + SafetyContact::kSettle_ns);
  EXPECT_FALSE(contact.open());
  EXPECT_EQ(contact.due(), SafetyContact::kNever);
}

/** Whatever the wire does, a level that is open for the debounce time or longer is never taken for closed. */
TEST(SafetyContact, AnySequenceOfEdgesErrsTowardOpen) {
  std::mt19937 random(seedOf(11));
  for (int round = 0; round < 300; ++round) {
    const std::int64_t debounce = static_cast<std::int64_t>(random() % 6) * kMs;
    bool level = random() % 2 == 0;
    SafetyContact contact(debounce, level);
    std::int64_t t = kStart;
    std::int64_t since = level ? t : t - debounce;
    for (int step = 0; step < 200; ++step) {
      t += static_cast<std::int64_t>(random() % 4) * kMs / 2;
      if (random() % 5 == 0) {
        level = !level;
        since = t;
        contact.see(level, t);
      } else {
        contact.pass(t);
      }
      if (!level && t - since >= debounce) {
        ASSERT_TRUE(contact.open()) << "open since " << t - since << " ns of " << debounce;
      }
      if (level && t - since >= SafetyContact::kSettle_ns) {
        ASSERT_FALSE(contact.open());
      }
      ASSERT_GT(contact.due(), t) << "it is never due in the past";
    }
  }
}

/** Lines as a test sets them. */
struct Board {
  std::vector<int> level;  ///< 1, 0 or kLost.
  bool broken = false;     ///< wait() fails.
};

class FakeLines final : public Lines {
 public:
  explicit FakeLines(Board& board) : board_(board) {}
  [[nodiscard]] int wait(std::int64_t, LineEdge*, int) noexcept override { return board_.broken ? kLost : 0; }
  [[nodiscard]] int get(std::size_t line) noexcept override { return board_.level[line]; }
  [[nodiscard]] bool set(std::size_t line, bool active) noexcept override {
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
    while (now < end) {
      now = std::min(end, now + std::max<std::int64_t>(panel->patience(now), 1));
      if (sign != nullptr && servo_lives) sign->cycles.fetch_add(1);
      panel->step(now, nullptr, 0);
    }
  }

  std::vector<LineConfig> config;
  Board board{{1, 1, 0, 0, 0, 0}, false};
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

TEST_F(PanelTest, APanelThatNoLongerLooksIsAStop) {
  make();
  pass(Panel::kLook_ns);
  EXPECT_FALSE(safety.stopAt(now + SafetyLines::kDeaf_ns));
  EXPECT_TRUE(safety.stopAt(now + SafetyLines::kDeaf_ns + 1));
}

}  // namespace
}  // namespace hapticd::test
