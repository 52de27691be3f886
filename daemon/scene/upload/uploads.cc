#include "daemon/scene/upload/uploads.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <new>
#include <optional>
#include <tuple>
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
  if (builder_ != nullptr) builder_->onSpent([this](UniqueFd file) { close(std::move(file), [] {}); });
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

bool Uploads::isLarge(int fd) noexcept {
  struct stat held {};
  return fd >= 0 && ::fstat(fd, &held) == 0 && static_cast<std::uint64_t>(held.st_blocks) * 512 >= kLargeBytes;
}

Uploads::Upload Uploads::take(std::uint64_t id) {
  Upload taken = std::move(uploads_.at(id));
  uploads_.at(id).file = std::move(taken.file);
  forget(id);
  return taken;
}

template <class... More>
void Uploads::forget(std::uint64_t id, More... more) noexcept {
  const auto it = uploads_.find(id);
  if (it == uploads_.end()) return;
  Upload& upload = it->second;
  upload.cancelled = true;
  upload.job = 0;
  upload.progress = {};
  upload.done = {};
  upload.texture_done = {};
  const bool at_once = sizeof...(More) == 0 && !isLarge(upload.file.fd());
  if (at_once ||
      !going_.letGo(std::make_tuple(std::move(upload.file), std::move(more)...), [this, id] { uploads_.erase(id); }))
    uploads_.erase(it);
}

template <class... More>
void Uploads::fail(std::uint64_t id, const Error& why, More... more) {
  Upload& upload = uploads_.at(id);
  const Done done = std::move(upload.done);
  const TextureDone texture_done = std::move(upload.texture_done);
  forget(id, std::move(more)...);
  if (done) done(why);
  if (texture_done) texture_done(why);
}

template <class Step>
void Uploads::step(std::uint64_t id, Step&& go_on) {
  try {
    go_on();
  } catch (const std::bad_alloc&) {
    const Upload* const stands = find(id);  // If nothing goes on with it, whoever waits would wait for ever.
    if (stands != nullptr && stands->job == 0 && stands->aside == 0) fail(id, Aside::noMemory());
    throw;
  }
}

