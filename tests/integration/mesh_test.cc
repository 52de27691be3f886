// A mesh from the client's floats to the hand's touch, and what is refused on the way.
#include <cstring>

#include "daemon/scene/upload/uploads.h"
#include "tests/integration/raw_client.h"
#include "tests/integration/running_daemon.h"
#include "tests/support/shape/texture_upload.h"

namespace hapticd::test {
namespace {

/** A cube of half-side h, counter-clockwise seen from outside. */
std::vector<std::byte> cube(float h, std::uint32_t flags = 0) {
  const float v[8][3] = {{-h, -h, -h}, {h, -h, -h}, {h, h, -h}, {-h, h, -h},
                         {-h, -h, h},  {h, -h, h},  {h, h, h},  {-h, h, h}};
  const std::uint32_t t[12][3] = {{0, 2, 1}, {0, 3, 2}, {4, 5, 6}, {4, 6, 7}, {0, 1, 5}, {0, 5, 4},
                                  {1, 2, 6}, {1, 6, 5}, {2, 3, 7}, {2, 7, 6}, {3, 0, 4}, {3, 4, 7}};
  hd_mesh_upload header{};
  header.magic = HD_UPLOAD_MAGIC;
  header.vertex_count = 8;
  header.triangle_count = 12;
  header.flags = flags;
  std::vector<std::byte> bytes(sizeof header + sizeof v + sizeof t);
  std::memcpy(bytes.data(), &header, sizeof header);
  std::memcpy(bytes.data() + sizeof header, v, sizeof v);
  std::memcpy(bytes.data() + sizeof header + sizeof v, t, sizeof t);
  return bytes;
}

/** Counts what the builder says. */
class Progress final : public proto::Progress::Server {
 public:
  Progress(int& calls, float& last) : calls_(calls), last_(last) {}

 protected:
  kj::Promise<void> report(ReportContext context) override {
    ++calls_;
    last_ = context.getParams().getFraction();
    return kj::READY_NOW;
  }

 private:
  int& calls_;
  float& last_;
};

/** Hears events. */
class Listener final : public proto::EventListener::Server {
 public:
  explicit Listener(std::vector<std::string>& heard) : heard_(heard) {}

 protected:
  kj::Promise<void> events(EventsContext context) override {
    static const char* const kNames[] = {"touch",       "untouch",       "button",        "fault",
                                         "armed",       "disarmed",      "leaseLost",     "leaseTaken",
                                         "deviceAdded", "deviceRemoved", "overrun",       "clientJoined",
                                         "clientLeft",  "modelExpired",  "objectChanged", "refused"};
    for (auto event : context.getParams().getEvents()) {
      heard_.push_back(std::string(kNames[static_cast<int>(event.getKind())]) + ":" + event.getDevice().cStr() + ":" +
                       event.getObject().cStr());
    }
    return kj::READY_NOW;
  }

 private:
  std::vector<std::string>& heard_;
};

class MeshJourney : public ::testing::Test {
 protected:
  ~MeshJourney() noexcept override {}  // kj's destructors may throw; a fixture's may not
  static Config tapping() {
    Config config = RunningDaemon::simulated();
    config.groups[0].devices = {"sim://default?motion=tap&centre=0,0,0.05&depth=0.05&period=0.4"};
    config.quotas.triangles = 36;
    return config;
  }
  RunningDaemon daemon{tapping()};
  Loop loop;
  RawClient client{loop, daemon.control()};
  proto::Scene::Client scene = loop.call(client.daemon.sceneRequest()).getScene();

