/** @file
 * A file of results is there whole or not at all.
 */
#include "tools/haptic-bench/whole_file.h"

#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <fstream>

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
