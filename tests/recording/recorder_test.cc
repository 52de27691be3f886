// The recorder by itself: what it writes when, and how it ends.
#include "daemon/recorder/recorder.h"

#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <sstream>
#include <thread>

#include "daemon/recording/reader.h"
#include "tests/unit/builder/meshes.h"

namespace hapticd::test {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::seconds;

class RecorderTest : public testing::Test {
 protected:
  RecorderTest() {
    auto made = Recorder::create(false);
    EXPECT_TRUE(made.ok());
    recorder = std::move(*made);
    stream = recorder->takeStream();
    header.start.config.device_count = 1;
    header.devices = {{"hand", "test://", "none"}};
  }

  void push(std::uint64_t count) {
    for (; count > 0; --count) {
      ++input->tick;
      input->now_ns += 1'000'000;
      recorder->log().push(*input, *output, 1);
    }
  }

  /** Reads what comes within 50 ms; false at the end of the stream. */
  bool take() {
    pollfd readable{stream.get(), POLLIN, 0};
    if (::poll(&readable, 1, 50) <= 0) return true;
    std::vector<char> room(1 << 20);
    const ssize_t n = ::read(stream.get(), room.data(), room.size());
    if (n > 0) bytes.append(room.data(), static_cast<std::size_t>(n));
    return n > 0;
  }

  /** Ticks in what has come so far, and before which of them there were meshes. */
  struct Contents {
    std::vector<std::uint64_t> ticks;
    std::vector<std::uint64_t> meshes_before;
    std::optional<RecordingEnd> end;
  };
  [[nodiscard]] Contents contents() const {
    Contents out;
    auto reader = RecordingReader::read(std::make_unique<std::istringstream>(bytes));
    if (!reader) return out;
    const auto cycle = std::make_unique<RecordedCycle>();
    for (;;) {
      auto more = reader->next(*cycle);
      if (!more || !*more) break;
      out.ticks.push_back(cycle->input.tick);
      if (!reader->takeMeshes().empty()) out.meshes_before.push_back(cycle->input.tick);
    }
    out.end = reader->end();
    return out;
  }

  [[nodiscard]] static Recorder::Mesh mesh(std::uint64_t after) {
    BuildMonitor monitor;
    auto snapshot = buildSnapshot(upload(torus(12, 8), 0), monitor);
    EXPECT_TRUE(snapshot.ok());
    auto mapping = snapshot->memfd.map(Memfd::Access::kRead);
    EXPECT_TRUE(mapping.ok());
    Recorder::Mesh out;
    out.after = after;
    out.shared = std::move(*mapping);
    return out;
  }

  RecordingHeader header;
  std::unique_ptr<Recorder> recorder;
  UniqueFd stream;
  std::string bytes;
  std::unique_ptr<CycleInput> input = std::make_unique<CycleInput>();
  std::unique_ptr<CycleOutput> output = std::make_unique<CycleOutput>();
};

/** A crash loses what stands in no block: so a block is not waited for until it is full. */
TEST_F(RecorderTest, ACycleIsWrittenThoughNoOtherFollows) {
  recorder->begin(header, {}, {});
  push(3);
  for (const auto end = Clock::now() + seconds(20); contents().ticks.size() < 3 && Clock::now() < end;)
    ASSERT_TRUE(take());
  EXPECT_EQ(contents().ticks, (std::vector<std::uint64_t>{1, 2, 3}));
}

TEST_F(RecorderTest, AMeshStandsBeforeTheFirstCycleThatMayUseIt) {
  std::vector<Recorder::Mesh> first;
  first.push_back(mesh(0));
  push(2);
  recorder->begin(header, std::move(first), {});
  while (contents().ticks.size() < 2) ASSERT_TRUE(take());
  recorder->add(mesh(0));
  push(1);
  recorder->finish("enough");
  while (take()) {
  }
  const Contents all = contents();
  EXPECT_EQ(all.ticks, (std::vector<std::uint64_t>{1, 2, 3}));
  EXPECT_EQ(all.meshes_before, (std::vector<std::uint64_t>{1, 3}));
  ASSERT_TRUE(all.end);
  EXPECT_EQ(all.end->reason, "enough");
}

TEST_F(RecorderTest, AFullLogEndsItAndIsCounted) {
  push(CycleLog::kCycles + 904);
  recorder->begin(header, {}, {});
  while (take()) {
  }
  const Contents all = contents();
  EXPECT_EQ(all.ticks.size(), CycleLog::kCycles);
  ASSERT_TRUE(all.end);
  EXPECT_EQ(all.end->lost, 904u);
  EXPECT_EQ(all.end->reason, "the reader of the recording was too slow");
}

/** Who stops a recording waits for 5 s: a reader that takes a little now and then does not hold up the answer. */
TEST_F(RecorderTest, IsGivenUpInTimeThoughItsReaderTakesALittleEachSecond) {
  std::vector<Recorder::Mesh> large(1);
  large[0].copy.resize(std::size_t{16} << 20);
  recorder->begin(header, std::move(large), {});
  ASSERT_TRUE(take());
  recorder->finish("stopped");
  std::vector<char> some(1 << 16);
  int rounds = 0;  // Of a second: bytes come more often than patience ends.
  for (; rounds < 20 && !recorder->done(); ++rounds) {
    ASSERT_GT(::read(stream.get(), some.data(), some.size()), 0);
    for (int i = 0; i < 20 && !recorder->done(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  ASSERT_TRUE(recorder->done());
  EXPECT_LT(rounds, 15);
  EXPECT_EQ(recorder->end().reason, "the reader of the recording has gone or stands still");
}

/** What stood in the log, and in no block yet, was told as recorded. */
TEST_F(RecorderTest, ItsEndCountsWhatAReaderGotThatHasGone) {
  push(CycleLog::kCycles + 904);
  recorder->begin(header, {}, {});
  for (const auto end = Clock::now() + seconds(20); contents().ticks.empty() && Clock::now() < end;)
    ASSERT_TRUE(take());
  (void)::shutdown(stream.get(), SHUT_RD);  // It still gets what was under way.
  while (take()) {
  }
  for (const auto end = Clock::now() + seconds(20); !recorder->done() && Clock::now() < end;) std::this_thread::yield();
  ASSERT_TRUE(recorder->done());
  EXPECT_EQ(recorder->end().reason, "the reader of the recording has gone or stands still");
  EXPECT_EQ(recorder->end().cycles, contents().ticks.size());
  EXPECT_EQ(recorder->end().cycles + recorder->end().lost, CycleLog::kCycles + 904);
}

/** The daemon that stops does not wait for a reader who has stopped reading. */
TEST_F(RecorderTest, IsGivenUpAtOnceWhenItIsDestroyed) {
  push(CycleLog::kCycles);
  recorder->begin(header, {}, {});
  ASSERT_TRUE(take());
  const auto begin = Clock::now();
  recorder.reset();
  EXPECT_LT(Clock::now() - begin, std::chrono::nanoseconds(Recorder::kPatienceNs / 2));
}

}  // namespace
}  // namespace hapticd::test
