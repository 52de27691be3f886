// scene.h: meshes on their way to the builder.
#include <chrono>
#include <condition_variable>
#include <cstring>

#include "libclient/src/connection/loop.h"
#include "libclient/src/connection/patience.h"
#include "libclient/src/reply/convert.h"
#include "libclient/src/session/mapping.h"
#include "libclient/src/upload/upload_region.h"
#include "proto/snapshot.h"
#include "proto/volume.h"

using hapticd::client::Connection;
using hapticd::client::Failure;
using hapticd::client::Mapping;
using hapticd::client::Reply;
namespace client = hapticd::client;
namespace proto = hapticd::proto;

namespace {

constexpr std::int64_t kDefaultPatienceNs = 600'000'000'000;

/** What the library's thread tells the one that waits for the builder. */
struct Waiting {
  std::mutex mutex;
  std::condition_variable changed;
  bool news = false;
  float fraction = 0;
  std::string stage = "waiting";  ///< As long as the builder has said nothing.
  bool done = false;
  Failure failure;
  Reply memory;
  haptic_mesh_report* report = nullptr;

  void finish(Failure how) {
    const std::lock_guard lock(mutex);
    failure = std::move(how);
    done = true;
    changed.notify_all();
  }
};

class ProgressServer final : public proto::Progress::Server {
 public:
  explicit ProgressServer(std::shared_ptr<Waiting> waiting) : waiting_(std::move(waiting)) {}
  kj::Promise<void> report(ReportContext context) override {
    const auto params = context.getParams();
    const std::lock_guard lock(waiting_->mutex);
    waiting_->fraction = params.getFraction();
    waiting_->stage = params.getStage().cStr();
    waiting_->news = true;
    waiting_->changed.notify_all();
    return kj::READY_NOW;
  }

 private:
  std::shared_ptr<Waiting> waiting_;
};

/** Where the request for a volume stands, if there is one. */
std::size_t meshBytes(std::uint32_t vertices, std::uint32_t triangles) {
  return sizeof(hd_mesh_upload) + 12 * (std::size_t{vertices} + triangles);
}

}  // namespace

/** The handle of scene.h. */
struct haptic_upload {
  std::shared_ptr<Connection> connection;
  std::uint64_t link = 0;  ///< Over which it was begun.
  std::uint32_t vertices = 0;
  Mapping mapping;
  bool given_up = false;                       ///< Cancelled, or not waited for to the end.
  proto::Upload::Client capability = nullptr;  ///< Library's thread.
  kj::Promise<void> commit = nullptr;          ///< Library's thread.

  ~haptic_upload() {
    connection->run([this](Connection::Loop&) {
      commit = nullptr;
      capability = nullptr;
    });
  }
};

