#include "daemon/recording/writer.h"

#include <capnp/message.h>

#include <algorithm>

#include "daemon/recording/block.h"
#include "daemon/recording/convert.h"
#include "daemon/recording/texture.h"

namespace hapticd {
namespace {

/** Without the places for commands that are not in use. */
void copy(const RecordedCycle& from, RecordedCycle& to) {
  to.input.tick = from.input.tick;
  to.input.now_ns = from.input.now_ns;
  to.input.missed = from.input.missed;
  to.input.stop_line = from.input.stop_line;
  to.input.deadman_open = from.input.deadman_open;
  to.input.device = from.input.device;
  to.input.command_count = from.input.command_count;
  std::copy_n(from.input.command.begin(), from.input.command_count, to.input.command.begin());
  to.sent = from.sent;
}

}  // namespace

template <class Fill>
bool RecordingWriter::block(Fill&& fill) {
  if (!good_) return false;
  capnp::MallocMessageBuilder message;
  fill(message.initRoot<proto::Block>());
  good_ = sink_(encodeBlock(blocks_++, message));
  return good_;
}

bool RecordingWriter::header(const RecordingHeader& header) {
  device_count_ = header.start.config.device_count;
  return block([&](proto::Block::Builder out) { write(header, out.initHeader()); });
}

bool RecordingWriter::mesh(std::uint32_t entry, std::span<const std::byte> snapshot) {
  flush();
  for (std::size_t offset = 0; offset < snapshot.size(); offset += kMeshPartBytes) {
    const auto part = snapshot.subspan(offset, std::min(kMeshPartBytes, snapshot.size() - offset));
    block([&](proto::Block::Builder out) {
      auto builder = out.initMeshPart();
      builder.setEntry(entry);
      builder.setSize(snapshot.size());
      builder.setOffset(offset);
      builder.setBytes({reinterpret_cast<const kj::byte*>(part.data()), part.size()});
    });
  }
  return good_;
}

bool RecordingWriter::texture(std::uint32_t entry, const TextureView& texture) {
  flush();
  for (std::uint32_t part = 0; part < partsOf(texture); ++part) {
    block([&](proto::Block::Builder out) { writePart(entry, texture, part, out.initTexturePart()); });
  }
  return good_;
}

bool RecordingWriter::cycle(const RecordedCycle& cycle) {
  if (!good_) return false;
  if (waiting_count_ == waiting_.size()) waiting_.emplace_back();
  copy(cycle, waiting_[waiting_count_++]);
  return waiting_count_ < kMostCycles || flush();
}

bool RecordingWriter::flush() {
  if (waiting_count_ == 0) return good_;
  const auto count = static_cast<unsigned>(waiting_count_);
  waiting_count_ = 0;
  const bool taken = block([&](proto::Block::Builder out) {
    auto list = out.initCycles(count);
    for (unsigned i = 0; i < count; ++i) write(waiting_[i], device_count_, list[i]);
  });
  cycles_ += taken ? count : 0;
  return taken;
}

bool RecordingWriter::end(const std::string& reason, std::uint64_t lost) {
  flush();
  return block([&](proto::Block::Builder out) {
    auto builder = out.initEnd();
    builder.setReason(reason.c_str());
    builder.setCycles(cycles_);
    builder.setLost(lost);
  });
}

}  // namespace hapticd
