// Directories of tests: whoever is killed leaves one, and the next removes it; nobody loses his.
#include "tests/support/process/temporary_directory.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/process/child_process.h"

namespace hapticd::test {
namespace {

namespace fs = std::filesystem;

std::size_t entries(const fs::path& folder) {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

/** One whose directory lies in that folder, with something in it. */
ChildProcess ownerIn(const fs::path& folder) {
  return ChildProcess([folder](auto say) {
    ::setenv("TMPDIR", folder.c_str(), 1);
    const TemporaryDirectory own;
    std::ofstream(own.path() + "/file") << "text";
    say("made");
    ::pause();
  });
}

TEST(TemporaryDirectories, OfTheKilledAreSweptAndNoOthers) {
  const TemporaryDirectory folder, elsewhere;
  std::ofstream(elsewhere.path() + "/kept") << "text";
  const fs::path root = folder.path();
  fs::create_directory(root / "hapticd-other-abcdef");
  fs::create_directory_symlink(elsewhere.path(), root / "hapticd-tests-aLinkA");
  ChildProcess killed = ownerIn(root), living = ownerIn(root);
  ASSERT_TRUE(killed.saysSomething());
  ASSERT_TRUE(living.saysSomething());
  EXPECT_EQ(entries(root), 4u);
  ASSERT_TRUE(killed.kill());
  TemporaryDirectory::sweep(root);
  EXPECT_EQ(entries(root), 3u) << "of the one that lives, another's, the link";
  EXPECT_TRUE(fs::exists(elsewhere.path() + "/kept"));
  TemporaryDirectory::sweep(fs::path(folder.path()).parent_path());
  EXPECT_TRUE(fs::exists(root)) << "this test's own";
  ASSERT_TRUE(living.kill());
  TemporaryDirectory::sweep(root);
  EXPECT_EQ(entries(root), 2u);
}

/** Whoever is killed before there is a lock, too. */
TEST(TemporaryDirectories, AreSweptBeforeTheyHaveAName) {
  const TemporaryDirectory folder;
  const fs::path root = folder.path();
  const std::string held = (root / "hapticd-new-locked").string();
  fs::create_directory(held);
  fs::create_directory(root / "hapticd-new-killed");
  const int lock = ::open(held.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  ASSERT_EQ(::flock(lock, LOCK_EX | LOCK_NB), 0);
  TemporaryDirectory::sweep(root);
  EXPECT_EQ(entries(root), 1u);
  EXPECT_TRUE(fs::exists(held)) << "whose owner is about to name it";
  ::close(lock);
  TemporaryDirectory::sweep(root);
  EXPECT_EQ(entries(root), 0u);
}

TEST(TemporaryDirectories, GoWithTheirOwner) {
  std::string path;
  {
    const TemporaryDirectory own;
    path = own.path();
    EXPECT_TRUE(fs::is_empty(path));
  }
  EXPECT_FALSE(fs::exists(path));
}

}  // namespace
}  // namespace hapticd::test
