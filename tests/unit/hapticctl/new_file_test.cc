/** @file
 * A file that a command makes: what is in it when nothing or something was written.
 */
#include "tools/hapticctl/file/new_file.h"

#include <gtest/gtest.h>

#include <cerrno>

#include "tests/unit/hapticctl/made_file.h"
#include "tools/hapticctl/failure.h"

namespace hapticctl {
namespace {

using NewFileTest = MadeFileTest;

TEST_F(NewFileTest, WithoutAByteItIsAsItWasBefore) {
  { const NewFile file(path_, false); }
  EXPECT_EQ(held(), "none");
  hold("older");
  { const NewFile file(path_, true); }
  EXPECT_EQ(held(), "older");
  EXPECT_THROW(NewFile(path_, false), Failure);
  EXPECT_EQ(held(), "older");
}

TEST_F(NewFileTest, AFolderIsNamedAsOne) {
  for (const bool replace : {false, true}) {
    try {
      const NewFile file(folder_.path(), replace);
      ADD_FAILURE();
    } catch (const Failure& failure) {
      EXPECT_EQ(failure.what, "is a folder");
    }
  }
}

TEST_F(NewFileTest, WhereNoneCanBeMadeTheRemedyIsOfThatCause) {
  const auto remedyFor = [](const std::string& path) {
    try {
      const NewFile file(path, false);
    } catch (const Failure& failure) {
      return failure.remedy;
    }
    return std::string("none was needed");
  };
  hold("older");
  EXPECT_EQ(remedyFor(path_), "choose another name, or give --replace");
  EXPECT_EQ(remedyFor(folder_.path() + "/none/file"), "make its folder first, or name another");
  EXPECT_EQ(remedyFor(path_ + "/file"), "what stands before its last / must be a folder");
  EXPECT_EQ(remedyFor(folder_.path() + "/" + std::string(300, 'x')), "choose a shorter name");
}

TEST_F(NewFileTest, OnlyAFullDiskAsksForRoom) {
  const auto remedyFor = [](int error) {
    try {
      failWriting("file", error);
    } catch (const Failure& failure) {
      return failure.remedy;
    }
  };
  for (const int full : {ENOSPC, EDQUOT}) EXPECT_EQ(remedyFor(full), "make room on the disk");
  for (const int other : {EFBIG, EPIPE, EIO}) EXPECT_NE(remedyFor(other), "make room on the disk");
}

TEST_F(NewFileTest, TheFirstByteReplacesAllThatWasThere) {
  hold("much older");
  NewFile file(path_, true);
  EXPECT_EQ(held(), "much older");
  EXPECT_EQ(file.write("", 0), 0);
  EXPECT_EQ(held(), "much older");
  EXPECT_EQ(file.write("new", 3), 0);
  EXPECT_EQ(held(), "new");
  EXPECT_EQ(file.write("er", 2), 0);
  EXPECT_EQ(held(), "newer");
  EXPECT_EQ(file.bytes(), 5u);
}

}  // namespace
}  // namespace hapticctl
