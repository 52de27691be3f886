// The panel's lines over libgpiod, whose calls are played here: what is asked of it, and how its answers are told.
#include <fcntl.h>
#include <gpiod.h>
#include <gtest/gtest.h>
#include <sys/time.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <list>
#include <string>

#include "drivers/gpio/lines.h"
#include "drivers/run_out.h"

namespace hapticd::test {
namespace {

/** A line of the board. */
struct Wire {
  std::string chip, name;
  int refuses = 0;  ///< Error number of who asks for it.
  bool held = false, output = false;
  int flags = 0;
  int level = 0;
  bool broken = false;  ///< Neither read, set nor heard any more.
  int heard = -1;       ///< Where its edges come out,
  int pulled = -1;      ///< and where they go in: '1' rising, '0' falling.
};

/** What the played library has. */
struct Board {
  std::list<Wire> wires;
  int closed = 0;  ///< Error number of who opens a chip.
  int chips = 0;   ///< Open now.
};

Board* board = nullptr;

}  // namespace
}  // namespace hapticd::test

using hapticd::test::board;
using hapticd::test::Wire;

struct gpiod_line {
  gpiod_chip* chip = nullptr;
  Wire* wire = nullptr;
  bool requested = false;
};

struct gpiod_chip {
  std::string name;
  std::list<gpiod_line> lines;
};

extern "C" {

gpiod_chip* gpiod_chip_open_lookup(const char* name) {
  if (board->closed != 0) {
    errno = board->closed;
    return nullptr;
  }
  for (const Wire& wire : board->wires) {
    if (wire.chip != name) continue;
    ++board->chips;
    return new gpiod_chip{name, {}};
  }
  return nullptr;
}

void gpiod_chip_close(gpiod_chip* chip) {
  for (gpiod_line& line : chip->lines) {
    if (line.requested) line.wire->held = false;
  }
  --board->chips;
  delete chip;
}

gpiod_line* gpiod_chip_find_line(gpiod_chip* chip, const char* name) {
  for (Wire& wire : board->wires) {
    if (wire.chip != chip->name || wire.name != name) continue;
    chip->lines.push_back({chip, &wire});
    return &chip->lines.back();
  }
  return nullptr;
}

gpiod_line* gpiod_line_find(const char* name) {
  if (board->closed != 0) {
    errno = board->closed;
    return nullptr;
  }
  for (const Wire& wire : board->wires) {
    if (wire.name == name) return gpiod_chip_find_line(gpiod_chip_open_lookup(wire.chip.c_str()), name);
  }
  return nullptr;
}

gpiod_chip* gpiod_line_get_chip(gpiod_line* line) { return line->chip; }

static int request(gpiod_line* line, const char* consumer, int flags, bool output) {
  EXPECT_STREQ(consumer, "hapticd");
  errno = line->wire->held ? EBUSY : line->wire->refuses;
  if (errno != 0) return -1;
  line->requested = line->wire->held = true;
  line->wire->flags = flags;
  line->wire->output = output;
  return 0;
}

int gpiod_line_request_output_flags(gpiod_line* line, const char* consumer, int flags, int level) {
  if (request(line, consumer, flags, true) != 0) return -1;
  line->wire->level = level;
  return 0;
}

int gpiod_line_request_both_edges_events_flags(gpiod_line* line, const char* consumer, int flags) {
  return request(line, consumer, flags, false);
}

int gpiod_line_get_value(gpiod_line* line) { return line->wire->broken ? -1 : line->wire->level; }

int gpiod_line_set_value(gpiod_line* line, int value) {
  if (line->wire->broken) return -1;
  line->wire->level = value;
  return 0;
}

int gpiod_line_event_get_fd(gpiod_line* line) {
  EXPECT_FALSE(line->wire->output);
  return line->wire->heard;
}

int gpiod_line_event_read_fd(int fd, gpiod_line_event* event) {
  for (const Wire& wire : board->wires) {
    if (wire.heard == fd && wire.broken) return -1;
  }
  char edge = 0;
  if (read(fd, &edge, 1) != 1) return -1;
  event->event_type = edge == '1' ? GPIOD_LINE_EVENT_RISING_EDGE : GPIOD_LINE_EVENT_FALLING_EDGE;
  return 0;
}

}  // extern "C"

namespace hapticd::test {
namespace {

constexpr std::size_t kMost = 16;  // Lines that can be had.

class GpiodLines : public ::testing::Test {
 protected:
  GpiodLines() { board = &board_; }
  ~GpiodLines() override { clear(); }
  void clear() {
    for (const Wire& wire : board_.wires) {
      close(wire.heard);
      if (wire.pulled >= 0) close(wire.pulled);
    }
    board_ = {};
  }
  Wire& wire(const std::string& name, const std::string& chip = "panel") {
    int ends[2] = {-1, -1};
    EXPECT_EQ(pipe2(ends, O_NONBLOCK), 0);
    Wire& made = board_.wires.emplace_back();
    made.chip = chip;
    made.name = name;
    made.heard = ends[0];
    made.pulled = ends[1];
    return made;
  }
  static void pull(const Wire& wire, bool up) { ASSERT_EQ(write(wire.pulled, up ? "1" : "0", 1), 1); }
  static LineRequest input(const std::string& name) { return {"panel", name}; }
  static LineRequest output(const std::string& name) { return {"panel", name, true}; }
  static ErrorCode refusal(const LineRequest& request) {
    const auto opened = openLines({request});
    return opened ? ErrorCode::kOk : opened.error().code;
  }

