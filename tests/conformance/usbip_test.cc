// A played Falcon behind USB/IP, with the test as the kernel.
#include "tools/haptic-emu/usbip.h"

#include <gtest/gtest.h>

#include <cerrno>

#include "tests/support/time.h"
#include "tools/haptic-emu/falcon/falcon_user.h"

namespace haptic_emu {
namespace {

using hapticd::kMs;
using Bytes = std::vector<std::uint8_t>;

/** Headers of 48 bytes, words of four, the highest first (Documentation/usb/usbip_protocol.rst). */
Bytes words(std::initializer_list<std::uint32_t> values) {
  Bytes out;
  for (const std::uint32_t value : values) {
    for (int shift = 24; shift >= 0; shift -= 8) out.push_back(static_cast<std::uint8_t>(value >> shift));
  }
  return out;
}
Bytes submit(std::uint32_t sequence, bool in, std::uint32_t endpoint, std::uint32_t length, Bytes setup = Bytes(8),
             const Bytes& data = {}) {
  Bytes out = words({1, sequence, 0x10001, in ? 1u : 0u, endpoint, 0, length, 0, 0, 0});
  out.insert(out.end(), setup.begin(), setup.end());
  out.insert(out.end(), data.begin(), data.end());
  return out;
}

struct Reply {
  std::uint32_t command = 0, sequence = 0;
  std::int32_t status = 0;
  std::uint32_t actual = 0;
  Bytes data;
};

class UsbIpTest : public ::testing::Test {
 protected:
  UsbIpTest() : kernel_(model_) {}
  void give(const Bytes& bytes) { ASSERT_TRUE(kernel_.feed(bytes)); }
  void wait(std::int64_t ns) { kernel_.advance(now_ns_ += ns); }
  /** All replies since the last call; data only where the direction was in. */
  std::vector<Reply> replies(bool with_data = true) {
    const Bytes bytes = kernel_.take();
    std::vector<Reply> out;
    for (std::size_t at = 0; at + 48 <= bytes.size();) {
      const auto word = [&](std::size_t i) {
        return static_cast<std::uint32_t>(bytes[at + 4 * i] << 24 | bytes[at + 4 * i + 1] << 16 |
                                          bytes[at + 4 * i + 2] << 8 | bytes[at + 4 * i + 3]);
      };
      Reply reply{word(0), word(1), static_cast<std::int32_t>(word(5)), word(6), {}};
      at += 48;
      if (reply.command == 3 && with_data && reply.status == 0) {
        const auto begin = bytes.begin() + static_cast<std::ptrdiff_t>(at);
        reply.data.assign(begin, begin + reply.actual);
        at += reply.actual;
      }
      out.push_back(std::move(reply));
    }
    return out;
  }
  Reply one(const Bytes& message, bool with_data = true) {
    give(message);
    const auto all = replies(with_data);
    EXPECT_EQ(all.size(), 1u);
    return all.empty() ? Reply{} : all.front();
  }

