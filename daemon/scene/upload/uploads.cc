#include "daemon/scene/upload/uploads.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <optional>
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
  upload.counts = bytes;
  uploads_.emplace(next_, std::move(upload));
  return next_++;
}

namespace {

Error over() { return {ErrorCode::kNotFound, "upload", "the upload is over", "begin another"}; }

}  // namespace

Result<UniqueFd> Uploads::region(std::uint64_t id) const {
  const auto it = uploads_.find(id);
  if (it == uploads_.end() || it->second.file.fd() < 0) return over();
  return it->second.file.share();
}

Uploads::Upload* Uploads::find(std::uint64_t id) {
  const auto it = uploads_.find(id);
  return it == uploads_.end() || it->second.cancelled ? nullptr : &it->second;
}

Uploads::Upload Uploads::take(std::uint64_t id) {
  Upload upload = std::move(uploads_.at(id));
  uploads_.erase(id);
  return upload;
}

template <class Work, class Tell>
void Uploads::startAside(std::uint64_t id, Work work, Tell tell) {
  Upload& upload = uploads_.at(id);
  upload.aside = aside_.start(
      std::move(work),
      [this, id, tell = std::move(tell)](auto made) mutable {
        Upload& back = uploads_.at(id);
        back.aside = 0;
        if (back.cancelled) {
          uploads_.erase(id);
        } else {
          tell(back, std::move(made));
        }
      },
      upload.by.connection);
}

Result<void> Uploads::freeze(std::uint64_t id) {
  Upload* const upload = find(id);
  if (upload == nullptr) return over();
  if (upload->committed) return Error{ErrorCode::kAlreadyExists, "upload", "it is committed already", {}};
  if (auto r = upload->file.seal(Seals::kFrozen); !r) return r;
  upload->committed = true;
  return {};
}

Result<void> Uploads::commit(std::uint64_t id, Progress progress, Done done) {
  if (builder_ == nullptr && find(id) != nullptr) {
    return Error{ErrorCode::kBuilderFailed, "builder", "it is not running: " + note_, "see hapticctl doctor"};
  }
  if (auto r = freeze(id); !r) return r;
  Upload& upload = uploads_.at(id);
  upload.progress = std::move(progress);
  upload.done = std::move(done);
  lookUp(id);
  return {};
}

Result<void> Uploads::commitTexture(std::uint64_t id, TextureDone done) {
  if (auto r = freeze(id); !r) return r;
  Upload& upload = uploads_.at(id);
  auto mapping = upload.file.map(Memfd::Access::kRead);
  if (!mapping) {
    uploads_.erase(id);
    return mapping.error();
  }
  upload.texture_done = std::move(done);
  startAside(
      id, [file = std::move(upload.file), mapping = std::move(*mapping)] { return parseTexture(mapping.bytes()); },
      [this, id](Upload&, Result<Texture> texture) {
        if (!texture) return take(id).texture_done(texture.error());
        layOut(id, std::move(*texture));
      });
  return {};
}

void Uploads::layOut(std::uint64_t id, Texture parsed) {
  Upload& upload = uploads_.at(id);
  upload.counts = 0;
  const std::uint64_t bytes = textures_.bytesFor(parsed);
  if (auto r = quota_(upload.by.uid, bytes, 0); !r) return take(id).texture_done(r.error());
  upload.counts = bytes;
  const auto texture = std::make_shared<Texture>(std::move(parsed));
  startAside(
      id,
      [texture, periods = textures_.periodsFor(*texture), lock = textures_.locks()] {
        return layOutAll(*texture, periods, lock);
      },
      [this, id, texture](Upload&, Result<LaidOut> made) {
        const Upload done = take(id);
        if (!made) return done.texture_done(made.error());
        auto added = textures_.add(std::move(*texture), done.by, std::move(*made));
        if (added) log::info("texture {} of '{}'", *added, log::printable(done.by.name));
        done.texture_done(added);
      });
}

void Uploads::cancel(std::uint64_t id) {
  const auto it = uploads_.find(id);
  if (it == uploads_.end()) return;
  Upload& upload = it->second;
  if (upload.job != 0 && builder_ != nullptr) builder_->cancel(upload.job);
  if (upload.aside == 0) return (void)uploads_.erase(it);
  aside_.cancel(upload.aside);
  upload.cancelled = true;
  upload.progress = {};
  upload.done = {};
  upload.texture_done = {};
}

