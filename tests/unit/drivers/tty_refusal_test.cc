// Why a serial line does not open, and what to do about it.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>

#include "drivers/serial/tty_transport.h"
#include "tests/support/process/child_process.h"
#include "tests/support/process/temporary_directory.h"

namespace hapticd::test {
namespace {

/** What a user without rights is told. */
std::string toldOf(const std::string& path) {
  return ChildProcess([&](auto say) {
           if (::geteuid() == 0 && ::setuid(65534) != 0) return say("no other user");
           const auto opened = TtyTransport(path).open();
           say(opened ? "open" : toString(opened.error()));
         })
      .all();
}

TEST(TtyRefusal, SaysWhetherItIsThereOrMayNotBeOpened) {
  const TemporaryDirectory directory;
  ASSERT_EQ(::chmod(directory.path().c_str(), 0755), 0);
  const std::string line = directory.path() + "/line";
  EXPECT_EQ(toldOf(line), line + ": No such file or directory (is it plugged in?)");
  std::ofstream(line) << "";
  ASSERT_EQ(::chmod(line.c_str(), 0), 0);
  const std::string told = toldOf(line);
  EXPECT_TRUE(told.starts_with(line + ": Permission denied (")) << told;
  EXPECT_NE(told.find("dialout"), std::string::npos) << told;
  EXPECT_NE(told.find("hapticd-serial.conf"), std::string::npos) << told;
}

}  // namespace
}  // namespace hapticd::test
