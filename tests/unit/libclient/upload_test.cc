#include <fcntl.h>
#include <unistd.h>

#include <cstring>

#include "proto/snapshot.h"
#include "tests/unit/libclient/fixture.h"

namespace hapticd::test {
namespace {

constexpr float kVertices[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
constexpr std::uint32_t kTriangles[] = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};

class UploadTest : public WithClient {};

TEST_F(UploadTest, TheMeshArrivesAsItWasFilled) {
  auto upload = client_->scene().beginUpload(4, 4, HAPTIC_MESH_DEFORMABLE);
  ASSERT_TRUE(upload) << upload.error().message();
  ASSERT_EQ(upload->vertices().size(), 12u);
  ASSERT_EQ(upload->triangles().size(), 12u);
  std::copy(std::begin(kVertices), std::end(kVertices), upload->vertices().begin());
  std::copy(std::begin(kTriangles), std::end(kTriangles), upload->triangles().begin());
  auto report = upload->commit();
  ASSERT_TRUE(report) << report.error().message();
  EXPECT_EQ((*report)->id, 42u);
  EXPECT_EQ((*report)->vertices, 4u);
  ASSERT_EQ((*report)->note_count, 1u);
  EXPECT_STREQ((*report)->notes[0], "triangle 3 turned");
  EXPECT_TRUE(upload->vertices().empty()) << "unmapped";

  const auto bytes = daemon_->seen().upload;
  ASSERT_EQ(bytes.size(), sizeof(hd_mesh_upload) + sizeof kVertices + sizeof kTriangles);
  hd_mesh_upload header;
  std::memcpy(&header, bytes.data(), sizeof header);
  EXPECT_EQ(header.magic, HD_UPLOAD_MAGIC);
  EXPECT_EQ(header.flags, unsigned{HD_MESH_DEFORMABLE});
  EXPECT_EQ(std::memcmp(bytes.data() + sizeof header, kVertices, sizeof kVertices), 0);
  EXPECT_EQ(std::memcmp(bytes.data() + sizeof header + sizeof kVertices, kTriangles, sizeof kTriangles), 0);
}

TEST_F(UploadTest, ProgressComesOnTheThreadThatCommits) {
  daemon_->script([](Script& script) { script.progress = {0.25f, 0.5f, 1.0f}; });
  float last = 0;
  bool mine = true;
  const auto self = std::this_thread::get_id();
  const auto report = client_->scene().upload(kVertices, kTriangles, 0, [&](float fraction, const char* stage) {
    EXPECT_GE(fraction, last);
    if (fraction > 0) {  // Before, a busy machine may hear nothing for a while.
      EXPECT_STREQ(stage, "tree");
    }
    last = fraction;
    mine = mine && std::this_thread::get_id() == self;
    EXPECT_TRUE(client_->get("/x")) << "calls are allowed here";
    return true;
  });
  ASSERT_TRUE(report) << report.error().message();
  EXPECT_EQ(last, 1.0f);
  EXPECT_TRUE(mine);
}

TEST_F(UploadTest, TheCallbackCancels) {
  daemon_->script([](Script& script) {
    script.progress = {0.25f};
    script.never_build = true;
  });
  const auto report = client_->scene().upload(kVertices, kTriangles, 0, [](float, const char*) { return false; });
  EXPECT_EQ(report.code(), HAPTIC_CANCELLED);
  EXPECT_TRUE(eventually([&] { return daemon_->seen().cancelled_uploads == 1; }));
}

TEST_F(UploadTest, TheCallbackCancelsWhereNothingNewIsTold) {
  for (const std::vector<float>& told : {std::vector<float>{}, {0.25f}}) {
    daemon_->script([&](Script& script) {
      script.progress = told;
      script.never_build = true;
    });
    auto upload = client_->scene().beginUpload(4, 4);
    ASSERT_TRUE(upload);
    std::size_t calls = 0;
    const auto report =
        upload->commit([&](float, const char*) { return ++calls <= told.size(); }, std::chrono::seconds(20));
    EXPECT_EQ(report.code(), HAPTIC_CANCELLED) << told.size();
  }
}

TEST_F(UploadTest, ABuilderThatNeverEndsIsGivenUp) {
  daemon_->script([](Script& script) { script.never_build = true; });
  auto upload = client_->scene().beginUpload(4, 4);
  ASSERT_TRUE(upload);
  EXPECT_EQ(upload->commit({}, std::chrono::milliseconds(30)).code(), HAPTIC_TIMEOUT);
  EXPECT_TRUE(eventually([&] { return daemon_->seen().cancelled_uploads == 1; }));
  const auto again = upload->commit();
  EXPECT_EQ(again.code(), HAPTIC_NOT_FOUND);
  EXPECT_EQ(again.error().what, "the upload is over");
  EXPECT_TRUE(client_->get("/x"));
}

TEST_F(UploadTest, WhoWaitsForEverGetsTheMesh) {
  auto upload = client_->scene().beginUpload(4, 4);
  ASSERT_TRUE(upload);
  const auto report = upload->commit({}, std::chrono::nanoseconds::max());
  EXPECT_TRUE(report) << report.error().message();
}

TEST_F(UploadTest, AWeldingDistanceTravelsWithTheMesh) {
  auto upload = client_->scene().beginUpload(4, 4);
  ASSERT_TRUE(upload);
  for (const double bad : {-1e-6, 0.9e-6, 1e-50, 0.0101, 1e300}) {
    EXPECT_EQ(upload->weld(bad).error().where, "distance_m") << bad;
  }
  ASSERT_TRUE(upload->weld(1e-4));
  ASSERT_TRUE(upload->commit());
  hd_mesh_upload header;
  std::memcpy(&header, daemon_->seen().upload.data(), sizeof header);
  EXPECT_EQ(header.weld_m, 1e-4f);
  EXPECT_EQ(upload->weld(1e-4).error().where, "upload") << "too late";
}

TEST_F(UploadTest, APageThatTheKernelHoldsForAMomentIsWaitedFor) {
  daemon_->script([](Script& script) { script.still_mapped = 3; });
  EXPECT_TRUE(client_->scene().upload(kVertices, kTriangles));
}

TEST_F(UploadTest, StillMappedCanBeTriedAgain) {
  daemon_->script([](Script& script) { script.still_mapped = 5; });
  auto upload = client_->scene().beginUpload(4, 4);
  ASSERT_TRUE(upload);
  EXPECT_EQ(upload->commit().code(), HAPTIC_STILL_MAPPED);
  EXPECT_TRUE(upload->commit());
}

TEST_F(UploadTest, ABadMeshNamesItsTriangle) {
  daemon_->script([](Script& script) { script.bad_mesh = "triangle 17"; });
  const auto report = client_->scene().upload(kVertices, kTriangles);
  EXPECT_EQ(report.code(), HAPTIC_BAD_MESH);
  EXPECT_EQ(report.error().where, "triangle 17");
}

TEST_F(UploadTest, UncommittedIsCancelled) {
  { ASSERT_TRUE(client_->scene().beginUpload(4, 4)); }
  EXPECT_TRUE(eventually([&] { return daemon_->seen().cancelled_uploads == 1; }));
}

TEST_F(UploadTest, SizesAreCheckedBeforeAnythingIsSent) {
  EXPECT_EQ(client_->scene().beginUpload(0, 4).error().where, "vertices");
  EXPECT_EQ(client_->scene().beginUpload(4, 0).error().where, "triangles");
  EXPECT_EQ(client_->scene().beginUpload(HD_MAX_VERTICES + 1, 4).code(), HAPTIC_INVALID_ARGUMENT);
  EXPECT_EQ(client_->scene().beginUpload(4, 4, 1).error().where, "flags");
}

TEST_F(UploadTest, ADaemonThatDiesDuringTheBuildIsDisconnected) {
  daemon_->script([](Script& script) { script.never_build = true; });
  auto upload = client_->scene().beginUpload(4, 4);
  ASSERT_TRUE(upload);
  std::thread killer([&] {
    eventually([&] { return !daemon_->seen().calls.empty(); });
    daemon_ = nullptr;
  });
  EXPECT_EQ(upload->commit().code(), HAPTIC_DISCONNECTED);
  killer.join();
}

TEST_F(UploadTest, OneOfALostDaemonSaysThatItMustBeBegunAnewAndKeepsItsArrays) {
  auto upload = client_->scene().beginUpload(4, 4);
  ASSERT_TRUE(upload);
  restart(2);
  ASSERT_TRUE(eventually([&] { return !client_->connected(); }));
  EXPECT_EQ(upload->commit().code(), HAPTIC_DISCONNECTED);
  ASSERT_TRUE(client_->reconnect());
  for (int i = 0; i < 2; ++i) {
    const auto report = upload->commit();
    EXPECT_EQ(report.code(), HAPTIC_DISCONNECTED);
    EXPECT_EQ(report.error().message(), "upload: was begun before the daemon was lost (upload again)");
    EXPECT_EQ(upload->vertices().size(), 12u) << "to be uploaded again";
  }
}

TEST_F(UploadTest, AVolumesFileIsReadFromADescriptorThatEndsWithItsScope) {
  const haptic::Scene scene = client_->scene();
  int fd = -1;
  {
    auto file = scene.volumeFile("solid");
    ASSERT_TRUE(file) << file.error().message();
    fd = file->get();
    EXPECT_EQ(::fcntl(fd, F_GETFD), FD_CLOEXEC);
    char bytes[8] = {};
    EXPECT_EQ(::pread(fd, bytes, sizeof bytes, 0), 5);
    EXPECT_STREQ(bytes, "solid");
    haptic::Descriptor other = std::move(*file);
    EXPECT_EQ(file->get(), -1);
    EXPECT_EQ(other.get(), fd);
  }
  EXPECT_EQ(::fcntl(fd, F_GETFD), -1) << "closed";
  {
    auto file = scene.volumeFile("solid");
    ASSERT_TRUE(file);
    fd = file->release();
  }
  EXPECT_EQ(::fcntl(fd, F_GETFD), FD_CLOEXEC) << "the caller's";
  ::close(fd);
  const auto none = scene.volumeFile("hollow");
  ASSERT_FALSE(none);
  EXPECT_EQ(none.code(), HAPTIC_WOULD_BLOCK);
  EXPECT_EQ(none.error().remedy, "ask again");
}

}  // namespace
}  // namespace hapticd::test