void Uploads::poll() {
  aside_.poll();
  if (builder_ == nullptr) return;
  BuildReport report;
  while (builder_->next(report)) {
    std::uint64_t id = 0;
    for (const auto& [i, upload] : uploads_) {
      if (upload.job == report.job && report.job != 0) id = i;
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
  Upload& upload = uploads_.at(id);
  upload.job = 0;
  if (report.kind == BuildReport::Kind::kFailed) {
    log::warn("a mesh of '{}' is refused: {}", log::printable(upload.by.name), log::printable(toString(report.error)));
    return take(id).done(report.error);
  }
  upload.file = Memfd();  // the build has it all
  MeshInfo info;
  info.owner = upload.by;
  info.build_ns = report.stats.build_ns;
  info.triangles = report.stats.triangles;
  check(id, {std::move(report.snapshot), std::move(report.volume), std::move(report.notes)}, std::move(info), false);
}

void Uploads::check(std::uint64_t id, CachedBuild built, MeshInfo info, bool cached) {
  Upload& upload = uploads_.at(id);
  // Count the memory by its real size, not by what its header says, and in place of the upload it was made from.
  const std::uint64_t bytes = meshes_.bytesFor(built.snapshot, built.volume);
  upload.counts = 0;
  if (auto r = quota_(upload.by.uid, bytes, info.triangles); !r) return take(id).done(r.error());
  upload.counts = bytes;
  info.notes = built.notes;
  info.cache_key = upload.cache_key;
  auto snapshot = duplicate(built.snapshot.get()), volume = duplicate(built.volume.get());
  const bool keep = !cached && cache_ != nullptr && !upload.cache_key.empty() && snapshot && volume;
  CachedBuild kept;
  if (keep) kept = {std::move(*snapshot), std::move(*volume), std::move(built.notes)};
  startAside(
      id,
      [snapshot = std::move(built.snapshot), volume = std::move(built.volume), lock = meshes_.locks(),
       servos = meshes_.servos()]() mutable { return checkMesh(std::move(snapshot), std::move(volume), lock, servos); },
      [this, id, cached, bytes, keep, kept = std::move(kept), info = std::move(info)](
          Upload& back, Result<CheckedMesh> mesh) mutable {
        if (!mesh && cached && mesh.error().code == ErrorCode::kBadSnapshot) {
          log::warn("a cached volume is built again: {}", toString(mesh.error()));
          cache_->drop(back.cache_key);
          back.counts = back.file.size();
          return build(id);
        }
        const Upload done = take(id);
        auto made = mesh ? adopt(std::move(*mesh), std::move(info), bytes) : Result<MeshInfo>(mesh.error());
        if (made && keep) cache_->keep(done.cache_key, std::move(kept.snapshot), std::move(kept.volume), kept.notes);
        done.done(std::move(made));
      });
}

Result<MeshInfo> Uploads::adopt(CheckedMesh mesh, MeshInfo info, std::uint64_t bytes) {
  if (auto r = quota_(info.owner.uid, bytes, info.triangles); !r) return r.error();
  const auto id = meshes_.add(std::move(mesh), std::move(info));
  if (!id) return id.error();
  const MeshInfo& made = *meshes_.find(*id);
  log::info("mesh {} of '{}': {} triangles, {} bytes, built in {:.1f} ms", made.id, log::printable(made.owner.name),
            made.triangles, made.bytes, static_cast<double>(made.build_ns) * 1e-6);
  return made;
}

void Uploads::lookUp(std::uint64_t id) {
  if (cache_ == nullptr) return build(id);
  Upload& upload = uploads_.at(id);
  auto mapped = upload.file.map(Memfd::Access::kRead);
  if (!mapped || mapped->size() < sizeof(hd_mesh_upload)) return build(id);
  hd_mesh_upload head{};
  std::memcpy(&head, mapped->data(), sizeof head);
  if ((head.flags & HD_UPLOAD_VOLUME) == 0) return build(id);  // A mesh alone is built about as fast as it is read.
  struct Found {
    std::string key;
    std::optional<CachedBuild> build;
  };
  startAside(
      id,
      [cache = cache_.get(), mapping = std::move(*mapped), uid = upload.by.uid]() -> Result<Found> {
        Found found{VolumeCache::keyOf(mapping.bytes(), uid), {}};
        found.build = cache->find(found.key);
        return found;
      },
      [this, id, triangles = head.triangle_count](Upload& back, Result<Found> found) {
        if (found) back.cache_key = std::move(found->key);
        if (!found || !found->build) return build(id);
        MeshInfo info;
        info.owner = back.by;
        info.triangles = triangles;
        check(id, std::move(*found->build), std::move(info), true);
      });
}

void Uploads::build(std::uint64_t id) {
  Upload& upload = uploads_.at(id);
  auto job = builder_ == nullptr ? Result<std::uint64_t>(Error{ErrorCode::kBuilderFailed, "builder", note_, {}})
                                 : builder_->submit(upload.file.fd(), upload.by.connection);
  if (!job) return take(id).done(job.error());
  upload.job = *job;
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
    if (upload.by.uid == uid) sum += upload.counts;
  }
  return sum;
}

}  // namespace hapticd
