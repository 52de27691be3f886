/** @file
 * A file that a command makes whole: what stands in its place when not all could be written.
 */
#include "tools/hapticctl/file/whole_file.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cerrno>
#include <csignal>
#include <filesystem>
#include <fstream>

#include "tests/unit/hapticctl/made_file.h"
#include "tools/hapticctl/failure.h"

namespace hapticctl {
namespace {

class WholeFileTest : public MadeFileTest {
 protected:
  [[nodiscard]] std::ptrdiff_t filesInFolder() const {
    const std::filesystem::directory_iterator all(folder_.path());
    return std::distance(begin(all), end(all));
  }
  std::string refusal(bool replace) const {
    try {
      const WholeFile file(path_, replace);
    } catch (const Failure& failure) {
      return failure.what + ": " + failure.remedy;
    }
    return "not refused";
  }
};

TEST_F(WholeFileTest, ReplacesWhenAllOfItIsThere) {
  for (const char* const before : {"none", "much older"}) {
    const bool replace = before != std::string("none");
    if (replace) hold(before);
    WholeFile file(path_, replace);
    EXPECT_EQ(file.write("new", 3), 0);
    EXPECT_EQ(file.write("er", 2), 0);
    EXPECT_EQ(held(), before);
    EXPECT_EQ(file.keep(), 0);
    EXPECT_EQ(held(), "newer");
    EXPECT_EQ(file.bytes(), 5u);
    EXPECT_EQ(filesInFolder(), 1);
  }
}

TEST_F(WholeFileTest, WhatIsInItsPlaceHasLeftItsOtherNameToOthers) {
  for (const bool replace : {false, true}) {
    const std::string path = path_ + (replace ? "r" : "n");
    {
      WholeFile first(path, replace);
      ASSERT_EQ(first.write("all", 3), 0);
      ASSERT_EQ(first.keep(), 0);
      std::ofstream(path + ".0.part") << "of another command";
    }
    EXPECT_TRUE(std::filesystem::exists(path + ".0.part"));
  }
}

TEST_F(WholeFileTest, WhatIsNotKeptLeavesNothingAndTakesNothing) {
  {
    WholeFile file(path_, false);
    EXPECT_EQ(file.write("half", 4), 0);
  }
  EXPECT_EQ(filesInFolder(), 0);
  hold("older");
  {
    WholeFile file(path_, true);
    EXPECT_EQ(file.write("half", 4), 0);
  }
  EXPECT_EQ(held(), "older");
  EXPECT_EQ(filesInFolder(), 1);
}

TEST_F(WholeFileTest, WhatTheDiskDoesNotTakeLeavesTheOldOne) {
  hold("older");
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto on_signal = std::signal(SIGXFSZ, SIG_IGN);
  {
    WholeFile file(path_, true);
    const rlimit small{3, before.rlim_max};
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
    EXPECT_EQ(file.write("newer", 5), EFBIG);
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  }
  std::signal(SIGXFSZ, on_signal);
  EXPECT_EQ(held(), "older");
}

TEST_F(WholeFileTest, WhatIsThereIsReplacedOnlyIfAskedFor) {
  {
    WholeFile file(path_, false);
    EXPECT_EQ(file.write("mine", 4), 0);
    hold("another's, made meanwhile");
    EXPECT_EQ(file.keep(), EEXIST);
  }
  EXPECT_EQ(held(), "another's, made meanwhile");
  EXPECT_EQ(refusal(false), "File exists: choose another name, or give --replace");
  EXPECT_EQ(refusal(true), "not refused");
  std::filesystem::remove(path_);
  std::filesystem::create_directory(path_);
  EXPECT_EQ(refusal(true), "is a folder: name a file in it");
  EXPECT_EQ(filesInFolder(), 1);
}

TEST_F(WholeFileTest, KeepsRightsAndLinks) {
  const std::string real = folder_.path() + "/real";
  std::ofstream(real) << "older";
  std::filesystem::permissions(real, std::filesystem::perms(0600));
  std::filesystem::create_symlink("real", path_);
  WholeFile file(path_, true);
  EXPECT_EQ(file.write("newer", 5), 0);
  EXPECT_EQ(file.keep(), 0);
  EXPECT_EQ(held(), "newer");
  EXPECT_TRUE(std::filesystem::is_symlink(path_));
  EXPECT_EQ(std::filesystem::status(real).permissions(), std::filesystem::perms(0600));
}

TEST_F(WholeFileTest, ADeviceIsWrittenItself) {
  WholeFile file("/dev/null", true);
  EXPECT_EQ(file.write("all of it", 9), 0);
  EXPECT_EQ(file.keep(), 0);
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
}

}  // namespace
}  // namespace hapticctl
