// Options of hapticctl load that hapticctl import hands on with the words behind them.
#include "tools/options/load_values.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <set>

#include "tools/hapticctl/command/command.h"

namespace hapticctl {
namespace {

using ::testing::ElementsAre;

TEST(LoadValues, AreAllOptionsOfLoadWithAValue) {
  CLI::App app;
  Action none;
  addLoad(app, none);
  std::set<std::string> known(hapticd_options::kLoadValues.begin(), hapticd_options::kLoadValues.end());
  known.erase("--socket");  // Of hapticctl.
  known.erase("--timeout");
  known.insert({"--scale", "--voxel"});
  std::set<std::string> there;
  for (const CLI::Option* option : app.get_subcommand("load")->get_options()) {
    if (option->get_items_expected_max() == 0) continue;
    for (const std::string& name : option->get_lnames()) there.insert("--" + name);
  }
  EXPECT_EQ(there, known);
}

TEST(LoadValues, AreTakenWithTheirNames) {
  std::vector<std::string> words = {"--name", "a", "--center", "scan", "--at", "-1,0,0", "--iso", "3", "--size=1"};
  EXPECT_THAT(hapticd_options::takeLoadValues(words), ElementsAre("--name", "a", "--at", "-1,0,0"));
  EXPECT_THAT(words, ElementsAre("--center", "scan", "--iso", "3", "--size=1"));
  words = {"--", "--name", "a"};
  EXPECT_THAT(hapticd_options::takeLoadValues(words), ElementsAre());
  EXPECT_THAT(words, ElementsAre("--", "--name", "a"));
  words = {"scan", "--name"};
  EXPECT_THAT(hapticd_options::takeLoadValues(words), ElementsAre("--name"));
}

}  // namespace
}  // namespace hapticctl
