#include "tests/unit/libclient/fake_daemon.h"

#include <capnp/rpc-twoparty.h>
#include <fcntl.h>
#include <kj/async-io.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <future>
#include <mutex>
#include <thread>

#include "proto/control.capnp.h"
#include "proto/snapshot.h"
#include "rt/ring/state.h"

namespace hapticd::test {
namespace {

class Memory {
 public:
  explicit Memory(std::size_t bytes) : bytes_(bytes), fd_(memfd_create("fake", MFD_CLOEXEC)) {
    if (ftruncate(fd_, static_cast<off_t>(bytes)) != 0) std::abort();
    address_ = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, fd_, 0);
  }
  ~Memory() {
    munmap(address_, bytes_);
    close(fd_);
  }
  [[nodiscard]] int fd() const { return fd_; }
  [[nodiscard]] void* address() const { return address_; }
  [[nodiscard]] std::size_t bytes() const { return bytes_; }

 private:
  std::size_t bytes_;
  int fd_;
  void* address_;
};

class RegionServer final : public proto::Region::Server {
 public:
  explicit RegionServer(int fd) : fd_(fd) {}
  kj::Maybe<int> getFd() override { return fd_; }

 private:
  int fd_;
};

template <class Status>
void refuse(Status status, std::uint16_t code, const char* where, const char* what, const char* remedy) {
  status.setCode(code);
  status.setWhere(where);
  status.setWhat(what);
  status.setRemedy(remedy);
}

}  // namespace

/** All but `script`, `seen` and the regions belongs to the serving thread. */
struct FakeDaemon::Inside {
  std::mutex mutex;
  Script script;
  Seen seen;
  std::shared_ptr<Memory> a, b;
  std::vector<proto::EventListener::Client*> listeners;

  std::thread thread;
  kj::Own<const kj::Executor> executor;
  kj::PromiseFulfillerPair<void>* stop = nullptr;

  void note(const char* call) {
    const std::lock_guard lock(mutex);
    seen.calls.emplace_back(call);
  }
  Script now() {
    const std::lock_guard lock(mutex);
    return script;
  }
};

namespace {

using Inside = FakeDaemon::Inside;

class SessionServer final : public proto::Session::Server {
 public:
  explicit SessionServer(Inside& inside) : inside_(inside) {
    const std::lock_guard lock(inside_.mutex);
    inside_.a = a_ = std::make_shared<Memory>(sizeof(hd_region_a));
    inside_.b = b_ = std::make_shared<Memory>(sizeof(hd_region_b));
    auto* a = static_cast<hd_region_a*>(a_->address());
    auto* b = static_cast<hd_region_b*>(b_->address());
    initialiseRegions(a, b, {inside_.script.epoch, 7, 1, 1'000'000});
    a->header.major = inside_.script.layout_major;
    ++inside_.seen.open_sessions;
  }
  ~SessionServer() noexcept {
    const std::lock_guard lock(inside_.mutex);
    --inside_.seen.open_sessions;
  }
  kj::Promise<void> regions(RegionsContext context) override {
    inside_.note("regions");
    context.getResults().setA(kj::heap<RegionServer>(a_->fd()));
    context.getResults().setB(kj::heap<RegionServer>(b_->fd()));
    return kj::READY_NOW;
  }
  kj::Promise<void> mapped(MappedContext) override { return noted("mapped"); }
  kj::Promise<void> acquireLease(AcquireLeaseContext) override { return noted("acquireLease"); }
  kj::Promise<void> releaseLease(ReleaseLeaseContext) override { return noted("releaseLease"); }
  kj::Promise<void> arm(ArmContext context) override {
    inside_.note("arm");
    if (inside_.now().dawdle) return kj::NEVER_DONE;
    if (const auto code = inside_.now().refuse_arm; code != 0) {
      refuse(context.getResults().initStatus(), code, "sim", "a fault is latched", "close the stop line");
    }
    return kj::READY_NOW;
  }
  kj::Promise<void> disarm(DisarmContext) override { return noted("disarm"); }

 private:
  kj::Promise<void> noted(const char* call) {
    inside_.note(call);
    return kj::READY_NOW;
  }

  Inside& inside_;
  std::shared_ptr<Memory> a_, b_;
};

class UploadServer final : public proto::Upload::Server {
 public:
  UploadServer(Inside& inside, std::size_t bytes) : inside_(inside), memory_(bytes) {}
  ~UploadServer() noexcept {
    const std::lock_guard lock(inside_.mutex);
    if (!committed_) ++inside_.seen.cancelled_uploads;
  }
  kj::Promise<void> region(RegionContext context) override {
    context.getResults().setRegion(kj::heap<RegionServer>(memory_.fd()));
    return kj::READY_NOW;
  }
  kj::Promise<void> commit(CommitContext context) override {
    inside_.note("commit");
    context.allowCancellation();
    const Script script = inside_.now();
    kj::Promise<void> told = kj::READY_NOW;
    for (const float fraction : script.progress) {
      auto request = context.getParams().getProgress().reportRequest();
      request.setFraction(fraction);
      request.setStage("tree");
      told = told.then([request = kj::mv(request)]() mutable { return request.send(); });
    }
    if (script.never_build) return told.then([]() -> kj::Promise<void> { return kj::NEVER_DONE; });
    return told.then([this, context, script]() mutable { finish(context.getResults(), script); });
  }

