// A played HID device before a kernel that is played too: the other end of a pair of sockets speaks as /dev/uhid does.
#include "tools/haptic-emu/uhid.h"

#include <gtest/gtest.h>
#include <linux/input.h>
#include <linux/uhid.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <csignal>
#include <cstring>
#include <memory>

#include "tools/haptic-emu/hidpid/pid_model.h"
#include "tools/haptic-emu/woodyhid/woody_hid_model.h"

namespace haptic_emu {
namespace {

struct Kernel {
  Kernel() {
    EXPECT_EQ(::socketpair(AF_UNIX, SOCK_SEQPACKET, 0, ends), 0);
    const int room = 1 << 20;
    for (const int end : ends) ::setsockopt(end, SOL_SOCKET, SO_SNDBUF, &room, sizeof room);
  }
  ~Kernel() {
    ::close(ends[0]);
    ::close(ends[1]);
  }
  /** Next message of that kind; null if there is none. */
  std::unique_ptr<uhid_event> next(unsigned type) {
    for (pollfd one{ends[0], POLLIN, 0}; ::poll(&one, 1, 0) == 1;) {
      auto event = std::make_unique<uhid_event>();
      std::memset(event.get(), 0, sizeof *event);
      if (::read(ends[0], event.get(), sizeof *event) <= 0) break;
      if (event->type == type) return event;
    }
    return nullptr;
  }
  void send(const uhid_event& event) { ASSERT_GT(::write(ends[0], &event, sizeof event), 0); }
  void send(unsigned type) {
    auto event = blank(type);
    send(*event);
  }
  static std::unique_ptr<uhid_event> blank(unsigned type) {
    auto event = std::make_unique<uhid_event>();
    std::memset(event.get(), 0, sizeof *event);
    event->type = type;
    return event;
  }
  /** What a program writes to the node. */
  void output(const std::vector<std::uint8_t>& report) {
    auto event = blank(UHID_OUTPUT);
    event->u.output.rtype = UHID_OUTPUT_REPORT;
    event->u.output.size = static_cast<std::uint16_t>(report.size());
    std::memcpy(event->u.output.data, report.data(), report.size());
    send(*event);
  }
  int ends[2] = {-1, -1};
};

TEST(Uhid, TellsTheKernelWhatItIs) {
  Kernel kernel;
  WoodyHidModel model(WoodyKind::kWooden2015);
  UhidLink link(kernel.ends[1], model, {"Teensyduino RawHID", "1234560", 0x16c0, 0x0486});
  ASSERT_TRUE(link.pump(0));
  const auto created = kernel.next(UHID_CREATE2);
  ASSERT_NE(created, nullptr);
  const uhid_create2_req& create = created->u.create2;
  EXPECT_STREQ(reinterpret_cast<const char*>(create.name), "Teensyduino RawHID");
  EXPECT_STREQ(reinterpret_cast<const char*>(create.uniq), "1234560");
  EXPECT_EQ(create.bus, BUS_USB);
  EXPECT_EQ(create.vendor, 0x16c0u);
  EXPECT_EQ(create.product, 0x0486u);
  EXPECT_EQ(HidModel::Bytes(create.rd_data, create.rd_data + create.rd_size), model.descriptor());
}

TEST(Uhid, ReportsGoBothWaysOnceSomebodyListens) {
  Kernel kernel;
  WoodyHidModel model(WoodyKind::kWooden2015);
  UhidLink link(kernel.ends[1], model, {"board", "", 0x16c0, 0x0486});
  ASSERT_TRUE(link.pump(0));
  kernel.send(UHID_OPEN);
  // Behind a 0, as hidraw hands it on.
  kernel.output(std::vector<std::uint8_t>(65));
  ASSERT_TRUE(link.pump(1'000'000));
  EXPECT_TRUE(link.opened());
  EXPECT_EQ(model.heard(), 1u);
  ASSERT_TRUE(link.pump(3'000'000));
  ASSERT_TRUE(link.pump(5'000'000));
  const auto input = kernel.next(UHID_INPUT2);
  ASSERT_NE(input, nullptr);
  EXPECT_EQ(input->u.input2.size, 64);
  kernel.send(UHID_CLOSE);
  ASSERT_TRUE(link.pump(6'000'000));
  EXPECT_FALSE(link.opened());
}

TEST(Uhid, FeaturesAreSetAndAsked) {
  Kernel kernel;
  PidModel model;
  model.busy_polls = 0;
  UhidLink link(kernel.ends[1], model, {"stick", "", 0x1209, 0xffb0});
  ASSERT_TRUE(link.pump(0));
  auto set = Kernel::blank(UHID_SET_REPORT);
  set->u.set_report.id = 77;
  set->u.set_report.rnum = 5;
  set->u.set_report.rtype = UHID_FEATURE_REPORT;
  set->u.set_report.size = 4;
  set->u.set_report.data[0] = 5;
  set->u.set_report.data[1] = 1;
  kernel.send(*set);
  ASSERT_TRUE(link.pump(1));
  const auto done = kernel.next(UHID_SET_REPORT_REPLY);
  ASSERT_NE(done, nullptr);
  EXPECT_EQ(done->u.set_report_reply.id, 77u);
  EXPECT_EQ(done->u.set_report_reply.err, 0);
  EXPECT_EQ(model.effects(), 1u);

  for (const std::uint8_t id : {std::uint8_t{6}, std::uint8_t{9}}) {
    auto get = Kernel::blank(UHID_GET_REPORT);
    get->u.get_report.id = 78;
    get->u.get_report.rnum = id;
    get->u.get_report.rtype = UHID_FEATURE_REPORT;
    kernel.send(*get);
    ASSERT_TRUE(link.pump(2));
    const auto got = kernel.next(UHID_GET_REPORT_REPLY);
    ASSERT_NE(got, nullptr);
    EXPECT_EQ(got->u.get_report_reply.id, 78u);
    EXPECT_EQ(got->u.get_report_reply.err != 0, id == 9) << "there is no such report";
    if (id == 6) {
      EXPECT_EQ(got->u.get_report_reply.data[1], 1) << "the block";
    }
  }
}

TEST(Uhid, PlugsOutAndInAsTheModelDoes) {
  Kernel kernel;
  WoodyHidModel model(WoodyKind::kPolhem3);
  UhidLink link(kernel.ends[1], model, {"board", "", 0x16c0, 0x0486});
  model.faults.add({FaultKind::kUnplug, 1000, 2000});
  ASSERT_TRUE(link.pump(0));
  EXPECT_TRUE(link.plugged());
  ASSERT_TRUE(link.pump(1500));
  EXPECT_FALSE(link.plugged());
  EXPECT_NE(kernel.next(UHID_DESTROY), nullptr);
  ASSERT_TRUE(link.pump(2500));
  EXPECT_NE(kernel.next(UHID_CREATE2), nullptr);
  EXPECT_TRUE(link.plugged());
}

TEST(Uhid, AKernelThatIsGoneIsTold) {
  Kernel kernel;
  WoodyHidModel model(WoodyKind::kWooden2015);
  UhidLink link(kernel.ends[1], model, {"board", "", 0x16c0, 0x0486});
  ::shutdown(kernel.ends[0], SHUT_RDWR);
  ::close(kernel.ends[0]);
  kernel.ends[0] = -1;
  std::signal(SIGPIPE, SIG_IGN);
  EXPECT_FALSE(link.pump(0));
}

}  // namespace
}  // namespace haptic_emu
