// The file: cut off anywhere it opens up to its last whole block, and damage is found and named.
#include <capnp/message.h>
#include <gtest/gtest.h>

#include <cstring>

#include "daemon/recording/block.h"
#include "proto/recording.capnp.h"
#include "tests/recording/taken.h"

namespace hapticd::test {
namespace {

/** Blocks of a recording and where each ends. */
struct File {
  std::string bytes;
  std::vector<std::size_t> ends;
  std::vector<std::uint64_t> cycles;  ///< Up to each block.
};

/** A header, a mesh in two parts of which nothing more is asked than to be there, twelve cycles, the end. */
File smallFile(bool with_end = true) {
  File file;
  std::uint64_t cycles = 0;
  RecordingWriter writer([&](std::span<const std::byte> bytes) {
    file.bytes.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    file.ends.push_back(file.bytes.size());
    file.cycles.push_back(cycles);
    return true;
  });
  RecordingHeader header;
  header.program = "test";
  header.devices = {{"sim", "sim://default", "a simulation"}};
  header.start.tick = 7;
  const Command order = makeCommand(CommandKind::kAddSession, SessionRef{3, 0, 99});
  header.start.orders = {order};
  (void)writer.header(header);
  (void)writer.mesh(4, std::vector<std::byte>(300, std::byte{5}));
  RecordedCycle cycle;
  for (int i = 0; i < 12; ++i) {
    cycle.input.tick = 8 + static_cast<std::uint64_t>(i);
    cycle.input.now_ns = i * kMs;
    cycle.input.command_count = i % 3 == 0 ? 1 : 0;
    cycle.input.command[0] = order;
    cycle.sent[0].force.x() = 0.1 * i;
    (void)writer.cycle(cycle);
    if (i % 4 != 3) continue;
    cycles = static_cast<std::uint64_t>(i) + 1;
    (void)writer.flush();
  }
  if (with_end) (void)writer.end("stopped", 0);
  return file;
}

struct Outcome {
  bool opened = false;
  std::uint64_t cycles = 0;
  bool ended = false;
  std::string error;
};

Outcome readAll(const std::string& bytes) {
  Outcome out;
  auto reader = readerOf(bytes);
  if (!reader) {
    out.error = toString(reader.error());
    return out;
  }
  out.opened = true;
  RecordedCycle cycle;
  while (true) {
    auto more = reader->next(cycle);
    if (!more) out.error = toString(more.error());
    if (!more || !*more) break;
    ++out.cycles;
  }
  out.ended = reader->end().has_value();
  return out;
}

TEST(RecordingFile, CutOffAtAnyByteItOpensUpToTheLastWholeBlock) {
  const File file = smallFile();
  ASSERT_EQ(file.ends.size(), 6u);
  for (std::size_t size = 0; size < file.bytes.size(); ++size) {
    SCOPED_TRACE(size);
    const Outcome outcome = readAll(file.bytes.substr(0, size));
    ASSERT_EQ(outcome.opened, size >= file.ends[0]);
    if (!outcome.opened) {
      ASSERT_NE(outcome.error.find("block 0 at byte 0"), std::string::npos) << outcome.error;
      continue;
    }
    ASSERT_EQ(outcome.error, "");
    ASSERT_FALSE(outcome.ended);
    std::uint64_t whole = 0;
    for (std::size_t b = 0; b < file.ends.size(); ++b) whole = file.ends[b] <= size ? file.cycles[b] : whole;
    ASSERT_EQ(outcome.cycles, whole);
  }
  const Outcome whole = readAll(file.bytes);
  EXPECT_TRUE(whole.ended);
  EXPECT_EQ(whole.cycles, 12u);
}

TEST(RecordingFile, ZerosWhereTheLastWriteDidNotArriveAreACutOffEnd) {
  const File file = smallFile();
  const Outcome outcome = readAll(file.bytes.substr(0, file.ends[3]) + std::string(5000, '\0'));
  EXPECT_EQ(outcome.error, "");
  EXPECT_EQ(outcome.cycles, file.cycles[3]);
}

/** A header, a mesh in one part, a cycle, the end. */
File fileWithMesh(std::size_t mesh_bytes) {
  File file;
  RecordingWriter writer([&](std::span<const std::byte> bytes) {
    file.bytes.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    file.ends.push_back(file.bytes.size());
    return true;
  });
  RecordingHeader header;
  header.devices = {{"sim", "sim://default", "a simulation"}};
  (void)writer.header(header);
  (void)writer.mesh(4, std::vector<std::byte>(mesh_bytes, std::byte{5}));
  RecordedCycle cycle;
  cycle.input.tick = 1;
  (void)writer.cycle(cycle);
  (void)writer.end("stopped", 0);
  return file;
}

std::string zeroFrom(const std::string& bytes, std::size_t from, std::size_t size) {
  return bytes.substr(0, from) + std::string(size - from, '\0');
}

TEST(RecordingFile, ZerosFromAPageWithinABlockToTheFilesEndAreACutOffEnd) {
  const File file = fileWithMesh(20'000);
  const std::size_t end = file.ends[1], all = file.bytes.size();
  int pages = 0;
  for (std::size_t page = (file.ends[0] + 4095) / 4096 * 4096; page < end; page += 4096, ++pages) {
    SCOPED_TRACE(page);
    for (const std::size_t size : {end, end + 16, all, all + 9000}) {
      const Outcome outcome = readAll(zeroFrom(file.bytes, page, size));
      EXPECT_TRUE(outcome.opened);
      EXPECT_EQ(outcome.error, "");
      EXPECT_FALSE(outcome.ended);
    }
    std::string hole = file.bytes;  // What comes after it did arrive.
    hole.replace(page, 64, 64, '\0');
    EXPECT_NE(readAll(hole).error.find("block 1 at byte"), std::string::npos);
  }
  EXPECT_GE(pages, 4);
  // Zeros from where no page begins are no end.
  const std::string error = readAll(zeroFrom(file.bytes, end / 4096 * 4096 + 8, end)).error;
  EXPECT_NE(error.find("block 1 at byte"), std::string::npos) << error;
}

TEST(RecordingFile, AHeadAcrossAPageThatDidNotArriveIsACutOffEnd) {
  const std::size_t without = fileWithMesh(8).ends[1] - 8;
  for (const std::size_t there : {8u, 16u, 24u}) {
    SCOPED_TRACE(there);
    const File file = fileWithMesh(8192 - without - there);
    ASSERT_EQ(file.ends[1], 8192 - there);
    const Outcome outcome = readAll(zeroFrom(file.bytes, 8192, file.bytes.size()));
    EXPECT_TRUE(outcome.opened);
    EXPECT_EQ(outcome.error, "");
    EXPECT_EQ(outcome.cycles, 0u);
  }
}

TEST(RecordingFile, AnyChangedByteIsFoundAndItsBlockNamed) {
  const File file = smallFile();
  for (std::size_t at = 0; at < file.bytes.size(); ++at) {
    SCOPED_TRACE(at);
    std::string changed = file.bytes;
    changed[at] = static_cast<char>(changed[at] ^ 0x10);
    const Outcome outcome = readAll(changed);
    std::size_t block = 0, start = 0;
    while (file.ends[block] <= at) start = file.ends[block++];
    const std::string name = "block " + std::to_string(block) + " at byte " + std::to_string(start);
    ASSERT_NE(outcome.error.find(name), std::string::npos) << outcome.error;
  }
}

TEST(RecordingFile, ForeignBytesAndOtherVersionsAreRefusedWithTheirRemedy) {
  EXPECT_NE(readAll("tick,now\n1,2\n and more than a head has room for").error.find("hapticctl record"),
            std::string::npos);
  EXPECT_NE(readAll("").error.find("block 0 at byte 0"), std::string::npos);
  struct Version {
    int major, orders, layout;
    const char* name;
  };
  constexpr int kMajor = proto::RECORDING_MAJOR, kOrders = proto::ORDERS_VERSION;
  for (const Version& v :
       {Version{kMajor + 1, kOrders, HD_SHM_MAJOR, "major"}, Version{kMajor, kOrders - 1, HD_SHM_MAJOR, "orders"},
        Version{kMajor, kOrders + 1, HD_SHM_MAJOR, "orders"},
        Version{kMajor, kOrders, HD_SHM_MAJOR + 1, "layoutMajor"}}) {
    capnp::MallocMessageBuilder message;
    auto header = message.initRoot<proto::Block>().initHeader();
    header.setMajor(static_cast<std::uint16_t>(v.major));
    header.setOrders(static_cast<std::uint16_t>(v.orders));
    header.setLayoutMajor(static_cast<std::uint16_t>(v.layout));
    const auto block = encodeBlock(0, message);
    const std::string error = readAll({reinterpret_cast<const char*>(block.data()), block.size()}).error;
    EXPECT_NE(error.find(v.name), std::string::npos) << error;
    EXPECT_NE(error.find("version of hapticd"), std::string::npos) << error;
  }
}

TEST(RecordingFile, BlocksInAnotherOrderAreRefused) {
  const File file = smallFile();
  const auto block = [&](std::size_t b) {
    const std::size_t start = b == 0 ? 0 : file.ends[b - 1];
    return file.bytes.substr(start, file.ends[b] - start);
  };
  EXPECT_NE(readAll(block(0) + block(2)).error.find("number 2"), std::string::npos);
  EXPECT_NE(readAll(block(1)).error.find("number 1"), std::string::npos);
  EXPECT_NE(readAll(file.bytes + block(5)).error.find("block 6 at byte"), std::string::npos);
}

TEST(RecordingFile, NumbersThatAreNoneComeBackAsTheyWere) {
  RecordedCycle cycle;
  cycle.input.tick = 1;
  cycle.input.device[0].p = {std::nan("0x7"), -0.0, std::numeric_limits<double>::denorm_min()};
  cycle.input.device[0].gravity = {0, -1.25, std::nan("0x9")};
  cycle.sent[0].torque.y() = -std::numeric_limits<double>::infinity();
  std::string bytes;
  RecordingWriter writer([&](std::span<const std::byte> b) {
    bytes.append(reinterpret_cast<const char*>(b.data()), b.size());
    return true;
  });
  RecordingHeader header;
  header.devices = {{}};
  ASSERT_TRUE(writer.header(header) && writer.cycle(cycle) && writer.end("stopped", 0));
  auto reader = readerOf(bytes);
  ASSERT_TRUE(reader.ok());
  RecordedCycle back;
  const auto more = reader->next(back);
  ASSERT_TRUE(more.ok() && *more);
  EXPECT_EQ(std::memcmp(&back.input.device[0].p, &cycle.input.device[0].p, sizeof(Vec3)), 0);
  EXPECT_EQ(std::memcmp(&back.input.device[0].gravity, &cycle.input.device[0].gravity, sizeof(Vec3)), 0);
  EXPECT_EQ(back.sent[0].torque.y(), cycle.sent[0].torque.y());
}

TEST(RecordingFile, AGuardIsAsItWas) {
  std::string bytes;
  RecordingWriter writer([&](std::span<const std::byte> block) {
    bytes.append(reinterpret_cast<const char*>(block.data()), block.size());
    return true;
  });
  RecordingHeader header;
  header.devices = {{"sim", "sim://default", "a simulation"}};
  GuardConfig& was = header.start.config.guard[0];
  was.limits = {1, 0.2, 3, 4, 5, 6, 7, 8};
  was.ramp_ns = 9;
  was.small_force = 10;
  was.small_torque = 11;
  was.small_force_ticks = 12;
  was.stale_ns = 13;
  was.missed_limit = 14;
  was.life_ns = 15;
  was.passivity = false;
  was.delay = 16;
  was.max_damping = 17;
  was.continuous_force = 18;
  was.peak_force = 19;
  was.heating_s = 20;
  was.heat = 21;
  was.energy_limit = 22;
  ASSERT_TRUE(writer.header(header) && writer.end("stopped", 0));
  const auto reader = readerOf(bytes);
  ASSERT_TRUE(reader.ok()) << toString(reader.error());
  const GuardConfig& is = reader->header().start.config.guard[0];
  const auto numbers = [](const GuardConfig& g) {
    const GuardLimits& l = g.limits;
    return std::vector<double>{l.force,
                               l.torque,
                               l.force_slew,
                               l.torque_slew,
                               l.gripper_force,
                               l.velocity,
                               l.power,
                               l.active_power,
                               static_cast<double>(g.ramp_ns),
                               g.small_force,
                               g.small_torque,
                               1.0 * g.small_force_ticks,
                               static_cast<double>(g.stale_ns),
                               1.0 * g.missed_limit,
                               static_cast<double>(g.life_ns),
                               g.passivity ? 1.0 : 0.0,
                               g.delay,
                               g.max_damping,
                               g.continuous_force,
                               g.peak_force,
                               g.heating_s,
                               g.heat,
                               g.energy_limit};
  };
  EXPECT_EQ(numbers(is), numbers(was));
}

}  // namespace
}  // namespace hapticd::test