template <class Work, class Tell>
void Uploads::startAside(std::uint64_t id, Work work, Tell tell) {
  Upload& upload = uploads_.at(id);
  upload.aside = aside_.start(
      std::move(work),
      [this, id, tell = std::move(tell)](auto made) mutable {
        Upload& back = uploads_.at(id);
        back.aside = 0;
        if (back.cancelled) return forget(id, std::move(made), std::move(tell));
        step(id, [&] { tell(back, std::move(made)); });
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
    forget(id);
    return mapping.error();
  }
  upload.texture_done = std::move(done);
  startAside(
      id, [file = std::move(upload.file), mapping = std::move(*mapping)] { return parseTexture(mapping.bytes()); },
      [this, id](Upload&, Result<Texture> texture) {
        if (!texture) return fail(id, texture.error());
        layOut(id, std::move(*texture));
      });
  return {};
}

void Uploads::layOut(std::uint64_t id, Texture parsed) {
  Upload& upload = uploads_.at(id);
  upload.counts = 0;
  const std::uint64_t bytes = textures_.bytesFor(parsed);
  auto may = quota_(upload.by.uid, bytes, 0);
  if (may) may = textures_.room(upload.by);
  if (!may) return fail(id, may.error(), std::move(parsed));
  upload.counts = bytes;
  const auto texture = std::make_shared<Texture>(std::move(parsed));
  startAside(
      id,
      [texture, periods = textures_.periodsFor(*texture), lock = textures_.locks()] {
        return layOutAll(*texture, periods, lock);
      },
      [this, id, texture](Upload& back, Result<LaidOut> made) {
        if (!made) return fail(id, made.error(), texture);
        // Before the upload is over: if there is no memory for it, step() tells whoever waits.
        auto added = textures_.add(std::move(*texture), back.by, std::move(*made));
        if (added) log::info("texture {} of '{}'", *added, log::printable(back.by.name));
        const Upload done = take(id);
        done.texture_done(added);
      });
}

void Uploads::cancel(std::uint64_t id) noexcept {
  Upload* const upload = find(id);
  if (upload == nullptr) return;
  if (upload->job != 0 && builder_ != nullptr) builder_->cancel(upload->job);
  if (upload->aside == 0) return forget(id);
  aside_.cancel(upload->aside);
  upload->cancelled = true;
  upload->progress = {};
  upload->done = {};
  upload->texture_done = {};
}

void Uploads::poll() {
  going_.poll();
  aside_.poll();
  if (builder_ == nullptr) return;
  BuildReport report;
  while (builder_->next(report)) {
    std::uint64_t id = 0;
    for (const auto& [i, upload] : uploads_) {
      if (upload.job == report.job && report.job != 0) id = i;
    }
    if (id == 0) {  // Cancelled.
      for (UniqueFd* const file : {&report.snapshot, &report.volume}) close(std::move(*file), [] {});
      continue;
    }
    if (report.kind == BuildReport::Kind::kProgress) {
      if (const Progress progress = uploads_.at(id).progress) progress(report.fraction, report.stage);
    } else {
      step(id, [&] { finish(id, report); });
    }
    report = {};
  }
}

void Uploads::finish(std::uint64_t id, BuildReport& report) {
  Upload& upload = uploads_.at(id);
  upload.job = 0;
  if (report.kind == BuildReport::Kind::kFailed) {
    log::warn("a mesh of '{}' is refused: {}", log::printable(upload.by.name), log::printable(toString(report.error)));
    return fail(id, report.error);
  }
  if (Memfd spent = std::move(upload.file); isLarge(spent.fd())) (void)going_.letGo(std::move(spent), [] {});
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
  if (auto r = quota_(upload.by.uid, bytes, info.triangles); !r) return fail(id, r.error(), std::move(built));
  upload.counts = bytes;
  info.notes = built.notes;
  info.cache_key = upload.cache_key;
  auto snapshot = duplicate(built.snapshot.get()), volume = duplicate(built.volume.get());
  const bool keep = !cached && cache_ != nullptr && !upload.cache_key.empty() && snapshot && volume;
  CachedBuild kept;
  if (keep) kept = {std::move(*snapshot), std::move(*volume), std::move(built.notes)};
  startAside(
      id,
      [snapshot = std::move(built.snapshot), volume = std::move(built.volume), kept = std::move(kept),
       lock = meshes_.locks(), servos = meshes_.servos()]() mutable -> Result<Checked> {
        auto mesh = checkMesh(std::move(snapshot), std::move(volume), lock, servos);
        if (!mesh) return mesh.error();
        return Checked{std::move(*mesh), std::move(kept)};
      },
      [this, id, cached, bytes, keep, info = std::move(info)](Upload& back, Result<Checked> checked) mutable {
        if (!checked && cached && checked.error().code == ErrorCode::kBadSnapshot) {
          log::warn("a cached volume is built again: {}", toString(checked.error()));
          cache_->drop(back.cache_key);
          back.counts = back.file.size();
          return build(id);
        }
        if (!checked) return fail(id, checked.error());
        back.counts = 0;
        auto made = adopt(*checked, std::move(info), bytes);
        if (!made) {
          back.counts = bytes;
          return fail(id, made.error(), std::move(*checked));
        }
        const Upload over = take(id);
        CachedBuild& kept = checked->kept;
        over.done(std::move(made));
        if (keep) cache_->keep(over.cache_key, std::move(kept.snapshot), std::move(kept.volume), kept.notes);
      });
}

Result<MeshInfo> Uploads::adopt(Checked& checked, MeshInfo info, std::uint64_t bytes) {
  if (auto r = quota_(info.owner.uid, bytes, info.triangles); !r) return r.error();
  if (auto r = meshes_.room(info.owner); !r) return r.error();
  const auto id = meshes_.add(std::move(checked.mesh), std::move(info));
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
  if (!job) return fail(id, job.error());
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
