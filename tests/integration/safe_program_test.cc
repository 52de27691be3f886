// hapticd-safe: what it finds, what it leaves, and what the next daemon makes of that.
#include <filesystem>

#include "daemon/armed/armed_list.h"
#include "tests/integration/program.h"

namespace hapticd::test {
namespace {

TEST_F(ProgramTest, SafeReadsTheListInTheServicesOwnFolder) {
  const std::string program = HAPTICD_PROGRAM + std::string("-safe"), said = directory.path() + "/said";
  const auto code = [&](const std::string& arguments) {
    const std::string command =
        "RUNTIME_DIRECTORY=" + directory.path() + ":/nonexistent " + program + " " + arguments + " 2>" + said;
    return WEXITSTATUS(std::system(command.c_str()));
  };
  EXPECT_EQ(code(""), 0) << "nothing was ever armed";
  std::ofstream(directory.path() + "/armed") << "sim://falcon\n";
  EXPECT_EQ(code(""), 0);
  std::ifstream in(said);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(in), {}), "made safe: sim://falcon\n");
  EXPECT_EQ(code(directory.path() + "/" + std::string(300, 'x')), 3) << "whether it is there cannot be told";
  EXPECT_EQ(code("\"\""), 2) << "of a variable that is not set";
}

/** Whoever runs it again is not told that all is safe. */
TEST_F(ProgramTest, WhatSafeCannotZeroStaysOnTheList) {
  const std::string list = directory.path() + "/run/armed";
  std::filesystem::create_directory(directory.path() + "/run");
  const std::string said = directory.path() + "/said";
  const auto code = [&] {
    return WEXITSTATUS(std::system((HAPTICD_PROGRAM + std::string("-safe ") + list + " 2>" + said).c_str()));
  };
  const auto listed = [&] {
    std::ifstream in(list);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  std::ofstream(list) << "nosuch://thing\nsim://falcon\n";
  const auto left = [&] { return armedIn(listed()) == std::vector<std::string>{"nosuch://thing"}; };
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(code(), 1);
    EXPECT_TRUE(left()) << listed();
    std::ifstream in(said);
    const std::string text(std::istreambuf_iterator<char>(in), {});
    EXPECT_NE(text.find("delete its line from " + list), std::string::npos) << text;
  }
  {  // The next daemon tries too, and leaves it to whoever comes after it.
    Program daemon(directory, run({}));
    EXPECT_TRUE(daemon.says("could not be made safe")) << daemon.output();
    EXPECT_TRUE(daemon.says("stop hapticd and delete its line from " + list)) << daemon.output();
    ASSERT_TRUE(daemon.says("ready")) << daemon.output();
    daemon.terminate();
    EXPECT_EQ(daemon.wait(), 0);
    EXPECT_TRUE(left()) << listed();
  }
  std::ofstream(list) << "sim://falcon\n";
  EXPECT_EQ(code(), 0);
  EXPECT_EQ(listed(), "");
}

}  // namespace
}  // namespace hapticd::test