 private:
  void finish(proto::Upload::CommitResults::Builder results, const Script& script) {
    if (script.still_mapped > 0) {
      const std::lock_guard lock(inside_.mutex);
      --inside_.script.still_mapped;
      return refuse(results.initStatus(), kStillMapped, "upload", "still mapped", "unmap it");
    }
    if (!script.bad_mesh.empty()) {
      return refuse(results.initStatus(), kBadMesh, script.bad_mesh.c_str(), "index out of range", "fix it");
    }
    const auto* bytes = static_cast<const std::byte*>(memory_.address());
    hd_mesh_upload header;
    std::memcpy(&header, bytes, sizeof header);
    auto mesh = results.initMesh();
    mesh.setId(42);
    mesh.setVertices(header.vertex_count);
    mesh.setTriangles(header.triangle_count);
    mesh.setClosed(true);
    auto notes = mesh.initNotes(1);
    notes.set(0, "triangle 3 turned");
    const std::lock_guard lock(inside_.mutex);
    inside_.seen.upload.assign(bytes, bytes + memory_.bytes());
    committed_ = true;
  }

  static constexpr std::uint16_t kStillMapped = 13, kBadMesh = 14;
  Inside& inside_;
  Memory memory_;
  bool committed_ = false;
};

class SceneServer final : public proto::Scene::Server {
 public:
  explicit SceneServer(Inside& inside) : inside_(inside) {}
  kj::Promise<void> create(CreateContext context) override {
    const auto object = context.getParams().getObject();
    inside_.note(("create " + std::string(object.getName().cStr())).c_str());
    if (object.getName() == "taken") {
      refuse(context.getResults().initStatus(), 3, "taken", "exists", "choose another name");
    } else {
      context.getResults().setId(65537);
    }
    return kj::READY_NOW;
  }
  kj::Promise<void> find(FindContext context) override {
    auto object = context.getResults().initObject();
    object.initSpec().setName(context.getParams().getName());
    object.getSpec().getMaterial().setStiffness(123);
    object.setId(65537);
    object.setPath("/_objects/it");
    return kj::READY_NOW;
  }
  kj::Promise<void> beginUpload(BeginUploadContext context) override {
    context.getResults().setUpload(kj::heap<UploadServer>(inside_, context.getParams().getBytes()));
    return kj::READY_NOW;
  }
  /** Of the object "solid" alone: a file that holds its name. */
  kj::Promise<void> volumeFile(VolumeFileContext context) override {
    if (context.getParams().getName() == "solid") {
      std::memcpy(file_.address(), "solid", 5);
      context.getResults().setFile(kj::heap<RegionServer>(file_.fd()));
    } else {
      refuse(context.getResults().initStatus(), 17, "hollow", "it is being made", "ask again");
    }
    return kj::READY_NOW;
  }

 private:
  Inside& inside_;
  Memory file_{5};
};

class SubscriptionServer final : public proto::Subscription::Server {
 public:
  SubscriptionServer(Inside& inside, proto::EventListener::Client listener)
      : inside_(inside), listener_(kj::mv(listener)) {
    inside_.listeners.push_back(&listener_);
    const std::lock_guard lock(inside_.mutex);
    ++inside_.seen.subscriptions;
  }
  ~SubscriptionServer() noexcept {
    std::erase(inside_.listeners, &listener_);
    const std::lock_guard lock(inside_.mutex);
    --inside_.seen.subscriptions;
  }

