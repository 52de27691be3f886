/** @file
 * The capabilities of the control schema over a Core. Each ends what it stands for when its client drops it.
 */
#pragma once

#include <kj/async.h>

#include "daemon/resource/resource_tree.h"
#include "daemon/rpc/answer.h"

namespace hapticd {

/** A descriptor on its way to a client. It counts against its user until the client drops it. */
class RegionServer final : public proto::Region::Server {
 public:
  RegionServer(Core& core, std::uint32_t uid, UniqueFd fd) : core_(core), uid_(uid), fd_(std::move(fd)) {}
  ~RegionServer() {
    if (!counts_) return;
    core_.uploads().close(std::move(fd_), [&core = core_, uid = uid_] { core.clients().regionDropped(uid); });
  }
  RegionServer(const RegionServer&) = delete;
  RegionServer& operator=(const RegionServer&) = delete;
  kj::Maybe<int> getFd() override { return fd_.get(); }

  /** One more for that user, or why not. */
  [[nodiscard]] static Result<proto::Region::Client> handOut(Core& core, std::uint32_t uid, Result<UniqueFd> fd) {
    if (!fd) return fd.error();
    auto region = kj::heap<RegionServer>(core, uid, std::move(*fd));  // First: from then on it counts for itself.
    if (auto r = core.clients().regionHandedOut(uid); !r) return r.error();
    region->counts_ = true;
    return proto::Region::Client(kj::mv(region));
  }

 private:
  Core& core_;
  std::uint32_t uid_;
  UniqueFd fd_;
  bool counts_ = false;
};

class SessionServer final : public proto::Session::Server {
 public:
  SessionServer(Core& core, std::uint64_t id) : core_(core), id_(id) {}
  ~SessionServer() { core_.sessions().end(id_, "the client has dropped it"); }
  SessionServer(const SessionServer&) = delete;
  SessionServer& operator=(const SessionServer&) = delete;

 protected:
  kj::Promise<void> regions(RegionsContext context) override;
  kj::Promise<void> mapped(MappedContext context) override;
  kj::Promise<void> acquireLease(AcquireLeaseContext context) override;
  kj::Promise<void> releaseLease(ReleaseLeaseContext context) override;
  kj::Promise<void> arm(ArmContext context) override;
  kj::Promise<void> disarm(DisarmContext context) override;

 private:
  Core& core_;
  std::uint64_t id_;
};

/** A recording under way, for its user. */
class RecordingServer final : public proto::Recording::Server {
 public:
  RecordingServer(Core& core, std::uint32_t uid) : core_(core), uid_(uid) {}
  /** From here on the recording ends with this, if not before. */
  void hold(Recordings::Started started) noexcept {
    id_ = started.id;
    stream_ = std::move(started.stream);
  }
  ~RecordingServer() { core_.recordings().drop(id_); }
  RecordingServer(const RecordingServer&) = delete;
  RecordingServer& operator=(const RecordingServer&) = delete;

 protected:
  kj::Promise<void> stream(StreamContext context) override;
  kj::Promise<void> stop(StopContext context) override;

 private:
  Core& core_;
  std::uint64_t id_ = 0;
  UniqueFd stream_;
  std::uint32_t uid_;
};

class UploadServer final : public proto::Upload::Server {
 public:
  UploadServer(Core& core, std::uint32_t uid) : core_(core), uid_(uid) {}
  /** From here on the upload ends with this, if not before. */
  void hold(std::uint64_t id) noexcept { id_ = id; }
  ~UploadServer() { core_.uploads().cancel(id_); }
  UploadServer(const UploadServer&) = delete;
  UploadServer& operator=(const UploadServer&) = delete;

 protected:
  kj::Promise<void> region(RegionContext context) override;
  kj::Promise<void> commit(CommitContext context) override;
  kj::Promise<void> commitTexture(CommitTextureContext context) override;

