// A resource name that leads nowhere is refused where it does, whichever branch it is of.
#include <string>
#include <vector>

#include "daemon/resource/resource_tree.h"
#include "tests/session/bench.h"

namespace hapticd::test {
namespace {

struct Nowhere : testing::Test {
  Nowhere() {
    ObjectSpec spec;
    spec.name = "base";
    EXPECT_TRUE(bench.core.scene().create(spec, by).ok());
    spec.name = "tip";
    spec.parent = "base";
    EXPECT_TRUE(bench.core.scene().create(spec, by).ok());
  }
  struct Refused {
    const char* name;
    ErrorCode code;
    const char* where;
  };
  void expectRefused(const Refused& refused, const Result<std::string>& answer) {
    SCOPED_TRACE(refused.name);
    ASSERT_FALSE(answer.ok()) << *answer;
    EXPECT_EQ(answer.error().code, refused.code) << toString(answer.error());
    EXPECT_EQ(answer.error().where, refused.where) << toString(answer.error());
  }

  Bench bench;
  const Client& by = bench.core.client(bench.administration);
  ResourceTree tree{bench.core};
};

TEST_F(Nowhere, ToBeRead) {
  bench.device().name = "hand";
  for (const char* const name : {"/_objects/base/tip/pos", "/_objects/base", "/objects/tip", "/devices/hand/radius",
                                 "/statistics/hand", "/meshes", "/textures", "/world/gravity", "/volumes"})
    EXPECT_TRUE(tree.get(name, by).ok()) << name;
  const std::vector<std::pair<const char*, const char*>> reads = {
      {"/nowhere", "/nowhere"},
      {"/nowhere/below", "/nowhere"},
      {"/_objects/tip", "/_objects/tip"},
      {"/_objects/base/nobody/pos", "/_objects/base/nobody"},
      {"/_objects/base/tip/pos/x", "/_objects/base/tip/pos/x"},
      {"/objects/nobody/pos", "/objects/nobody"},
      {"/objects/base/tip", "/objects/base/tip"},
      {"/objects/base/pos/x", "/objects/base/pos/x"},
      {"/devices/nobody/pos", "/devices/nobody"},
      {"/devices/hand/arm", "/devices/hand/arm"},
      {"/devices/hand/pos/x", "/devices/hand/pos/x"},
      {"/statistics/nobody", "/statistics/nobody"},
      {"/statistics/hand/cycles", "/statistics/hand/cycles"},
      {"/meshes/1", "/meshes/1"},
      {"/textures/1", "/textures/1"},
      {"/world/wind", "/world/wind"},
      {"/world/gravity/x", "/world/gravity/x"},
      {"/clients/1", "/clients/1"},
      {"/config/servo", "/config/servo"},
      {"/volumes/1", "/volumes/1"},
  };
  for (const auto& [name, where] : reads) expectRefused({name, ErrorCode::kNotFound, where}, tree.get(name, by));
}

TEST_F(Nowhere, ToBeWritten) {
  bench.device().name = "hand";
  for (const char* const name :
       {"/_objects/base/tip/pos?value=0,0,0", "/objects/tip/pos?value=0,0,0", "/world/gravity?value=0,0,0"})
    EXPECT_TRUE(tree.set(name, by).ok()) << name;
  using enum ErrorCode;
  const std::vector<Refused> writes = {
      {"/nowhere/a/b?value=1", kNotFound, "/nowhere"},
      {"/_objects/tip/pos?value=0,0,0", kNotFound, "/_objects/tip"},
      {"/_objects/base/tip?value=0,0,0", kInvalidArgument, "/_objects/base/tip"},
      {"/_objects/base/tip/pos/x?value=0", kNotFound, "/_objects/base/tip/pos/x"},
      {"/objects/nobody/pos?value=0,0,0", kNotFound, "/objects/nobody"},
      {"/objects/base/tip?value=0,0,0", kNotFound, "/objects/base/tip"},
      {"/objects/base/pos/x?value=0", kNotFound, "/objects/base/pos/x"},
      {"/objects/base/id?value=7", kPermissionDenied, "/objects/base/id"},
      {"/objects/base?value=7", kPermissionDenied, "/objects/base"},
      {"/objects/base/pos", kInvalidArgument, "/objects/base/pos"},
      {"/objects/base/pos?value=0,0,0&now=1", kInvalidArgument, "/objects/base/pos"},
      {"/devices/nobody/radius?value=0", kNotFound, "/devices/nobody"},
      {"/devices/hand/arm?value=1", kNotFound, "/devices/hand/arm"},
      {"/devices/hand/pos?value=0,0,0", kPermissionDenied, "/devices/hand/pos"},
      {"/devices/hand/radius/x?value=0", kNotFound, "/devices/hand/radius/x"},
      {"/world/wind?value=0,0,0", kNotFound, "/world/wind"},
      {"/world/gravity/x?value=0,0,0", kNotFound, "/world/gravity/x"},
      {"/meshes/1/uses?value=0", kPermissionDenied, "/meshes/1/uses"},
  };
  for (const Refused& write : writes) expectRefused(write, tree.set(write.name, by));
}

}  // namespace
}  // namespace hapticd::test
