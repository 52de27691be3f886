// What doctor says of the folder where built volumes are kept.
#include <filesystem>
#include <fstream>
#include <string>

#include "daemon/rpc/status.h"
#include "tests/session/bench.h"
#include "tests/support/process/temporary_directory.h"

namespace hapticd::test {
namespace {

using State = proto::Check::State;

CheckLine volumesOf(Core& core) {
  for (const CheckLine& line : makeChecks(core)) {
    if (line.name == "volumes on disk") return line;
  }
  ADD_FAILURE() << "it says nothing of them";
  return {};
}

TEST(Doctor, NamesTheFolderOfVolumesThatCannotBeWritten) {
  const TemporaryDirectory directory;
  Bench bench;
  EXPECT_EQ(volumesOf(bench.core).state, State::NOT_APPLICABLE);
  bench.core.uploads().setCache(std::make_unique<VolumeCache>(directory.path() + "/volumes", 1 << 20));
  EXPECT_EQ(volumesOf(bench.core).state, State::GREEN);
  std::ofstream(directory.path() + "/file") << "in the way";
  const std::string folder = directory.path() + "/file/volumes";
  bench.core.uploads().setCache(std::make_unique<VolumeCache>(folder, 1 << 20));
  const CheckLine red = volumesOf(bench.core);
  EXPECT_EQ(red.state, State::RED);
  EXPECT_NE(red.detail.find(folder), std::string::npos) << red.detail;
  EXPECT_NE(red.remedy.find("builder.cache"), std::string::npos) << red.remedy;
  std::filesystem::remove(directory.path() + "/file");
  EXPECT_EQ(volumesOf(bench.core).state, State::RED) << "it still cannot lie there";
  std::filesystem::create_directories(folder);
  EXPECT_EQ(volumesOf(bench.core).state, State::GREEN) << "although none has been kept since";
}

}  // namespace
}  // namespace hapticd::test
