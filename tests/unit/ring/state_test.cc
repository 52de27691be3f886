#include "rt/ring/state.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "tests/support/seeds.h"
#include "tests/support/stepped/regions.h"

namespace hapticd {
namespace {

using test::Regions;

hd_sample sampleOf(std::uint64_t n, std::uint32_t device = 0) {
  hd_sample sample{};
  sample.tick = n;
  sample.device = device;
  sample.p[0] = static_cast<double>(n) * 0.5;
  sample.applied_commands = static_cast<std::uint32_t>(n);
  return sample;
}

TEST(Header, OfFreshRegionsMatches) {
  const Regions r({.epoch = 11, .session = 22, .device_count = 2, .period_ns = 250'000});
  EXPECT_TRUE(headerMatches(r.a->header, 'A', sizeof(hd_region_a)));
  EXPECT_TRUE(headerMatches(r.b->header, 'B', sizeof(hd_region_b)));
  EXPECT_TRUE(headerMatches(r.a->header, 'A', (sizeof(hd_region_a) + 4095) / 4096 * 4096));
  EXPECT_EQ(r.a->header.daemon_epoch, 11u);
  EXPECT_EQ(r.b->header.session_id, 22u);
  EXPECT_EQ(r.a->header.device_count, 2u);
  EXPECT_EQ(r.b->header.period_ns, 250'000);
}

TEST(Header, SaysWhatIsWrong) {
  const Regions r;
  const auto check = [](const hd_shm_header& h) { return checkHeader(h, 'A', sizeof(hd_region_a)); };
  const auto with = [&](auto change) {
    hd_shm_header h = r.a->header;
    change(h);
    return check(h);
  };
  EXPECT_EQ(check(r.a->header), ErrorCode::kOk);
  EXPECT_EQ(with([](auto& h) { ++h.major; }), ErrorCode::kVersionMismatch);
  EXPECT_EQ(with([](auto& h) { --h.minor; }), ErrorCode::kVersionMismatch);
  EXPECT_EQ(with([](auto& h) { h.minor = 9; }), ErrorCode::kOk) << "a newer minor only adds";
  EXPECT_EQ(with([](auto& h) { h.ready = 0; }), ErrorCode::kInvalidArgument);
  EXPECT_EQ(with([](auto& h) { h.magic ^= 1; }), ErrorCode::kInvalidArgument);
  EXPECT_EQ(with([](auto& h) { h.region = 'B'; }), ErrorCode::kInvalidArgument);
  EXPECT_EQ(with([](auto& h) { h.region_bytes += 8; }), ErrorCode::kInvalidArgument);
  EXPECT_EQ(with([](auto& h) { h.region_bytes -= 8; }), ErrorCode::kInvalidArgument);
  EXPECT_EQ(with([](auto& h) { h.header_bytes += 8; }), ErrorCode::kInvalidArgument);
  EXPECT_EQ(with([](auto& h) { ++h.mailboxes; }), ErrorCode::kInvalidArgument);
  EXPECT_EQ(with([](auto& h) { h.device_count = 0; }), ErrorCode::kInvalidArgument);
  EXPECT_EQ(with([](auto& h) { h.device_count = HD_MAX_DEVICES; }), ErrorCode::kOk);
  EXPECT_EQ(with([](auto& h) { h.slot_bytes = 256; }), ErrorCode::kInvalidArgument);
  EXPECT_EQ(with([](auto& h) { h.ring_slots = 512; }), ErrorCode::kInvalidArgument);
  EXPECT_EQ(with([](auto& h) { h.sample_bytes += 8; }), ErrorCode::kInvalidArgument);
  EXPECT_EQ(with([](auto& h) { h.history_slots /= 2; }), ErrorCode::kInvalidArgument);
  EXPECT_EQ(with([](auto& h) { h.device_count = 5; }), ErrorCode::kInvalidArgument);
  EXPECT_EQ(with([](auto& h) { h.period_ns = 0; }), ErrorCode::kInvalidArgument);
  EXPECT_EQ(checkHeader(r.a->header, 'A', sizeof(hd_region_a) - 1), ErrorCode::kInvalidArgument);
}

class State : public testing::Test {
 protected:
  Regions r;
  StateWriter writer{r.a.get()};
  StateReader reader{r.a.get()};
  std::uint64_t lost = 0;
};

TEST_F(State, LatestIsPerDevice) {
  hd_sample out{};
  EXPECT_FALSE(reader.latest(0, out)) << "none stands yet";
  EXPECT_FALSE(reader.latest(HD_MAX_DEVICES, out));
  writer.publish(sampleOf(1, 0));
  writer.publish(sampleOf(2, 3));
  ASSERT_TRUE(reader.latest(0, out));
  EXPECT_EQ(out.tick, 1u);
  ASSERT_TRUE(reader.latest(3, out));
  EXPECT_EQ(out.tick, 2u);
  EXPECT_EQ(out.p[0], 1.0);
  EXPECT_FALSE(reader.latest(1, out));
}

// A servo that lost its CPU in the middle of writing does not leave its clients without a sample.
TEST_F(State, WhileTheLatestIsHalfWrittenTheOneBeforeIsSeen) {
  hd_sample out{};
  for (std::uint64_t tick = 1; tick <= 2000; tick += 7) {
    for (std::uint32_t d = 0; d < HD_MAX_DEVICES; ++d) writer.publish(sampleOf(tick, d));
    for (std::uint32_t d = 0; d < HD_MAX_DEVICES; ++d) {
      const hd_sample whole = r.a->latest[d];
      r.a->latest[d].guard += 1;
      r.a->latest[d].tick = 9999;
      ASSERT_TRUE(reader.latest(d, out));
      EXPECT_EQ(out.tick, tick);
      EXPECT_EQ(out.device, d);
      r.a->latest[d] = whole;
    }
  }
}

TEST_F(State, AFirstSampleHalfWrittenIsNotSeen) {
  hd_sample out{};
  r.a->latest[0].guard = 1;
  EXPECT_FALSE(reader.latest(0, out));
  writer.publish(sampleOf(1, 1));
  EXPECT_FALSE(reader.latest(0, out)) << "another device's is not its own";
  EXPECT_TRUE(reader.latest(1, out));
}

TEST_F(State, HistoryDeliversEverySampleInOrder) {
  std::vector<hd_sample> out(300);
  EXPECT_EQ(reader.drain(out, lost), 0u);
  for (std::uint64_t n = 0; n < 1000; ++n) writer.publish(sampleOf(n));
  std::uint64_t expected = 0;
  for (const std::uint32_t want : {300u, 300u, 300u, 100u, 0u}) {
    ASSERT_EQ(reader.drain(out, lost), want);
    for (std::uint32_t i = 0; i < want; ++i) ASSERT_EQ(out[i].tick, expected++);
  }
  EXPECT_EQ(lost, 0u);
}

TEST_F(State, ReaderStartsWithTheNextSample) {
  for (std::uint64_t n = 0; n < 5000; ++n) writer.publish(sampleOf(n));
  StateReader reader(r.a.get());
  writer.publish(sampleOf(5000));
  std::vector<hd_sample> out(8);
  ASSERT_EQ(reader.drain(out, lost), 1u);
  EXPECT_EQ(out[0].tick, 5000u);
  EXPECT_EQ(lost, 0u);
}

TEST_F(State, HistoryCountsLossesExactly) {
  std::mt19937 random(seedOf(7));
  std::vector<hd_sample> out(HD_HISTORY_SLOTS * 2);
  std::uint64_t written = 0;
  std::uint64_t got = 0;
  for (int round = 0; round < 60; ++round) {
    const std::uint32_t burst = random() % (3 * HD_HISTORY_SLOTS);
    for (std::uint32_t i = 0; i < burst; ++i) writer.publish(sampleOf(written++));
    const std::uint32_t want = random() % out.size();
    const std::uint32_t n = reader.drain(std::span(out).first(want), lost);
    for (std::uint32_t i = 0; i < n; ++i) ASSERT_EQ(out[i].tick, got + lost + i) << "each is where the counts say";
    got += n;
  }
  got += reader.drain(out, lost);
  EXPECT_EQ(got + lost, written);
  EXPECT_GT(lost, 0u);
}

// The writer has begun to overwrite the oldest slot: that sample is lost, the others are not.
TEST_F(State, SampleBeingOverwrittenIsCountedLost) {
  for (std::uint64_t n = 0; n < HD_HISTORY_SLOTS; ++n) writer.publish(sampleOf(n));
  r.a->history[0].guard = 2 * HD_HISTORY_SLOTS + 1;
  std::vector<hd_sample> out(HD_HISTORY_SLOTS);
  ASSERT_EQ(reader.drain(out, lost), HD_HISTORY_SLOTS - 1);
  EXPECT_EQ(lost, 1u);
  EXPECT_EQ(out[0].tick, 1u);
}

}  // namespace
}  // namespace hapticd