namespace {

/** Why its arrays cannot be reached, if so: a child of fork() has them no more. */
Failure closed(const haptic_upload* upload) {
  if (upload == nullptr) return client::badArgument("upload", "is null");
  if (Failure failure = upload->connection->foreign()) return failure;
  if (upload->mapping.address() == nullptr) return client::badArgument("upload", "is committed already");
  return {};
}

Failure begin(haptic_client* c, std::uint32_t vertices, std::uint32_t triangles, std::uint32_t flags,
              std::unique_ptr<haptic_upload>& upload) {
  if (c == nullptr) return client::badArgument("client", "is null");
  if (vertices == 0 || vertices > HD_MAX_VERTICES) {
    return client::badArgument("vertices", "is " + std::to_string(vertices),
                               "give 1 to " + std::to_string(HD_MAX_VERTICES));
  }
  if (triangles == 0 || triangles > HD_MAX_TRIANGLES) {
    return client::badArgument("triangles", "is " + std::to_string(triangles),
                               "give 1 to " + std::to_string(HD_MAX_TRIANGLES));
  }
  if ((flags & ~std::uint32_t{HAPTIC_MESH_DEFORMABLE | HAPTIC_MESH_VOLUME | HAPTIC_MESH_FILL_HOLES}) != 0) {
    return client::badArgument("flags", "has bits that are not defined");
  }
  if ((flags & HAPTIC_MESH_FILL_HOLES) != 0 && (flags & HAPTIC_MESH_VOLUME) == 0) {
    return client::badArgument("flags", "has HAPTIC_MESH_FILL_HOLES alone", "add HAPTIC_MESH_VOLUME");
  }
  auto made = std::make_unique<haptic_upload>();
  made->connection = c->connection;
  made->link = c->connection->linkNumber();
  made->vertices = vertices;
  const std::size_t bytes =
      meshBytes(vertices, triangles) + ((flags & HAPTIC_MESH_VOLUME) != 0 ? sizeof(hd_volume_request) : 0);
  if (Failure failure = client::openUpload(*c->connection, bytes, made->capability, made->mapping)) return failure;
  *static_cast<hd_mesh_upload*>(made->mapping.address()) = {HD_UPLOAD_MAGIC, vertices, triangles, flags, 0};
  upload = std::move(made);
  return {};
}

/** Starts the commit on the library's thread; `waiting` hears how it ends. */
void startCommit(haptic_upload& upload, const std::shared_ptr<Waiting>& waiting) {
  upload.connection->run([&](Connection::Loop&) {
    auto request = upload.capability.commitRequest();
    request.setProgress(kj::heap<ProgressServer>(waiting));
    upload.commit = request.send()
                        .then(
                            [waiting](auto&& results) {
                              Failure failure = client::toFailure(results.getStatus());
                              if (!failure) waiting->report = client::convert(results.getMesh(), waiting->memory);
                              waiting->finish(std::move(failure));
                            },
                            [waiting](kj::Exception&& e) { waiting->finish(client::toFailure(e)); })
                        .eagerlyEvaluate([waiting](kj::Exception&& e) { waiting->finish(client::toFailure(e)); });
  });
}

/** Calls `progress` on this thread until the builder is done; gives why it went no further, if so. */
Failure waitForBuilder(Waiting& waiting, haptic_progress progress, void* user, std::int64_t patience) {
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::milliseconds kSilence{200};  // So soon it is asked again: a daemon that hangs tells nothing.
  const auto deadline = Clock::now() + std::chrono::nanoseconds(patience);
  std::unique_lock lock(waiting.mutex);
  for (;;) {
    const auto until = std::min(deadline, Clock::now() + kSilence);
    const bool told = waiting.changed.wait_until(lock, until, [&] { return waiting.done || waiting.news; });
    if (!told && until == deadline) {
      return {HAPTIC_TIMEOUT, "upload",
              "the builder was not done within " + std::to_string(patience / 1'000'000) + " ms", "give it more time"};
    }
    if (waiting.news || !told) {
      waiting.news = false;
      if (progress == nullptr) continue;
      const float fraction = waiting.fraction;
      const std::string stage = waiting.stage;
      lock.unlock();
      const bool stop = progress(fraction, stage.c_str(), user) != 0;
      lock.lock();
      if (stop && !waiting.done) return {HAPTIC_CANCELLED, "upload", "the progress callback asked to stop", {}};
      continue;  // there may be newer news, which comes before the end
    }
    if (waiting.done) return waiting.failure;
  }
}

Failure commit(haptic_upload& upload, haptic_progress progress, void* user, std::int64_t timeout_ns,
               haptic_mesh_report** report) {
  Connection& connection = *upload.connection;
  if (!connection.ownProcess() || !connection.connected()) {
    return {HAPTIC_DISCONNECTED, "upload", "the connection is gone", "call haptic_reconnect() and upload again"};
  }
  if (connection.onOwnThread()) return client::badArgument("thread", "a callback may not wait for the daemon");
  if (upload.link != connection.linkNumber()) return client::begunBefore("upload", "upload again");
  if (upload.given_up)
    return {HAPTIC_NOT_FOUND, "upload", "the upload is over", "begin another"};  // As the daemon says.
  upload.mapping.unmap();
  std::shared_ptr<Waiting> waiting;
  Failure failure = client::commitPatiently([&] {
    waiting = std::make_shared<Waiting>();
    startCommit(upload, waiting);
    return waitForBuilder(*waiting, progress, user, client::patience_ns(timeout_ns, kDefaultPatienceNs));
  });
  upload.given_up = failure.code == HAPTIC_CANCELLED || failure.code == HAPTIC_TIMEOUT;
  connection.run([&](Connection::Loop&) {
    upload.commit = nullptr;
    if (upload.given_up) upload.capability = nullptr;  // This is how a build is cancelled.
  });
  if (failure) return failure;
  if (report != nullptr) *report = waiting->memory.release(waiting->report);
  return {};
}

}  // namespace

