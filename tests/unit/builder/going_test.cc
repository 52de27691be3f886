// Large memory that nobody needs any more: the control thread does not give it back itself, and it counts until it is.
#include <unistd.h>

#include <filesystem>
#include <future>
#include <new>
#include <string>

#include "daemon/scene/upload/uploads.h"
#include "tests/support/eventually.h"
#include "tests/unit/builder/built.h"

namespace hapticd::test {
namespace {

constexpr std::uint64_t kBytes = 2 * kLargeBytes;
constexpr const char* kUpload = "hapticd-upload";

/** This process's descriptors of memory of that name. */
std::size_t descriptorsOf(const std::string& name) {
  std::size_t count = 0;
  std::error_code gone;  // The one with which they are listed.
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd"))
    count += std::filesystem::read_symlink(entry.path(), gone).string().starts_with("/memfd:" + name) ? 1 : 0;
  return count;
}

class Going : public testing::Test {
 protected:
  void SetUp() override {
    meshes_.setLock(false);
    BuilderOptions options;
    options.program = HAPTICD_TEST_BUILDER;
    auto leash = BuilderLeash::start(options);
    ASSERT_TRUE(leash.ok()) << toString(leash.error());
    uploads_.setBuilder(std::move(*leash));
  }
  /** Nothing goes until letGo(). */
  void hold() {
    uploads_.going().start(
        [go = go_.get_future().share()]() -> Result<int> {
          go.wait();
          return 0;
        },
        [](const Result<int>&) {});
  }
  void letGo() { go_.set_value(); }
  std::uint64_t filled(std::uint64_t bytes) {
    const auto id = uploads_.begin(bytes, Client{});
    EXPECT_TRUE(id.ok()) << toString(id.error());
    const std::vector<std::byte> zeros(bytes);
    EXPECT_EQ(::pwrite(uploads_.region(*id)->get(), zeros.data(), bytes, 0), static_cast<ssize_t>(bytes));
    return *id;
  }
  template <class Is>
  bool comes(Is&& is) {
    return eventually([&] {
      uploads_.poll();
      return is();
    });
  }

  MeshStore meshes_;
  TextureStore textures_;
  bool no_memory_ = false;
  Uploads uploads_{meshes_, textures_, [this](auto, auto, auto) {
                     if (no_memory_) throw std::bad_alloc();
                     return Result<void>();
                   }};
  std::promise<void> go_;  ///< Goes first: nobody waits for one that is gone.
};

TEST_F(Going, AnUploadThatIsNeverCommitted) {
  const std::uint64_t large = filled(kBytes), little = filled(4096);
  hold();
  uploads_.cancel(little);
  EXPECT_EQ(uploads_.size(), 1u) << "what is little goes at once";
  uploads_.cancel(large);
  uploads_.cancel(large);
  EXPECT_FALSE(uploads_.region(large).ok());
  EXPECT_EQ(uploads_.commit(large, {}, {}).error().code, ErrorCode::kNotFound);
  for (int i = 0; i < 10; ++i) uploads_.poll();
  EXPECT_EQ(descriptorsOf(kUpload), 1u);
  EXPECT_EQ(uploads_.bytesOf(Client{}.uid), kBytes) << "until it has gone";
  letGo();
  EXPECT_TRUE(comes([&] { return uploads_.size() == 0; }));
  EXPECT_EQ(descriptorsOf(kUpload), 0u);
  EXPECT_FALSE(uploads_.busy());
}

TEST_F(Going, TheUploadOfAMeshThatIsRefused) {
  const std::uint64_t id = filled(kBytes);
  hold();
  std::optional<ErrorCode> code;
  ASSERT_TRUE(uploads_.commit(id, {}, [&](const Result<MeshInfo>& made) { code = made.error().code; }).ok());
  EXPECT_TRUE(comes([&] { return code.has_value(); }));
  EXPECT_EQ(code, ErrorCode::kBadMesh);
  EXPECT_EQ(descriptorsOf(kUpload), 2u) << "the leash's and that of the upload";
  EXPECT_EQ(uploads_.bytesOf(Client{}.uid), kBytes);
  letGo();
  EXPECT_TRUE(comes([&] { return uploads_.size() == 0 && !uploads_.busy(); }));
  EXPECT_EQ(descriptorsOf(kUpload), 0u);
}

TEST_F(Going, WhatWasCheckedForNobody) {
  const auto mesh = upload(torus(400, 300));
  const auto id = uploads_.begin(mesh.size(), Client{});
  ASSERT_TRUE(id.ok());
  EXPECT_EQ(::pwrite(uploads_.region(*id)->get(), mesh.data(), mesh.size(), 0), std::ssize(mesh));
  std::promise<void> check;
  bool told = false;
  uploads_.aside().start(
      [wait = check.get_future().share()]() -> Result<int> {
        wait.wait();
        return 0;
      },
      [](const Result<int>&) {});
  ASSERT_TRUE(uploads_.commit(*id, {}, [&](const Result<MeshInfo>&) { told = true; }).ok());
  const auto built = [&] { return uploads_.aside().size() == 2; };
  ASSERT_TRUE(comes(built)) << "its check waits";
  hold();
  uploads_.cancel(*id);
  check.set_value();
  EXPECT_TRUE(comes([&] { return uploads_.aside().size() == 0; }));
  EXPECT_EQ(uploads_.size(), 1u);
  EXPECT_GT(uploads_.bytesOf(Client{}.uid), mesh.size()) << "what it has become";
  letGo();
  EXPECT_TRUE(comes([&] { return uploads_.size() == 0; }));
  EXPECT_FALSE(told);
}

/** Else whoever waits for it would wait for ever. */
TEST_F(Going, WhatCannotGoOnForWantOfMemoryIsTold) {
  const auto mesh = upload(cube());
  const auto id = uploads_.begin(mesh.size(), Client{});
  ASSERT_TRUE(id.ok());
  EXPECT_EQ(::pwrite(uploads_.region(*id)->get(), mesh.data(), mesh.size(), 0), std::ssize(mesh));
  std::optional<ErrorCode> code;
  ASSERT_TRUE(uploads_.commit(*id, {}, [&](const Result<MeshInfo>& made) { code = made.error().code; }).ok());
  no_memory_ = true;
  EXPECT_TRUE(eventually([&] {
    try {
      uploads_.poll();
    } catch (const std::bad_alloc&) {  // As whoever polls does.
    }
    return code.has_value();
  }));
  EXPECT_EQ(code, ErrorCode::kSystem);
  EXPECT_EQ(uploads_.size(), 0u);
}

TEST_F(Going, TheLastDescriptorThatAClientWasToGet) {
  const std::uint64_t large = filled(kBytes), little = filled(4096);
  hold();
  int gone = 0;
  uploads_.close(std::move(*uploads_.region(little)), [&] { ++gone; });
  EXPECT_EQ(gone, 1);
  uploads_.close(std::move(*uploads_.region(large)), [&] { ++gone; });
  for (int i = 0; i < 10; ++i) uploads_.poll();
  EXPECT_EQ(gone, 1);
  EXPECT_EQ(descriptorsOf(kUpload), 3u);
  for (std::size_t i = 0; i < Uploads::kMostGoing; ++i)
    uploads_.close(std::move(*uploads_.region(large)), [&] { ++gone; });
  EXPECT_EQ(gone, 3) << "beyond the most they are closed at once";
  letGo();
  EXPECT_TRUE(comes([&] { return gone == 2 + static_cast<int>(Uploads::kMostGoing); }));
  EXPECT_EQ(descriptorsOf(kUpload), 2u);
}

}  // namespace
}  // namespace hapticd::test
