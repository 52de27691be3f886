// Unknown subcommands: what was meant, and programs that become subcommands.
#include "tools/hapticctl/external.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <fstream>

#include "tests/support/process/temporary_directory.h"

namespace hapticctl {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

const std::vector<std::string> kKnown{"status", "list",   "info", "monitor", "load",
                                      "doctor", "disarm", "arm",  "set",     "stop"};

TEST(Suggestions, ComeNearestFirst) {
  EXPECT_THAT(suggestions("stauts", kKnown), ElementsAre("status"));
  EXPECT_THAT(suggestions("monitr", kKnown), ElementsAre("monitor"));
  EXPECT_THAT(suggestions("st", kKnown), ElementsAre("status", "stop", "set"));
  EXPECT_THAT(suggestions("lod", kKnown), ElementsAre("load"));
  EXPECT_THAT(suggestions("xyzzy", kKnown), IsEmpty());
}

TEST(External, FindsProgramsOnThePathAndNothingElse) {
  const hapticd::test::TemporaryDirectory temporary;
  const std::filesystem::path directory = temporary.path();
  const auto program = directory / "hapticctl-greet";
  std::ofstream(program) << "#!/bin/sh\necho hello\n";
  const std::string path = getenv("PATH");
  setenv("PATH", (directory.string() + ":" + path).c_str(), 1);
  EXPECT_EQ(findExternal("greet"), "") << "it may not be executed yet";
  std::filesystem::permissions(program, std::filesystem::perms::owner_all);
  EXPECT_EQ(findExternal("greet"), program.string());
  EXPECT_EQ(findExternal("../hapticctl-greet"), "");
  EXPECT_EQ(findExternal("Greet"), "");
  setenv("PATH", path.c_str(), 1);
  EXPECT_EQ(findExternal("greet"), "");
}

}  // namespace
}  // namespace hapticctl