  ErrorCode begin(std::uint64_t bytes) {
    auto request = scene.beginUploadRequest();
    request.setBytes(bytes);
    return code(loop.call(kj::mv(request)).getStatus());
  }
  /** Uploads and commits; the answer of the commit. */
  capnp::Response<proto::Upload::CommitResults> upload(const std::vector<std::byte>& bytes, bool keep_mapped = false) {
    auto request = scene.beginUploadRequest();
    request.setBytes(bytes.size());
    auto begun = loop.call(kj::mv(request));
    EXPECT_TRUE(good(begun.getStatus()));
    auto up = begun.getUpload();
    auto region = loop.call(up.regionRequest());
    EXPECT_TRUE(good(region.getStatus()));
    auto fd = region.getRegion().getFd().wait(loop.io.waitScope);
    int number = -1;
    KJ_IF_MAYBE (n, fd) {
      number = *n;
    }
    void* memory = mmap(nullptr, bytes.size(), PROT_READ | PROT_WRITE, MAP_SHARED, number, 0);
    EXPECT_NE(memory, MAP_FAILED);
    std::memcpy(memory, bytes.data(), bytes.size());
    if (keep_mapped) {
      EXPECT_EQ(code(loop.call(up.commitRequest()).getStatus()), ErrorCode::kStillMapped);
    }
    munmap(memory, bytes.size());
    auto commit = up.commitRequest();
    commit.setProgress(kj::heap<Progress>(progress_calls, progress));
    return loop.call(kj::mv(commit));
  }
  ErrorCode show(const char* name, std::uint64_t mesh) {
    auto request = scene.createRequest();
    auto object = request.initObject();
    object.setName(name);
    object.initShape().setKind(proto::ShapeKind::MESH);
    object.getShape().setMesh(mesh);
    return code(loop.call(kj::mv(request)).getStatus());
  }
  ErrorCode drop(std::uint64_t mesh) {
    auto request = scene.dropMeshRequest();
    request.setMesh(mesh);
    return code(loop.call(kj::mv(request)).getStatus());
  }
  int progress_calls = 0;
  float progress = 0;
};

TEST_F(MeshJourney, FromFloatsToTouch) {
  std::vector<std::string> heard;
  auto subscribe = client.daemon.subscribeRequest();
  subscribe.setListener(kj::heap<Listener>(heard));
  auto subscription = loop.call(kj::mv(subscribe));
  ASSERT_TRUE(good(subscription.getStatus()));

  auto built = upload(cube(0.02f), true);
  ASSERT_TRUE(good(built.getStatus()));
  EXPECT_EQ(built.getMesh().getTriangles(), 12u);
  EXPECT_EQ(built.getMesh().getVertices(), 8u);
  EXPECT_TRUE(built.getMesh().getClosed());
  EXPECT_NEAR(built.getMesh().getUpper().getZ(), 0.02, 1e-7);
  EXPECT_GT(progress_calls, 0);
  const std::uint64_t mesh = built.getMesh().getId();
  ASSERT_EQ(show("cube", mesh), ErrorCode::kOk);
  const auto has = [&](const std::string& what) { return std::find(heard.begin(), heard.end(), what) != heard.end(); };
  EXPECT_TRUE(loop.until([&] { return has("touch:sim:cube") && has("untouch:sim:cube"); }));
  EXPECT_TRUE(has("objectChanged::cube"));

  EXPECT_EQ(drop(mesh), ErrorCode::kInvalidArgument) << "an object shows it";
  auto remove = scene.removeRequest();
  remove.setName("cube");
  ASSERT_TRUE(good(loop.call(kj::mv(remove)).getStatus()));
  EXPECT_EQ(drop(mesh), ErrorCode::kOk);
  EXPECT_EQ(drop(mesh), ErrorCode::kNotFound);
  EXPECT_TRUE(loop.until([&] {
    auto state = loop.call(client.daemon.stateRequest());
    return state.getState().getMeshes() == 0;
  }));
}

TEST_F(MeshJourney, AMeshGoesWithItsMakerOnceNothingShowsIt) {
  auto built = upload(cube(0.02f, HD_MESH_DEFORMABLE));
  ASSERT_TRUE(good(built.getStatus()));
  EXPECT_TRUE(built.getMesh().getDeformable());
  RawClient other{loop, daemon.control()};
  auto meshes = [&] {
    auto list = loop.call(loop.call(other.daemon.sceneRequest()).getScene().listMeshesRequest());
    return list.getMeshes().size();
  };
  EXPECT_EQ(meshes(), 1u);
  RawClient second{loop, daemon.control()};
  scene = loop.call(second.daemon.sceneRequest()).getScene();
  ASSERT_TRUE(good(upload(cube(0.01f)).getStatus()));
  EXPECT_EQ(meshes(), 2u);
  scene = loop.call(client.daemon.sceneRequest()).getScene();
  {
    RawClient third{loop, daemon.control()};
    auto theirs = loop.call(third.daemon.sceneRequest()).getScene();
    std::swap(theirs, scene);
    ASSERT_TRUE(good(upload(cube(0.03f)).getStatus()));
    EXPECT_EQ(meshes(), 3u);
    std::swap(theirs, scene);
  }
  EXPECT_TRUE(loop.until([&] { return meshes() == 2; }));
}

TEST_F(MeshJourney, TrianglesBeyondTheQuotaAreRefused) {
  auto first = upload(cube(0.02f));
  ASSERT_TRUE(good(first.getStatus()));
  const auto second = upload(cube(0.02f)), third = upload(cube(0.02f));
  EXPECT_TRUE(good(third.getStatus())) << "as many as are allowed";
  const auto refused = upload(cube(0.02f));
  EXPECT_EQ(code(refused.getStatus()), ErrorCode::kQuotaExceeded);
  EXPECT_EQ(std::string(refused.getStatus().getWhere().cStr()), "triangles");
  EXPECT_EQ(drop(first.getMesh().getId()), ErrorCode::kOk);
  EXPECT_TRUE(good(upload(cube(0.02f)).getStatus()));
}

TEST_F(MeshJourney, BadMeshesAreRefusedWithTheTriangle) {
  auto bytes = cube(0.02f);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::memcpy(bytes.data() + sizeof(hd_mesh_upload), &nan, sizeof nan);
  auto refused = upload(bytes);
  EXPECT_EQ(code(refused.getStatus()), ErrorCode::kBadMesh);
  bytes = cube(0.02f);
  const std::uint32_t wild = 99;
  std::memcpy(bytes.data() + bytes.size() - 4, &wild, sizeof wild);
  refused = upload(bytes);
  EXPECT_EQ(code(refused.getStatus()), ErrorCode::kBadMesh);
  EXPECT_NE(std::string(refused.getStatus().getWhere().cStr()).find("11"), std::string::npos);
  EXPECT_EQ(code(upload(std::vector<std::byte>(500)).getStatus()), ErrorCode::kBadMesh) << "no magic";
  EXPECT_EQ(begin(0), ErrorCode::kInvalidArgument);
  EXPECT_EQ(begin(UINT64_MAX), ErrorCode::kInvalidArgument);
  EXPECT_EQ(begin(300'000'000), ErrorCode::kQuotaExceeded) << "more than quotas.memory_mb";
  EXPECT_EQ(show("x", 4711), ErrorCode::kNotFound);
}

TEST_F(MeshJourney, OneUploadIsCommittedOnceAndCancelledByDropping) {
  auto request = scene.beginUploadRequest();
  request.setBytes(1000);
  auto begun = loop.call(kj::mv(request));
  {
    auto up = begun.getUpload();
    auto first = up.commitRequest().send();
    auto second = loop.call(up.commitRequest());
    EXPECT_EQ(code(second.getStatus()), ErrorCode::kAlreadyExists);
    EXPECT_EQ(code(first.wait(loop.io.waitScope).getStatus()), ErrorCode::kBadMesh);
    EXPECT_EQ(code(loop.call(up.regionRequest()).getStatus()), ErrorCode::kNotFound);
  }
  // A build under way is forgotten when its upload is dropped; the daemon goes on.
  for (int i = 0; i < 5; ++i) {
    auto again = scene.beginUploadRequest();
    again.setBytes(1000);
    auto dropped = loop.call(kj::mv(again)).getUpload().commitRequest().send();
    (void)dropped;
  }
  EXPECT_TRUE(good(upload(cube(0.01f)).getStatus()));
}

/** Whatever the thread that checks it is at. */
TEST_F(MeshJourney, WhoLeavesWhileATextureIsCheckedLeavesNothing) {
  constexpr std::uint32_t kSide = 1024;
  const auto bytes = reliefUpload(kSide, kSide, std::vector<std::uint16_t>(std::size_t{kSide} * kSide));
  for (int round = 0; round < 40; ++round) {  // More than a user may have under way.
    RawClient leaver{loop, daemon.control()};
    auto theirs = loop.call(leaver.daemon.sceneRequest()).getScene();
    proto::Upload::Client up = nullptr;
    ASSERT_TRUE(loop.until([&] {  // A daemon that is held up still has those of the leavers before.
      auto begin = theirs.beginUploadRequest();
      begin.setBytes(bytes.size());
      auto begun = loop.call(kj::mv(begin));
      up = begun.getUpload();
      return good(begun.getStatus());
    })) << round;
    {
      auto region = loop.call(up.regionRequest());
      auto fd = region.getRegion().getFd().wait(loop.io.waitScope);
      KJ_IF_MAYBE (number, fd) {
        ASSERT_EQ(::pwrite(*number, bytes.data(), bytes.size(), 0), std::ssize(bytes));
      }
    }
    auto committed = up.commitTextureRequest().send();
    loop.pause(round % 8);
  }
  // All that a user may have under way is theirs again: every leaver's check has come to its end.
  std::vector<proto::Upload::Client> held;
  EXPECT_TRUE(loop.until(
      [&] {
        auto begin = scene.beginUploadRequest();
        begin.setBytes(bytes.size());
        auto begun = loop.call(kj::mv(begin));
        if (good(begun.getStatus())) {
          held.push_back(begun.getUpload());
        }
        return held.size() == Uploads::kPerUser;
      },
      60))
      << held.size();
  const auto textures = [&] { return loop.call(scene.listTexturesRequest()).getTextures().size(); };
  EXPECT_TRUE(loop.until([&] { return textures() == 0; })) << textures();
  held.clear();
  EXPECT_TRUE(good(upload(cube(0.01f)).getStatus()));
}

}  // namespace
}  // namespace hapticd::test
