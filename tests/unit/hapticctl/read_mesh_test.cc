// Mesh files that are refused, in hapticctl's own way; what they hold is tried in tests/unit/mesh_file.
#include "tools/hapticctl/file/read_mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "tests/support/process/temporary_directory.h"
#include "tools/hapticctl/failure.h"

namespace hapticctl {
namespace {

using ::testing::HasSubstr;

Failure failureOf(const std::string& path) {
  try {
    (void)readMesh(path);
  } catch (const Failure& failure) {
    return failure;
  }
  return {kExitOk, {}, "not refused", {}};
}

TEST(ReadMesh, RefusesWithTheFilesName) {
  const hapticd::test::TemporaryDirectory directory;
  const std::string none = directory.path() + "/none.stl", cut = directory.path() + "/cut.ply",
                    text = directory.path() + "/text.xyz-unknown";
  std::ofstream(cut) << "ply\nformat binary_little_endian 1.0\nelement vertex 3000\nproperty float x\n"
                        "property float y\nproperty float z\nelement face 7000\n"
                        "property list uchar int vertex_indices\nend_header\n"
                     << std::string(100, 'x');
  std::ofstream(text) << "abc";
  for (const std::string& path : {none, cut, text}) {
    EXPECT_EQ(failureOf(path).exit, kExitFile) << path;
    EXPECT_EQ(failureOf(path).where, path);
  }
  EXPECT_EQ(failureOf(none).what, "no such file");
  EXPECT_THAT(failureOf(text).remedy, HasSubstr("hapticctl reads STL, OBJ"));
}

}  // namespace
}  // namespace hapticctl
