/** @file
 * A file of results is there whole or not at all.
 */
#include "tools/haptic-bench/whole_file.h"

#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "tests/support/process/temporary_directory.h"
#include "tools/haptic-bench/failure.h"

namespace haptic_bench {
namespace {

TEST(WholeFile, IsThereWhenItIsKept) {
  const hapticd::test::TemporaryDirectory folder;
  const std::string path = folder.path() + "/results.csv";
  {
    WholeFile file(path);
    std::ofstream(file.part()) << "half";
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  WholeFile file(path);
  std::ofstream(file.part()) << "whole";
  EXPECT_FALSE(std::filesystem::exists(path));
  file.keep();
  EXPECT_EQ(std::filesystem::file_size(path), 5u);
  EXPECT_THROW(WholeFile(folder.path()), Failure);
}

// A file that was called so was taken for a part and removed, results for one's own eyes became everybody's, and what
// a link led to was written piece by piece.
TEST(WholeFile, KeepsRightsLinksAndOtherFiles) {
  namespace fs = std::filesystem;
  const hapticd::test::TemporaryDirectory folder;
  const std::string path = folder.path() + "/results.csv", link = folder.path() + "/link.csv";
  const auto contents = [](const std::string& name) {
    std::ifstream file(name);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  for (const std::string& name : {path, path + ".part", path + ".0.part"}) std::ofstream(name) << "before";
  const auto own = fs::perms::owner_read | fs::perms::owner_write;
  fs::permissions(path, own);
  fs::create_symlink("results.csv", link);
  for (const bool kept : {false, true}) {
    WholeFile file(link), another(path);
    EXPECT_NE(file.part(), another.part());
    std::ofstream(file.part()) << "after";
    EXPECT_EQ(contents(path), "before");
    if (kept) file.keep();
  }
  EXPECT_EQ(contents(path), "after");
  EXPECT_EQ(fs::status(path).permissions(), own);
  EXPECT_TRUE(fs::is_symlink(link));
  for (const char* other : {".part", ".0.part"}) EXPECT_EQ(contents(path + other), "before");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}), 4);
}

TEST(WholeFile, LeavesNothingWhenItIsEnded) {
  const hapticd::test::TemporaryDirectory folder;
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
    EXPECT_EXIT(
        {
          WholeFile file(folder.path() + "/results.csv");
          std::ofstream(file.part()) << "half";
          std::raise(number);
        },
        ::testing::KilledBySignal(number), "");
    EXPECT_TRUE(std::filesystem::is_empty(folder.path())) << number;
  }
}

}  // namespace
}  // namespace haptic_bench
