#include "daemon/scene/uploads.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "daemon/log/log.h"
#include "proto/volume.h"

namespace hapticd {
namespace {

constexpr std::uint64_t kVertexBytes = 3 * sizeof(float);
constexpr std::uint64_t kTriangleBytes = 3 * sizeof(std::uint32_t);
constexpr std::uint64_t kLeast = 32;  // The smallest texture; the builder refuses what holds no triangle.
constexpr std::uint64_t kMost = sizeof(hd_mesh_upload) + HD_MAX_VERTICES * kVertexBytes +
                                HD_MAX_TRIANGLES * kTriangleBytes + sizeof(hd_volume_request);

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
  upload.progress = std::move(progress);
  upload.done = std::move(done);
  if (finishFromCache(id)) return {};
  auto job = builder_->submit(upload.file.fd());
  if (!job) return job.error();
  upload.job = *job;
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
  if (auto r = quota_(upload.by.uid, textures_.bytesFor(*texture), 0); !r) return r.error();
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
  MeshInfo info;
  info.owner = upload.by;
  info.notes = report.notes;
  info.build_ns = report.stats.build_ns;
  info.triangles = report.stats.triangles;
  info.cache_key = upload.cache_key;
  auto snapshot = duplicate(report.snapshot.get()), volume = duplicate(report.volume.get());
  auto made = adopt(std::move(report.snapshot), std::move(report.volume), std::move(info));
  if (made && cache_ != nullptr && !upload.cache_key.empty() && snapshot && volume)
    cache_->keep(upload.cache_key, std::move(*snapshot), std::move(*volume), report.notes);
  upload.done(std::move(made));
}

Result<MeshInfo> Uploads::adopt(UniqueFd snapshot, UniqueFd volume, MeshInfo info) {
  // Sizes of the memory itself: what is said of it is not believed.
  const std::uint64_t bytes = meshes_.bytesFor(snapshot, volume);
  if (auto r = quota_(info.owner.uid, bytes, info.triangles); !r) return r.error();
  const auto id = meshes_.add(std::move(snapshot), std::move(volume), std::move(info));
  if (!id) return id.error();
  const MeshInfo& made = *meshes_.find(*id);
  log::info("mesh {} of '{}': {} triangles, {} bytes, built in {:.1f} ms", made.id, log::printable(made.owner.name),
            made.triangles, made.bytes, static_cast<double>(made.build_ns) * 1e-6);
  return made;
}

bool Uploads::finishFromCache(std::uint64_t id) {
  Upload& upload = uploads_.at(id);
  if (cache_ == nullptr) return false;
  hd_mesh_upload head{};
  {
    const auto mapping = upload.file.map(Memfd::Access::kRead);
    if (!mapping || mapping->size() < sizeof head) return false;
    std::memcpy(&head, mapping->data(), sizeof head);
    if ((head.flags & HD_UPLOAD_VOLUME) == 0) return false;  // A mesh alone is built about as fast as it is read.
    upload.cache_key = VolumeCache::keyOf(mapping->bytes(), upload.by.uid);
  }
  auto found = cache_->find(upload.cache_key);
  if (!found) return false;
  Memfd file = std::exchange(upload.file, Memfd());  // As in finish(): it does not count beside what it became.
  MeshInfo info;
  info.owner = upload.by;
  info.notes = std::move(found->notes);
  info.triangles = head.triangle_count;
  info.cache_key = upload.cache_key;
  auto made = adopt(std::move(found->snapshot), std::move(found->volume), std::move(info));
  if (!made && made.error().code == ErrorCode::kBadSnapshot) {
    log::warn("a cached volume is built again: {}", toString(made.error()));
    cache_->drop(upload.cache_key);
    upload.file = std::move(file);
    return false;
  }
  const Done done = std::move(upload.done);
  uploads_.erase(id);
  done(std::move(made));
  return true;
}

Result<UniqueFd> Uploads::volumeFile(const MeshInfo& mesh, const Client& by) const {
  if (mesh.owner.uid != by.uid && !by.administration) {
    return Error{ErrorCode::kPermissionDenied, "mesh",
                 fmt::format("mesh {} belongs to user {}", mesh.id, mesh.owner.uid), "use the administration socket"};
  }
  if (mesh.voxel == 0)
    return Error{ErrorCode::kNotFound, "mesh", "it has no volume", "load it with hapticctl load --voxel"};
  if (cache_ == nullptr || mesh.cache_key.empty()) {
    return Error{ErrorCode::kUnsupported, "mesh", "volumes are not kept on disk here",
                 "set builder.cache in hapticd.toml to a folder"};
  }
  return cache_->openVdb(mesh.cache_key);
}

std::uint64_t Uploads::bytesOf(std::uint32_t uid) const {
  std::uint64_t sum = 0;
  for (const auto& [id, upload] : uploads_) {
    if (upload.by.uid == uid) sum += upload.file.size();
  }
  return sum;
}

}  // namespace hapticd