 private:
  Inside& inside_;
  proto::EventListener::Client listener_;
};

class DaemonServer final : public proto::Daemon::Server {
 public:
  explicit DaemonServer(Inside& inside) : inside_(inside) {}
  kj::Promise<void> hello(HelloContext context) override {
    const Script script = inside_.now();
    auto info = context.getResults().initInfo();
    info.setVersion("9.9");
    info.setProtocolMajor(script.protocol_major);
    info.setEpoch(script.epoch);
    info.setAdministration(script.administration);
    info.setPid(getpid());
    const std::lock_guard lock(inside_.mutex);
    inside_.seen.client_name = context.getParams().getClientName().cStr();
    return kj::READY_NOW;
  }
  kj::Promise<void> listDevices(ListDevicesContext context) override {
    if (inside_.now().dawdle) return kj::NEVER_DONE;
    auto devices = context.getResults().initDevices(2);
    devices[0].setUri("sim://one");
    devices[0].setOpen(true);
    devices[0].setMaxForce(8);
    devices[0].setSensedPosition(true);
    devices[0].setHasDeadman(true);
    devices[0].initWorkspaceUpper().setZ(0.1);
    devices[1].setUri("sim://two");
    return kj::READY_NOW;
  }
  kj::Promise<void> openSession(OpenSessionContext context) override {
    auto results = context.getResults();
    const std::string asked = context.getParams().getUri().cStr();
    if (asked == "sim://none") {
      refuse(results.initStatus(), 2, "sim://none", "no such device", "see hapticctl list");
      return kj::READY_NOW;
    }
    results.setSession(kj::heap<SessionServer>(inside_));
    auto info = results.initInfo();
    info.setId(7);
    info.setEpoch(inside_.now().epoch);
    info.initDevice().setUri(asked.find("://") == std::string::npos ? inside_.now().device : asked);
    info.setDeviceCount(1);
    info.setPeriodNs(1'000'000);
    info.setRegionABytes(sizeof(hd_region_a));
    info.setRegionBBytes(sizeof(hd_region_b));
    return kj::READY_NOW;
  }
  kj::Promise<void> scene(SceneContext context) override {
    context.getResults().setScene(kj::heap<SceneServer>(inside_));
    return kj::READY_NOW;
  }
  kj::Promise<void> get(GetContext context) override {
    context.getResults().setJson(kj::str("{\"path\": \"", context.getParams().getPath(), "\"}"));
    return kj::READY_NOW;
  }
  kj::Promise<void> statistics(StatisticsContext context) override {
    auto out = context.getResults().initStatistics();
    out.setMissed(5);
    out.setCollideQueries(700);
    out.setCollideExhausted(20);
    out.setCollideUnsent(3);
    return kj::READY_NOW;
  }
  kj::Promise<void> subscribe(SubscribeContext context) override {
    {
      const std::lock_guard lock(inside_.mutex);
      inside_.seen.kinds = context.getParams().getKinds();
    }
    if (const auto code = inside_.now().refuse_subscribe; code != 0) {
      refuse(context.getResults().initStatus(), code, "subscribe", "there are too many", "drop some");
      return kj::READY_NOW;
    }
    context.getResults().setSubscription(kj::heap<SubscriptionServer>(inside_, context.getParams().getListener()));
    return kj::READY_NOW;
  }

 private:
  Inside& inside_;
};

int listenAt(const std::string& path) {
  const int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof address.sun_path - 1);
  unlink(path.c_str());
  if (bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 || listen(fd, 8) != 0) std::abort();
  return fd;
}

void serve(Inside& inside, int listener, std::promise<void>& ready) {
  sigset_t pipe;  // a test may have given SIGPIPE its default back
  sigemptyset(&pipe);
  sigaddset(&pipe, SIGPIPE);
  pthread_sigmask(SIG_BLOCK, &pipe, nullptr);
  auto io = kj::setupAsyncIo();
  auto stop = kj::newPromiseAndFulfiller<void>();
  capnp::TwoPartyServer server(kj::heap<DaemonServer>(inside));
  auto receiver = io.lowLevelProvider->wrapListenSocketFd(listener, kj::LowLevelAsyncIoProvider::TAKE_OWNERSHIP);
  auto listening = server.listenCapStreamReceiver(*receiver, 4).eagerlyEvaluate(nullptr);
  inside.stop = &stop;
  inside.executor = kj::getCurrentThreadExecutor().addRef();
  ready.set_value();
  stop.promise.wait(io.waitScope);
}

}  // namespace

FakeDaemon::FakeDaemon(std::string path, Script script) : path_(std::move(path)), inside_(std::make_unique<Inside>()) {
  inside_->script = std::move(script);
  std::promise<void> ready;
  auto started = ready.get_future();
  const int listener = listenAt(path_);
  inside_->thread = std::thread([this, listener, &ready] { serve(*inside_, listener, ready); });
  started.get();
}

FakeDaemon::~FakeDaemon() {
  inside_->executor->executeSync([this] { inside_->stop->fulfiller->fulfill(); });
  inside_->thread.join();
  unlink(path_.c_str());
}

Seen FakeDaemon::seen() {
  const std::lock_guard lock(inside_->mutex);
  return inside_->seen;
}

void FakeDaemon::script(const std::function<void(Script&)>& change) {
  const std::lock_guard lock(inside_->mutex);
  change(inside_->script);
}

hd_region_a* FakeDaemon::regionA() {
  const std::lock_guard lock(inside_->mutex);
  return inside_->a == nullptr ? nullptr : static_cast<hd_region_a*>(inside_->a->address());
}

hd_region_b* FakeDaemon::regionB() {
  const std::lock_guard lock(inside_->mutex);
  return inside_->b == nullptr ? nullptr : static_cast<hd_region_b*>(inside_->b->address());
}

void FakeDaemon::send(const std::vector<std::uint32_t>& values, std::uint64_t lost) {
  inside_->executor->executeSync([&]() -> kj::Promise<void> {
    kj::Vector<kj::Promise<void>> sent;
    for (auto* listener : inside_->listeners) {
      auto request = listener->eventsRequest();
      request.setLost(lost);
      auto events = request.initEvents(static_cast<unsigned>(values.size()));
      for (unsigned i = 0; i < values.size(); ++i) {
        events[i].setKind(proto::EventKind::BUTTON);
        events[i].setValue(values[i]);
        events[i].setDevice("sim");
      }
      sent.add(request.send().ignoreResult());
    }
    return kj::joinPromises(sent.releaseAsArray());
  });
}

}  // namespace hapticd::test