extern "C" {

int haptic_upload_begin(haptic_client* c, uint32_t vertices, uint32_t triangles, uint32_t flags, haptic_upload** upload,
                        haptic_error* error) {
  return client::edge(error, [&]() -> Failure {
    if (upload == nullptr) return client::badArgument("upload", "is null");
    std::unique_ptr<haptic_upload> made;
    if (Failure failure = begin(c, vertices, triangles, flags, made)) return failure;
    *upload = made.release();
    return {};
  });
}

float* haptic_upload_vertices(haptic_upload* upload) {
  if (upload == nullptr || !upload->connection->ownProcess() || upload->mapping.address() == nullptr) return nullptr;
  return reinterpret_cast<float*>(static_cast<hd_mesh_upload*>(upload->mapping.address()) + 1);
}

uint32_t* haptic_upload_triangles(haptic_upload* upload) {
  float* vertices = haptic_upload_vertices(upload);
  return vertices == nullptr ? nullptr : reinterpret_cast<uint32_t*>(vertices + std::size_t{3} * upload->vertices);
}

int haptic_upload_weld(haptic_upload* upload, double distance_m, haptic_error* error) {
  return client::edge(error, [&]() -> Failure {
    if (Failure failure = closed(upload)) return failure;
    const auto distance = static_cast<float>(distance_m);
    if (distance_m != 0 && !(distance >= HD_MIN_WELD && distance <= HD_MAX_WELD)) {
      return client::badArgument("distance_m", "is " + client::textOf(distance_m), "give 0, or 1e-6 to 0.01 m");
    }
    static_cast<hd_mesh_upload*>(upload->mapping.address())->weld_m = distance;
    return {};
  });
}

int haptic_upload_volume(haptic_upload* upload, double voxel_m, double point_spacing_m, haptic_error* error) {
  return client::edge(error, [&]() -> Failure {
    if (Failure failure = closed(upload)) return failure;
    const hd_mesh_upload& head = *static_cast<hd_mesh_upload*>(upload->mapping.address());
    if ((head.flags & HAPTIC_MESH_VOLUME) == 0) {
      return client::badArgument("upload", "was begun without HAPTIC_MESH_VOLUME");
    }
    hd_volume_request request{};
    request.voxel_m = static_cast<float>(voxel_m);
    request.point_spacing_m = static_cast<float>(point_spacing_m);
    if (!(request.voxel_m >= HD_MIN_VOXEL && request.voxel_m <= HD_MAX_VOXEL)) {
      return client::badArgument("voxel_m", "is " + client::textOf(voxel_m), "give 1e-6 to 1 m");
    }
    if (!(request.point_spacing_m >= 0 && request.point_spacing_m <= HD_MAX_VOXEL)) {
      return client::badArgument("point_spacing_m", "is " + client::textOf(point_spacing_m), "give 0 to 1 m");
    }
    std::memcpy(static_cast<std::byte*>(upload->mapping.address()) + meshBytes(head.vertex_count, head.triangle_count),
                &request, sizeof request);
    return {};
  });
}

int haptic_upload_commit(haptic_upload* upload, haptic_progress progress, void* user, int64_t timeout_ns,
                         haptic_mesh_report** report, haptic_error* error) {
  return client::edge(error, [&]() -> Failure {
    if (upload == nullptr) return client::badArgument("upload", "is null");
    return commit(*upload, progress, user, timeout_ns, report);
  });
}

void haptic_upload_close(haptic_upload* upload) {
  if (upload != nullptr && upload->connection->ownProcess()) delete upload;
}

int haptic_upload_mesh(haptic_client* c, const float* vertices, uint32_t vertex_count, const uint32_t* triangles,
                       uint32_t triangle_count, uint32_t flags, haptic_progress progress, void* user,
                       haptic_mesh_report** report, haptic_error* error) {
  return client::edge(error, [&]() -> Failure {
    if (vertices == nullptr) return client::badArgument("vertices", "is null");
    if (triangles == nullptr) return client::badArgument("triangles", "is null");
    std::unique_ptr<haptic_upload> upload;
    if (Failure failure = begin(c, vertex_count, triangle_count, flags, upload)) return failure;
    std::memcpy(haptic_upload_vertices(upload.get()), vertices, std::size_t{12} * vertex_count);
    std::memcpy(haptic_upload_triangles(upload.get()), triangles, std::size_t{12} * triangle_count);
    return commit(*upload, progress, user, 0, report);
  });
}

}  // extern "C"
