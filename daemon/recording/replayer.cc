#include "daemon/recording/replayer.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "daemon/ipc/snapshot_memory.h"
#include "rt/cycle/realtime.h"

namespace hapticd {

/** A mesh in memory of its own: a deformable one is written to. */
struct ReplayedMesh {
  Mapping memory;
  Mapping motion;
  MeshView view;
};

struct ReplayedTexture {
  RecordedTexture memory;
  TextureView view;
};

namespace {

Result<std::unique_ptr<ReplayedMesh>> makeMesh(const RecordedMesh& mesh) {
  auto file = Memfd::create("hapticd-replay", mesh.bytes.size());
  if (!file) return file.error();
  auto memory = file->map(Memfd::Access::kWrite);
  if (!memory) return memory.error();
  std::memcpy(memory->data(), mesh.bytes.data(), mesh.bytes.size());
  auto view = validateSnapshot(memory->bytes());
  if (!view) return view.error();
  auto motion = addMotion(*view);
  if (!motion) return motion.error();
  return std::make_unique<ReplayedMesh>(ReplayedMesh{std::move(*memory), std::move(*motion), *view});
}

struct Difference {
  double size = 0;
  bool bits = false;
};

void compare(double a, double b, Difference& difference) {
  if (std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b)) return;
  difference.bits = true;
  const double size = std::abs(a - b);
  // What is no number is further off than any: as NaN it would be forgotten with the next difference.
  difference.size = std::isnan(size) ? std::numeric_limits<double>::infinity() : std::max(difference.size, size);
}

Difference compare(const DeviceCommand& a, const DeviceCommand& b) {
  Difference out;
  for (int i = 0; i < 3; ++i) {
    compare(a.force[i], b.force[i], out);
    compare(a.torque[i], b.torque[i], out);
  }
  compare(a.gripper_force, b.gripper_force, out);
  if (a.enabled != b.enabled) out = {std::numeric_limits<double>::infinity(), true};
  return out;
}

std::string words(const DeviceCommand& c) {
  return fmt::format("({}, {}, {}) N, ({}, {}, {}) N m, gripper {} N, {}", c.force[0], c.force[1], c.force[2],
                     c.torque[0], c.torque[1], c.torque[2], c.gripper_force, c.enabled ? "on" : "off");
}

}  // namespace

Replayer::Replayer(RecordingReader reader)
    : reader_(std::move(reader)),
      table_(std::make_unique<MeshTable>()),
      recorded_(std::make_unique<RecordedCycle>()),
      output_(std::make_unique<CycleOutput>()) {}

Replayer::~Replayer() = default;

Result<std::unique_ptr<Replayer>> Replayer::open(const std::string& path) {
  auto reader = RecordingReader::open(path);
  if (!reader) return reader.error();
  return start(std::move(*reader));
}

Result<std::unique_ptr<Replayer>> Replayer::start(RecordingReader reader) {
  std::unique_ptr<Replayer> out(new Replayer(std::move(reader)));
  // Reading the first cycle also reads the meshes of the start, which stand before it.
  if (auto more = out->readOne(); !more) return more.error();
  out->cycle_ = makeCycle(out->reader_.header().start, *out->table_);
  return out;
}

Result<void> Replayer::takeMeshes() {
  for (const RecordedMesh& recorded : reader_.takeMeshes()) {
    auto mesh = makeMesh(recorded);
    if (!mesh) return mesh.error();
    table_->publish(recorded.entry, &(*mesh)->view);
    meshes_.push_back(std::move(*mesh));
  }
  return {};
}

void Replayer::takeTextures() {
  for (RecordedTexture& recorded : reader_.takeTextures()) {
    auto texture = std::make_unique<ReplayedTexture>();
    texture->memory = std::move(recorded);
    texture->view = texture->memory.view();
    table_->publishTexture(texture->memory.entry, &texture->view);
    textures_.push_back(std::move(texture));
  }
}

Result<bool> Replayer::readOne() {
  auto more = reader_.next(*recorded_);
  if (!more) return more;
  if (auto r = takeMeshes(); !r) return r.error();
  takeTextures();
  ahead_ = *more;
  over_ = !*more;
  return more;
}

Result<bool> Replayer::step() {
  if (over_) return false;
  if (!ahead_) {
    if (auto more = readOne(); !more || !*more) return more;
  }
  ahead_ = false;
  const DenormalsAsZero denormals(reader_.header().flush_denormals);
  cycle_->step(recorded_->input, *output_);
  return true;
}

Result<Verdict> verify(Replayer& replayer) {
  const RecordingHeader& header = replayer.recording().header();
  Verdict verdict;
  verdict.same_program = header.build == realtimeBuild() && header.instructions == instructionSet();
  while (true) {
    auto more = replayer.step();
    if (!more) return more.error();
    if (!*more) return verdict;
    ++verdict.cycles;
    bool differs = false;
    for (std::uint32_t d = 0; d < header.start.config.device_count; ++d) {
      const DeviceCommand& then = replayer.recorded().sent[d];
      const DeviceCommand& now = replayer.output().device[d].command;
      const Difference difference = compare(then, now);
      verdict.largest = std::max(verdict.largest, difference.size);
      if (!difference.bits || (!verdict.same_program && difference.size <= Verdict::kTolerance)) continue;
      differs = true;
      if (verdict.first.empty()) {
        verdict.first = fmt::format("tick {}, device {}: sent {}; now {}", replayer.recorded().input.tick,
                                    header.devices[d].name, words(then), words(now));
      }
    }
    verdict.differing += differs ? 1 : 0;
  }
}

}  // namespace hapticd
