// Recordings that went bad or were made by somebody who means it: blocks of any message behind heads that fit. What the
// reader accepts, the cycle runs.
#include <fuzzer/FuzzedDataProvider.h>

#include <cstring>
#include <sstream>

#include "daemon/recording/block.h"
#include "daemon/recording/replayer.h"
#include "daemon/recording/writer.h"
#include "rt/scene/snapshot_checksum.h"
#include "tests/support/stepped/solid.h"

namespace {

using namespace hapticd;  // NOLINT(google-build-using-namespace)

/** A good recording, of which the fuzzer changes words. */
std::string good() {
  std::string bytes;
  RecordingWriter writer([&](std::span<const std::byte> block) {
    bytes.append(reinterpret_cast<const char*>(block.data()), block.size());
    return true;
  });
  RecordingHeader header;
  header.devices = {{"a", "b", "c"}};
  const AddObject ball = test::solid(makeObjectId(1, 1), ShapeKind::kSphere, {500, 1, 0.5, 0.3}, {}, {0.02, 0, 0});
  SetSurface shown{ball.object, 0, {}};
  shown.surface.relief = 1;
  shown.surface.vibration = 2;
  shown.surface.relief_depth = 0.001;
  shown.surface.relief_size[0] = shown.surface.relief_size[1] = 0.05;
  hd_local_model plane{};
  plane.kind = HD_MODEL_PLANE;
  plane.lease_ns = 1'000'000'000;
  plane.normal[2] = 1;
  const Command model = makeCommand(CommandKind::kLocalModel, plane, 0);
  header.start.orders = {makeCommand(CommandKind::kAddSession, SessionRef{}),
                         makeCommand(CommandKind::kAddObject, ball), model,
                         makeCommand(CommandKind::kSetSurface, shown)};
  (void)writer.header(header);
  RecordedTexture grooves, cloth;
  grooves.width = grooves.height = 2;
  grooves.pixels = {0, 65535, 0, 65535};
  cloth.models = {{0.1, 0.5, 1, {}}, {0.2, 0.5, 1, {}}, {0.1, 1, 1, {}}};
  cloth.triangles = {{0, 1, 2}};
  (void)writer.texture(0, grooves.view());
  (void)writer.texture(1, cloth.view());
  RecordedCycle cycle;
  for (std::uint64_t tick = 1; tick < 6; ++tick) {
    cycle.input.tick = tick;
    cycle.input.now_ns = static_cast<std::int64_t>(tick) * 1'000'000;
    cycle.input.device[0].fresh = true;
    cycle.input.command_count = 1;
    cycle.input.command[0] = model;
    (void)writer.cycle(cycle);
  }
  (void)writer.end("stopped", 0);
  return bytes;
}

/** Makes the heads fit what is behind them, as far as they are heads. */
void mend(std::string& bytes) {
  std::uint64_t number = 0;
  for (std::size_t at = 0; at + sizeof(BlockHead) <= bytes.size(); ++number) {
    BlockHead head;
    std::memcpy(&head, bytes.data() + at, sizeof head);
    const std::size_t left = bytes.size() - at - sizeof head;
    if (head.bytes > left) return;
    head.magic = kBlockMagic;
    head.number = number;
    head.checksum = snapshotChecksum(std::as_bytes(std::span(bytes.data() + at + sizeof head, head.bytes)));
    head.check = headCheck(head);
    std::memcpy(bytes.data() + at, &head, sizeof head);
    at += sizeof head + head.bytes;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string kGood = good();
  FuzzedDataProvider provider(data, size);
  std::string bytes = provider.ConsumeBool() ? kGood : provider.ConsumeRandomLengthString(4096);
  for (auto n = provider.ConsumeIntegralInRange<int>(0, 12); n > 0 && bytes.size() >= 8; --n) {
    const auto at = provider.ConsumeIntegralInRange<std::size_t>(0, bytes.size() / 8 - 1) * 8;
    const std::uint64_t word = provider.ConsumeBool() ? provider.ConsumeIntegralInRange<std::uint64_t>(0, 300)
                                                      : provider.ConsumeIntegral<std::uint64_t>();
    std::memcpy(bytes.data() + at, &word, sizeof word);
  }
  if (provider.ConsumeBool()) mend(bytes);
  auto reader = RecordingReader::read(std::make_unique<std::istringstream>(bytes));
  if (!reader) {
    if (reader.error().where.find("block") == std::string::npos || reader.error().what.empty()) __builtin_trap();
    return 0;
  }
  auto replayer = Replayer::start(std::move(*reader));
  if (!replayer) return 0;
  for (int cycles = 0; cycles < 64; ++cycles) {
    const auto more = (*replayer)->step();
    if (!more.ok() || !*more) break;
    if (!(*replayer)->output().device[0].command.force.allFinite()) __builtin_trap();
  }
  return 0;
}
