#include "daemon/recording/reader.h"

#include <capnp/serialize.h>
#include <fmt/format.h>
#include <kj/exception.h>

#include <filesystem>
#include <fstream>

#include "daemon/recording/block.h"
#include "daemon/recording/convert.h"
#include "daemon/recording/texture.h"

namespace hapticd {
namespace {

constexpr std::uint64_t kMostMeshBytes = std::uint64_t{1} << 32;

capnp::ReaderOptions readerOptions() {
  capnp::ReaderOptions options;
  options.traversalLimitInWords = 4 * kMostBlockBytes / sizeof(capnp::word);
  return options;
}

}  // namespace

/** The block that is being read, and what has come so far. */
struct RecordingReader::State {
  explicit State(std::unique_ptr<std::istream> stream) : in(std::move(stream)), blocks(*in) {}

  Result<bool> nextBlock();
  Result<void> takeBlock(proto::Block::Reader block);
  Result<void> takeMeshPart(proto::MeshPart::Reader part);
  Result<bool> next(RecordedCycle& cycle);

  std::unique_ptr<std::istream> in;
  BlockReader blocks;
  kj::Array<capnp::word> words;
  std::optional<capnp::FlatArrayMessageReader> message;
  capnp::List<proto::CycleRecord>::Reader cycles;
  unsigned cycle_index = 0;
  bool started = false, failed = false;
  std::uint64_t last_tick = 0, cycle_count = 0;
  RecordingHeader header;
  std::optional<RecordedMesh> mesh;  ///< Not whole yet.
  std::uint64_t mesh_size = 0;
  std::vector<RecordedMesh> meshes;
  TextureParts texture_parts;
  std::vector<RecordedTexture> textures;
  std::optional<RecordingEnd> end;
};

Result<bool> RecordingReader::State::nextBlock() {
  auto more = blocks.next(words);
  if (!more || !*more) return more;
  try {
    message.emplace(words, readerOptions());
    if (auto r = takeBlock(message->getRoot<proto::Block>()); !r) {
      Error error = blocks.errorHere(r.error().where + ": " + r.error().what, r.error().remedy);
      error.code = r.error().code;
      return error;
    }
  } catch (const kj::Exception& e) {
    return blocks.errorHere(fmt::format("it is no message of a recording: {}", e.getDescription().cStr()));
  }
  return true;
}

Result<void> RecordingReader::State::takeBlock(proto::Block::Reader block) {
  const auto refuse = [](const char* what) { return Error{ErrorCode::kInvalidArgument, "block", what, {}}; };
  if (block.isHeader() == started) return refuse(started ? "a second header" : "a recording starts with its header");
  if (end) return refuse("something follows the end");
  if (mesh && !block.isMeshPart()) return refuse("a mesh is not whole");
  if (texture_parts.pending() && !block.isTexturePart()) return refuse("a relief is not whole");
  switch (block.which()) {
    case proto::Block::HEADER: {
      auto read = hapticd::read(block.getHeader());
      if (!read) return read.error();
      header = std::move(*read);
      last_tick = header.start.tick;
      started = true;
      return {};
    }
    case proto::Block::MESH_PART:
      return takeMeshPart(block.getMeshPart());
    case proto::Block::TEXTURE_PART: {
      auto texture = texture_parts.take(block.getTexturePart());
      if (!texture) return texture.error();
      if (*texture) textures.push_back(std::move(**texture));
      return {};
    }
    case proto::Block::CYCLES:
      cycles = block.getCycles();
      cycle_index = 0;
      return {};
    case proto::Block::END: {
      const auto last = block.getEnd();
      end = RecordingEnd{last.getReason().cStr(), last.getCycles(), last.getLost()};
      if (end->cycles != cycle_count) return refuse("the end counts other cycles than there are");
      return {};
    }
  }
  return refuse("a kind that this program does not know");
}

Result<void> RecordingReader::State::takeMeshPart(proto::MeshPart::Reader part) {
  const auto refuse = [](std::string what) {
    return Error{ErrorCode::kInvalidArgument, "meshPart", std::move(what), {}};
  };
  const auto bytes = part.getBytes();
  if (!mesh) {
    if (part.getEntry() >= kMaxMeshes) return refuse(fmt::format("entry {} of the mesh table", part.getEntry()));
    if (part.getSize() > kMostMeshBytes) return refuse(fmt::format("a mesh of {} bytes", part.getSize()));
    mesh = RecordedMesh{part.getEntry(), {}};
    mesh_size = part.getSize();
  }
  if (part.getEntry() != mesh->entry || part.getSize() != mesh_size || part.getOffset() != mesh->bytes.size() ||
      bytes.size() == 0 || bytes.size() > mesh_size - mesh->bytes.size()) {
    return refuse("it does not follow the part before it");
  }
  const auto* const first = reinterpret_cast<const std::byte*>(bytes.begin());
  mesh->bytes.insert(mesh->bytes.end(), first, first + bytes.size());
  if (mesh->bytes.size() == mesh_size) {
    meshes.push_back(std::move(*mesh));
    mesh.reset();
  }
  return {};
}

Result<bool> RecordingReader::State::next(RecordedCycle& cycle) {
  while (cycle_index == cycles.size()) {
    cycles = {};
    cycle_index = 0;
    auto more = nextBlock();
    if (!more || !*more) return more;
  }
  try {
    if (auto r = hapticd::read(cycles[cycle_index++], header.start.config.device_count, cycle); !r) {
      return blocks.errorHere(r.error().where + ": " + r.error().what);
    }
  } catch (const kj::Exception& e) {
    return blocks.errorHere(fmt::format("it is no message of a recording: {}", e.getDescription().cStr()));
  }
  if (cycle.input.tick <= last_tick) {
    return blocks.errorHere(fmt::format("tick {} does not follow {}", cycle.input.tick, last_tick));
  }
  last_tick = cycle.input.tick;
  ++cycle_count;
  return true;
}

RecordingReader::RecordingReader(std::unique_ptr<State> state) : state_(std::move(state)) {}
RecordingReader::RecordingReader(RecordingReader&&) noexcept = default;
RecordingReader& RecordingReader::operator=(RecordingReader&&) noexcept = default;
RecordingReader::~RecordingReader() = default;

Result<RecordingReader> RecordingReader::open(const std::string& path) {
  if (std::error_code none; std::filesystem::is_character_file(path, none))
    return Error{ErrorCode::kInvalidArgument, path, "it is a device, without an end", "a recording's file"};
  auto file = std::make_unique<std::ifstream>(path, std::ios::binary);
  if (!*file)
    return Error{ErrorCode::kNotFound, path, "it cannot be opened for reading", "see the path and its rights"};
  auto reader = read(std::move(file));
  if (reader) return reader;
  Error error = reader.error();
  error.where = path + ": " + error.where;
  return error;
}

Result<RecordingReader> RecordingReader::read(std::unique_ptr<std::istream> in) {
  auto state = std::make_unique<State>(std::move(in));
  auto more = state->nextBlock();
  if (!more) return more.error();
  if (!*more) {
    return Error{ErrorCode::kInvalidArgument, "block 0 at byte 0", "it ends before its header is whole",
                 "nothing was recorded; record again"};
  }
  return RecordingReader(std::move(state));
}

const RecordingHeader& RecordingReader::header() const { return state_->header; }

Result<bool> RecordingReader::next(RecordedCycle& cycle) {
  if (state_->failed) return false;
  auto more = state_->next(cycle);
  state_->failed = !more.ok();
  return more;
}

std::vector<RecordedMesh> RecordingReader::takeMeshes() { return std::exchange(state_->meshes, {}); }

std::vector<RecordedTexture> RecordingReader::takeTextures() { return std::exchange(state_->textures, {}); }

const std::optional<RecordingEnd>& RecordingReader::end() const { return state_->end; }

}  // namespace hapticd
