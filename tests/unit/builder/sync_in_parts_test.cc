// Files that are put onto a disk, however slow, by a daemon that may be told to end.
#include "daemon/scene/mesh/sync_in_parts.h"

#include <gtest/gtest.h>

#include <fstream>

#include "daemon/ipc/unique_fd.h"
#include "tests/support/process/temporary_directory.h"

namespace hapticd::test {
namespace {

TEST(SyncInParts, HearsBeforeEachPartWhetherToGoOn) {
  constexpr std::streamoff kPart = 4 << 20;
  const TemporaryDirectory directory;
  const std::string path = directory.path() + "/file";
  std::ofstream(path).seekp(10 * kPart).put('x');
  const UniqueFd file(::open(path.c_str(), O_WRONLY | O_CLOEXEC));
  ASSERT_TRUE(file.valid());
  int asked = 0;
  EXPECT_TRUE(syncInParts(file.get(), [&] { return ++asked > 0; }));
  EXPECT_EQ(asked, 11);
  asked = 0;
  errno = 0;
  EXPECT_FALSE(syncInParts(file.get(), [&] { return ++asked < 3; }));
  EXPECT_EQ(errno, ECANCELED);
  EXPECT_EQ(asked, 3);
  EXPECT_FALSE(syncInParts(-1, [] { return true; }));
  EXPECT_EQ(errno, EBADF);
}

}  // namespace
}  // namespace hapticd::test