 private:
  Core& core_;
  std::uint64_t id_ = 0;
  std::uint32_t uid_;
};

class SceneServer final : public proto::Scene::Server {
 public:
  SceneServer(Core& core, std::uint64_t connection) : core_(core), connection_(connection) {}

 protected:
  kj::Promise<void> create(CreateContext context) override;
  kj::Promise<void> remove(RemoveContext context) override;
  kj::Promise<void> list(ListContext context) override;
  kj::Promise<void> find(FindContext context) override;
  kj::Promise<void> setPose(SetPoseContext context) override;
  kj::Promise<void> setMaterial(SetMaterialContext context) override;
  kj::Promise<void> setFlags(SetFlagsContext context) override;
  kj::Promise<void> setShape(SetShapeContext context) override;
  kj::Promise<void> beginUpload(BeginUploadContext context) override;
  kj::Promise<void> dropMesh(DropMeshContext context) override;
  kj::Promise<void> listMeshes(ListMeshesContext context) override;
  kj::Promise<void> setSurface(SetSurfaceContext context) override;
  kj::Promise<void> dropTexture(DropTextureContext context) override;
  kj::Promise<void> listTextures(ListTexturesContext context) override;
  kj::Promise<void> volumeFile(VolumeFileContext context) override;

 private:
  Core& core_;
  std::uint64_t connection_;
};

/** Calls the listener with what happened, one call in flight at a time. */
class SubscriptionServer final : public proto::Subscription::Server, private kj::TaskSet::ErrorHandler {
 public:
  SubscriptionServer(Core& core, const Clients::Subscriber& by, proto::EventListener::Client listener,
                     std::uint32_t kinds);
  ~SubscriptionServer() {
    core_.events().unsubscribe(id_);
    core_.clients().subscriptionDropped(by_);
  }
  SubscriptionServer(const SubscriptionServer&) = delete;
  SubscriptionServer& operator=(const SubscriptionServer&) = delete;

 private:
  void wake();
  kj::Promise<void> pump();
  void taskFailed(kj::Exception&& exception) override;

  Core& core_;
  Clients::Subscriber by_;
  proto::EventListener::Client listener_;
  bool pumping_ = false;
  kj::TaskSet tasks_;
  std::uint64_t id_;  // Last: nothing may fail once the hub knows of it.
};

/** What a connection gets first. */
class DaemonServer : public proto::Daemon::Server {
 public:
  DaemonServer(Core& core, std::uint64_t connection) : core_(core), connection_(connection) {}
  virtual ~DaemonServer() noexcept(false) = default;

 protected:
  kj::Promise<void> hello(HelloContext context) override;
  kj::Promise<void> listDevices(ListDevicesContext context) override;
  kj::Promise<void> openDevice(OpenDeviceContext context) override;
  kj::Promise<void> closeDevice(CloseDeviceContext context) override;
  kj::Promise<void> openSession(OpenSessionContext context) override;
  kj::Promise<void> scene(SceneContext context) override;
  kj::Promise<void> get(GetContext context) override;
  kj::Promise<void> set(SetContext context) override;
  kj::Promise<void> state(StateContext context) override;
  kj::Promise<void> statistics(StatisticsContext context) override;
  kj::Promise<void> subscribe(SubscribeContext context) override;
  kj::Promise<void> stop(StopContext context) override;
  kj::Promise<void> setLimits(SetLimitsContext context) override;
  kj::Promise<void> configuration(ConfigurationContext context) override;
  kj::Promise<void> doctor(DoctorContext context) override;
  kj::Promise<void> dump(DumpContext context) override;
  kj::Promise<void> record(RecordContext context) override;

 private:
  [[nodiscard]] const Client& client() const { return core_.client(connection_); }

  Core& core_;
  std::uint64_t connection_;
  kj::Maybe<proto::Scene::Client> scene_;  ///< Once it has been asked for.
};

}  // namespace hapticd