  Board board_;
};

TEST_F(GpiodLines, EachIsAskedForAsItIsConfiguredAndGivenBack) {
  const std::pair<LineBias, int> biases[] = {{LineBias::kAsIs, 0},
                                             {LineBias::kPullUp, GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_UP},
                                             {LineBias::kPullDown, GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_DOWN},
                                             {LineBias::kNone, GPIOD_LINE_REQUEST_FLAG_BIAS_DISABLE}};
  Wire& is = wire("X");
  for (const auto& [bias, flag] : biases) {
    for (const bool out : {false, true}) {
      for (const bool low : {false, true}) {
        is.level = 1;
        const auto lines = openLines({{"panel", "X", out, low, bias}});
        ASSERT_TRUE(lines);
        EXPECT_TRUE(is.held);
        EXPECT_EQ(is.output, out);
        EXPECT_EQ(is.flags, flag | (low ? int{GPIOD_LINE_REQUEST_FLAG_ACTIVE_LOW} : 0));
        EXPECT_EQ(is.level, out ? 0 : 1) << "outputs begin inactive";
      }
      EXPECT_FALSE(is.held);
      EXPECT_EQ(board_.chips, 0);
    }
  }
}

TEST_F(GpiodLines, WithoutAChipItIsWhicheverHasTheLine) {
  wire("X", "other");
  Wire& is = wire("STOP", "second");
  {
    const auto lines = openLines({{"", "STOP"}});
    ASSERT_TRUE(lines);
    EXPECT_TRUE(is.held);
  }
  EXPECT_FALSE(is.held);
  EXPECT_EQ(board_.chips, 0);
}

/** Of each input by the number of its request, however many outputs stand between; what finds no place comes next. */
TEST_F(GpiodLines, EdgesAreThoseOfTheirLines) {
  wire("ENABLE");
  Wire& stop = wire("STOP");
  wire("LED");
  Wire& deadman = wire("DEADMAN");
  const auto lines = openLines({output("ENABLE"), input("STOP"), output("LED"), input("DEADMAN")});
  ASSERT_TRUE(lines);
  std::array<LineEdge, 4> edges{};
  EXPECT_EQ((*lines)->wait(0, edges.data(), 4), 0);
  EXPECT_EQ((*lines)->wait(5'000'000, edges.data(), 4), 0);
  pull(stop, false);
  pull(deadman, true);
  ASSERT_EQ((*lines)->wait(0, edges.data(), 4), 2);
  EXPECT_EQ(edges[0].line, 1u);
  EXPECT_FALSE(edges[0].active);
  EXPECT_EQ(edges[1].line, 3u);
  EXPECT_TRUE(edges[1].active);
  pull(stop, true);
  pull(deadman, false);
  ASSERT_EQ((*lines)->wait(0, edges.data(), 1), 1);
  EXPECT_EQ(edges[0].line, 1u);
  EXPECT_TRUE(edges[0].active);
  ASSERT_EQ((*lines)->wait(0, edges.data(), 1), 1);
  EXPECT_EQ(edges[0].line, 3u);
  EXPECT_FALSE(edges[0].active);
  EXPECT_EQ((*lines)->wait(0, edges.data(), 4), 0);
  pull(stop, false);
  EXPECT_EQ((*lines)->wait(1'100'000'000, edges.data(), 4), 1) << "at once";
}

/** Which comes as often as it takes to come while it waits. */
TEST_F(GpiodLines, ASignalIsNoLoss) {
  wire("STOP");
  const auto lines = openLines({input("STOP")});
  ASSERT_TRUE(lines);
  struct sigaction handled {
  }, before{};
  handled.sa_handler = [](int) {};
  ASSERT_EQ(sigaction(SIGALRM, &handled, &before), 0);
  const itimerval every{{0, 1000}, {0, 1000}}, never{};
  ASSERT_EQ(setitimer(ITIMER_REAL, &every, nullptr), 0);
  LineEdge edge;
  EXPECT_EQ((*lines)->wait(100'000'000'000, &edge, 1), 0);
  setitimer(ITIMER_REAL, &never, nullptr);
  sigaction(SIGALRM, &before, nullptr);
  EXPECT_EQ((*lines)->wait(-1, &edge, 1), Lines::kLost) << "what cannot be waited for is one";
}

TEST_F(GpiodLines, AreReadAndSetUntilTheyAreLost) {
  Wire& stop = wire("STOP");
  Wire& enable = wire("ENABLE");
  const auto lines = openLines({input("STOP"), output("ENABLE")});
  ASSERT_TRUE(lines);
  for (const int level : {1, 0}) {
    stop.level = level;
    EXPECT_EQ((*lines)->get(0), level);
    EXPECT_TRUE((*lines)->set(1, level == 1));
    EXPECT_EQ(enable.level, level);
  }
  stop.broken = enable.broken = true;
  EXPECT_EQ((*lines)->get(0), Lines::kLost);
  EXPECT_FALSE((*lines)->set(1, true));
}

TEST_F(GpiodLines, AnInputThatIsGoneIsSaidToBeLost) {
  for (const bool unplugged : {true, false}) {
    clear();
    wire("STOP");
    Wire& deadman = wire("DEADMAN");
    const auto lines = openLines({input("STOP"), input("DEADMAN")});
    ASSERT_TRUE(lines);
    LineEdge edge;
    ASSERT_EQ((*lines)->wait(0, &edge, 1), 0);
    if (unplugged) {
      close(deadman.pulled);
      deadman.pulled = -1;
    } else {
      pull(deadman, false);
      deadman.broken = true;
    }
    EXPECT_EQ((*lines)->wait(0, &edge, 1), Lines::kLost) << unplugged;
  }
}

TEST_F(GpiodLines, WhatIsNotThereAndWhatIsRefusedIsSaid) {
  Wire& stop = wire("STOP");
  errno = EACCES;  // Of something before.
  EXPECT_EQ(refusal({"", "HALT"}), ErrorCode::kNotFound);
  errno = EACCES;
  EXPECT_EQ(refusal({"desk", "STOP"}), ErrorCode::kNotFound);
  EXPECT_EQ(refusal({"panel", "HALT"}), ErrorCode::kNotFound);
  const std::pair<int, ErrorCode> refusals[] = {{EBUSY, ErrorCode::kDeviceBusy},
                                                {EACCES, ErrorCode::kPermissionDenied},
                                                {EPERM, ErrorCode::kPermissionDenied},
                                                {EIO, ErrorCode::kSystem}};
  for (const auto& [number, code] : refusals) {
    stop.refuses = number;
    EXPECT_EQ(refusal(input("STOP")), code) << number;
    EXPECT_EQ(refusal(output("STOP")), code) << number;
    EXPECT_EQ(refusal({"", "STOP"}), code) << number;
  }
  EXPECT_EQ(openLines({input("STOP")}).error().where, "line \"STOP\" of panel");
  EXPECT_EQ(openLines({{"", "STOP"}}).error().where, "line \"STOP\"");
  for (const int absent : {ENOENT, ENODEV}) {
    board_.closed = absent;
    EXPECT_EQ(refusal(input("STOP")), ErrorCode::kNotFound) << absent;
    EXPECT_EQ(refusal({"", "STOP"}), ErrorCode::kNotFound) << absent;
  }
  for (const auto& [number, code] : refusals) {
    board_.closed = number;
    EXPECT_EQ(refusal(input("STOP")), code) << number;
  }
  board_.closed = EACCES;
  EXPECT_EQ(refusal({"", "STOP"}), ErrorCode::kPermissionDenied);
  for (const int want : {EMFILE, ENFILE, ENOMEM}) {
    board_.closed = want;
    for (const LineRequest& request : {input("STOP"), LineRequest{"", "STOP"}}) {
      const Error error = openLines({request}).error();
      EXPECT_EQ(error.code, ErrorCode::kSystem) << want << ": not that no chip has it";
      EXPECT_EQ(error.remedy, remedyForWant(want));
    }
  }
  EXPECT_EQ(board_.chips, 0);
}

TEST_F(GpiodLines, LookingTakesNoneAndSaysNothingOfClosedChips) {
  Wire& stop = wire("STOP");
  EXPECT_TRUE(findLines({input("STOP"), {"", "STOP"}}));
  EXPECT_FALSE(stop.held);
  EXPECT_EQ(board_.chips, 0);
  const auto found = findLines({input("STOP"), input("HALT")});
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().code, ErrorCode::kNotFound);
  board_.closed = EACCES;
  EXPECT_TRUE(findLines({input("STOP"), {"", "HALT"}}));
}

TEST_F(GpiodLines, MoreThanThereIsRoomForAreRefused) {
  std::vector<LineRequest> requests;
  for (std::size_t i = 0; i < kMost; ++i) {
    wire("L" + std::to_string(i));
    requests.push_back(input("L" + std::to_string(i)));
  }
  EXPECT_TRUE(findLines(requests));
  EXPECT_TRUE(openLines(requests));
  wire("L");
  requests.push_back(input("L"));
  ASSERT_FALSE(findLines(requests));
  ASSERT_FALSE(openLines(requests));
  EXPECT_EQ(findLines(requests).error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(openLines(requests).error().code, ErrorCode::kInvalidArgument);
}

}  // namespace
}  // namespace hapticd::test