  FalconModel model_;
  UsbIp kernel_;
  std::int64_t now_ns_ = 0;
};

TEST_F(UsbIpTest, TellsWhoItIs) {
  const Reply device = one(submit(7, true, 0, 64, {0x80, 6, 0, 1, 0, 0, 64, 0}));
  EXPECT_EQ(device.command, 3u);
  EXPECT_EQ(device.sequence, 7u);
  EXPECT_EQ(device.status, 0);
  ASSERT_EQ(device.data.size(), 18u);
  EXPECT_EQ(device.data[0], 18);
  EXPECT_EQ(device.data[8] | device.data[9] << 8, 0x0403);
  EXPECT_EQ(device.data[10] | device.data[11] << 8, 0xcb48);

  const Reply head = one(submit(8, true, 0, 9, {0x80, 6, 0, 2, 0, 0, 9, 0}));
  ASSERT_EQ(head.data.size(), 9u) << "cut to what was asked for";
  const int total = head.data[2] | head.data[3] << 8;
  const Reply whole = one(submit(9, true, 0, 255, {0x80, 6, 0, 2, 0, 0, 255, 0}));
  ASSERT_EQ(static_cast<int>(whole.data.size()), total);
  int endpoints = 0;
  for (std::size_t at = 0; at < whole.data.size(); at += whole.data[at]) {
    ASSERT_GT(whole.data[at], 0);
    endpoints += whole.data[at + 1] == 5 ? 1 : 0;
  }
  EXPECT_EQ(endpoints, 2);

  const Reply name = one(submit(10, true, 0, 255, {0x80, 6, 2, 3, 9, 4, 255, 0}));
  ASSERT_GT(name.data.size(), 2u);
  EXPECT_EQ(name.data[0], name.data.size());
  EXPECT_EQ(name.data[2], 'F');
  EXPECT_EQ(one(submit(11, true, 0, 255, {0x80, 6, 9, 3, 9, 4, 255, 0}), false).status, -EPIPE);
}

TEST_F(UsbIpTest, RequestsOfTheVendorReachTheDevice) {
  EXPECT_EQ(one(submit(1, false, 0, 0, {0x40, 9, 1, 0, 0, 0, 0, 0})).status, 0) << "latency timer";
  EXPECT_EQ(one(submit(2, false, 0, 0, {0x40, 77, 1, 0, 0, 0, 0, 0})).status, -EPIPE);
  EXPECT_EQ(one(submit(3, true, 5, 64)).status, -EPIPE) << "no such endpoint";
}

TEST_F(UsbIpTest, AnOrderIsAnsweredAtTheTimersTick) {
  model_.warmUp();
  for (const Bytes& setup : {Bytes{0x40, 3, 2, 0, 0, 0, 0, 0}, Bytes{0x40, 9, 1, 0, 0, 0, 0, 0}}) {
    EXPECT_EQ(one(submit(1, false, 0, 0, setup)).status, 0);
  }
  give(submit(2, true, 1, 64));
  wait(2 * kMs);
  EXPECT_EQ(replies().size(), 1u) << "the serial chip's two bytes";
  give(submit(3, true, 1, 64));
  const std::string idle = "<AAAAAAAAAAAAAA>";
  give(submit(4, false, 2, 16, Bytes(8), Bytes(idle.begin(), idle.end())));
  auto sent = replies(false);
  ASSERT_EQ(sent.size(), 1u);
  EXPECT_EQ(sent[0].sequence, 4u);
  EXPECT_EQ(sent[0].actual, 16u);
  EXPECT_EQ(model_.orders(), 1u);
  wait(3 * kMs);
  const auto answer = replies();
  ASSERT_EQ(answer.size(), 1u);
  EXPECT_EQ(answer[0].sequence, 3u);
  ASSERT_EQ(answer[0].data.size(), 18u);
  EXPECT_EQ(answer[0].data[2], '<');
  EXPECT_EQ(answer[0].data[17], '>');
}

TEST_F(UsbIpTest, UnlinkTakesBackWhatWaitsOnce) {
  model_.faults.add({FaultKind::kSilence, 0, INT64_MAX});
  wait(kMs);
  give(submit(5, true, 1, 64));
  (void)replies();
  give(submit(6, true, 1, 64));
  const std::size_t before = kernel_.waiting();
  Bytes unlink = words({2, 100, 0x10001, 0, 0, 6});
  unlink.resize(48);
  give(unlink);
  const auto gone = replies(false);
  ASSERT_EQ(gone.size(), 1u);
  EXPECT_EQ(gone[0].command, 4u);
  EXPECT_EQ(gone[0].sequence, 100u);
  EXPECT_EQ(gone[0].status, -ECONNRESET);
  EXPECT_EQ(kernel_.waiting(), before - 1);
  give(unlink);
  EXPECT_EQ(replies(false).at(0).status, 0) << "it has ended already";
}

TEST_F(UsbIpTest, PiecesOfAnySizeAndNothingElse) {
  const Bytes message = submit(7, true, 0, 64, {0x80, 6, 0, 1, 0, 0, 64, 0});
  for (const std::uint8_t byte : message) give({byte});
  EXPECT_EQ(replies().size(), 1u);
  EXPECT_FALSE(UsbIp(model_).feed(Bytes(48, 0xff)));
  EXPECT_FALSE(UsbIp(model_).feed(submit(1, false, 2, 1u << 30)));
}

TEST_F(UsbIpTest, NothingAnswersFromAnUnpluggedDevice) {
  model_.faults.add({FaultKind::kUnplug, 0, INT64_MAX});
  wait(kMs);
  EXPECT_EQ(one(submit(1, true, 0, 18, {0x80, 6, 0, 1, 0, 0, 18, 0}), false).status, -ESHUTDOWN);
}

TEST(FalconUser, HomesWhenAskedAndThenPresses) {
  FalconModel model;
  model.warmUp();
  model.loseHoming();
  FalconUser user(model, {});
  (void)model.control({0x40, 3, 2, 0});
  const std::string home = "<AAAAAAAAAAAABA>";
  double deepest = 1;
  for (std::int64_t t_ns = 0; t_ns < 6000 * kMs; t_ns += kMs) {
    if (!model.homed()) model.out(Bytes(home.begin(), home.end()));
    user.act(t_ns);
    model.advance(t_ns);
    if (t_ns > 4000 * kMs) deepest = std::min(deepest, model.hand.position().z());
  }
  EXPECT_TRUE(model.homed());
  EXPECT_NEAR(deepest, 0.115, 1e-3);
}

TEST(Faults, AreReadFromText) {
  const auto fault = parseFault("garbage@0.5+0.25");
  ASSERT_TRUE(fault.ok());
  EXPECT_EQ(fault.value().kind, FaultKind::kGarbage);
  EXPECT_EQ(fault.value().from_ns, 500 * kMs);
  EXPECT_EQ(fault.value().to_ns, 750 * kMs);
  EXPECT_EQ(parseFault("unplug@2").value().to_ns, INT64_MAX);
  for (const char* wrong : {"", "noise@1", "silence@", "silence@x", "silence@1+", "silence@-1", "silence@1e99"}) {
    EXPECT_FALSE(parseFault(wrong).ok()) << wrong;
  }
}

}  // namespace
}  // namespace haptic_emu
