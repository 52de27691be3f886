#include "daemon/scene/uploads.h"

#include <fmt/format.h>

#include <algorithm>

#include "daemon/log.h"
#include "daemon/scene/texture_memory.h"

namespace hapticd {
namespace {

constexpr std::uint64_t kVertexBytes = 3 * sizeof(float);
constexpr std::uint64_t kTriangleBytes = 3 * sizeof(std::uint32_t);
constexpr std::uint64_t kLeast = 32;  // The smallest texture; the builder refuses what holds no triangle.
constexpr std::uint64_t kMost =
    sizeof(hd_mesh_upload) + HD_MAX_VERTICES * kVertexBytes + HD_MAX_TRIANGLES * kTriangleBytes;

}  // namespace

void Uploads::setBuilder(std::unique_ptr<BuilderLeash> builder, std::string why_not) {
  builder_ = std::move(builder);
  note_ = std::move(why_not);
}

Result<std::uint64_t> Uploads::begin(std::uint64_t bytes, const Client& by) {
  if (bytes < kLeast || bytes > kMost) {
    return Error{ErrorCode::kInvalidArgument, "bytes", fmt::format("{} is not between {} and {}", bytes, kLeast, kMost),
                 fmt::format("a mesh has {} + 12 per vertex + 12 per triangle", sizeof(hd_mesh_upload))};
  }
  const auto same =
      std::count_if(uploads_.begin(), uploads_.end(), [&](const auto& u) { return u.second.by.uid == by.uid; });
  if (static_cast<std::size_t>(same) >= kPerUser) {
    return Error{ErrorCode::kQuotaExceeded, "uploads",
                 fmt::format("user {} has {} uploads under way, the most allowed", by.uid, kPerUser),
                 "commit or drop some"};
  }
  if (auto r = quota_(by.uid, bytes, 0); !r) return r.error();
  auto file = Memfd::create("hapticd-upload", bytes);
  if (!file) return file.error();
  if (auto r = file->seal(Seals::kFixedSize); !r) return r.error();
  Upload upload;
  upload.file = std::move(*file);
  upload.by = by;
  uploads_.emplace(next_, std::move(upload));
  return next_++;
}

Result<UniqueFd> Uploads::region(std::uint64_t id) const {
  const auto it = uploads_.find(id);
  if (it == uploads_.end()) return Error{ErrorCode::kNotFound, "upload", "the upload is over", "begin another"};
  return it->second.file.share();
}

Result<void> Uploads::commit(std::uint64_t id, Progress progress, Done done) {
  const auto it = uploads_.find(id);
  if (it == uploads_.end()) return Error{ErrorCode::kNotFound, "upload", "the upload is over", "begin another"};
  Upload& upload = it->second;
  if (upload.job != 0) return Error{ErrorCode::kAlreadyExists, "upload", "it is committed already", {}};
  if (builder_ == nullptr) {
    return Error{ErrorCode::kBuilderFailed, "builder", "it is not running: " + note_, "see hapticctl doctor"};
  }
  if (auto r = upload.file.seal(Seals::kFrozen); !r) return r;
  auto job = builder_->submit(upload.file.fd());
  if (!job) return job.error();
  upload.job = *job;
  upload.progress = std::move(progress);
  upload.done = std::move(done);
  return {};
}

Result<std::uint64_t> Uploads::commitTexture(std::uint64_t id) {
  const auto it = uploads_.find(id);
  if (it == uploads_.end()) return Error{ErrorCode::kNotFound, "upload", "the upload is over", "begin another"};
  if (it->second.job != 0) return Error{ErrorCode::kAlreadyExists, "upload", "it is committed already", {}};
  if (auto r = it->second.file.seal(Seals::kFrozen); !r) return r.error();
  const Upload upload = std::move(it->second);
  uploads_.erase(it);
  auto mapping = upload.file.map(Memfd::Access::kRead);
  if (!mapping) return mapping.error();
  auto texture = parseTexture(mapping->bytes());
  if (!texture) return texture.error();
  if (auto r = quota_(upload.by.uid, 2 * layOutBytes(*texture), 0); !r) return r.error();
  auto made = textures_.add(std::move(*texture), upload.by);
  if (made) log::info("texture {} of '{}'", *made, log::printable(upload.by.name));
  return made;
}

void Uploads::cancel(std::uint64_t id) {
  const auto it = uploads_.find(id);
  if (it == uploads_.end()) return;
  if (it->second.job != 0 && builder_ != nullptr) builder_->cancel(it->second.job);
  uploads_.erase(it);
}

void Uploads::poll() {
  if (builder_ == nullptr) return;
  BuildReport report;
  while (builder_->next(report)) {
    std::uint64_t id = 0;
    for (const auto& [i, upload] : uploads_) {
      if (upload.job == report.job) id = i;
    }
    if (id == 0) continue;  // cancelled
    if (report.kind == BuildReport::Kind::kProgress) {
      if (const Progress progress = uploads_.at(id).progress) progress(report.fraction, report.stage);
    } else {
      finish(id, report);
    }
    report = {};
  }
}

void Uploads::finish(std::uint64_t id, BuildReport& report) {
  Upload upload = std::move(uploads_.at(id));
  uploads_.erase(id);
  if (report.kind == BuildReport::Kind::kFailed) {
    log::warn("a mesh of '{}' is refused: {}", log::printable(upload.by.name), log::printable(toString(report.error)));
    upload.done(report.error);
    return;
  }
  upload.file = Memfd();  // the build has it all
  if (auto r = quota_(upload.by.uid, report.stats.bytes, report.stats.triangles); !r) {
    upload.done(r.error());
    return;
  }
  MeshInfo info;
  info.owner = upload.by;
  info.notes = std::move(report.notes);
  info.build_ns = report.stats.build_ns;
  auto mesh = meshes_.add(std::move(report.snapshot), std::move(info));
  if (!mesh) {
    upload.done(mesh.error());
    return;
  }
  const MeshInfo& made = *meshes_.find(*mesh);
  log::info("mesh {} of '{}': {} triangles, {} bytes, built in {:.1f} ms", made.id, log::printable(upload.by.name),
            made.triangles, made.bytes, static_cast<double>(made.build_ns) * 1e-6);
  upload.done(made);
}

std::uint64_t Uploads::bytesOf(std::uint32_t uid) const {
  std::uint64_t sum = 0;
  for (const auto& [id, upload] : uploads_) {
    if (upload.by.uid == uid) sum += upload.file.size();
  }
  return sum;
}

}  // namespace hapticd
