// What is written to an object by a resource name is that property's, and no other's.
#include <map>
#include <string>
#include <vector>

#include "daemon/resource/properties.h"
#include "daemon/resource/resource_tree.h"
#include "tests/session/bench.h"
#include "tests/support/shape/texture_upload.h"

namespace hapticd::test {
namespace {

struct Written {
  const char* name;
  const char* value;
  const char* json;
  std::vector<const char*> follow;  ///< Other properties that say a part of it, or more.
};

const std::vector<Written>& writes() {
  static const std::vector<Written> kWrites = {
      {"pos", "0.01,-0.02,0.03", "[0.01,-0.02,0.03]", {"pose", "worldpos", "worldpose"}},
      {"rot", "0.1,0.7,-0.5,0.5", "[0.1,0.7,-0.5,0.5]", {"pose", "worldpose"}},
      {"pose",
       "0.04,0.05,-0.06,0.1,-0.5,0.7,0.5",
       R"({"pos":[0.04,0.05,-0.06],"rot":[0.1,-0.5,0.7,0.5]})",
       {"pos", "rot", "worldpos", "worldpose"}},
      {"worldpos", "0.07,-0.08,0.09", "[0.07,-0.08,0.09]", {"pos", "pose", "worldpose"}},
      {"velocity", "0.1,0.2,-0.3", "[0.1,0.2,-0.3]", {}},
      {"stiffness", "300", "300.0", {"material"}},
      {"damping", "3", "3.0", {"material"}},
      {"friction_static", "0.75", "0.75", {"material"}},
      {"friction_dynamic", "0.125", "0.125", {"material"}},
      {"material",
       "700,2,0.5,0.25",
       R"({"damping":2.0,"friction_dynamic":0.25,"friction_static":0.5,"stiffness":700.0})",
       {"stiffness", "damping", "friction_static", "friction_dynamic"}},
      {"smooth_deg", "35", "35.0", {}},
      {"transient_gain", "0.5", "0.5", {}},
      {"transient_hz", "250", "250.0", {}},
      {"transient_decay_s", "0.0625", "0.0625", {}},
      {"relief_depth", "0.00025", "0.00025", {}},
      {"relief_width", "0.125", "0.125", {}},
      {"relief_height", "0.0625", "0.0625", {}},
      {"relief", "1", "1", {}},
      {"vibration", "2", "2", {}},
      {"vibration_mass", "0.015625", "0.015625", {}},
      {"mass", "0.375", "0.375", {}},
      {"motion_damping", "0.625", "0.625", {}},
      {"falls", "off", "false", {}},
      {"effect", "viscous", "\"viscous\"", {}},
      {"effect_force", "1.5", "1.5", {}},
      {"effect_stiffness", "150", "150.0", {}},
      {"effect_damping", "1.25", "1.25", {}},
      {"effect_reach", "0.25", "0.25", {}},
      {"effect_hz", "75", "75.0", {}},
      {"effect_duration_s", "5.5", "5.5", {}},
      {"effect_path", "0,0,0,0.25,0,-0.125", "[[0.0,0.0,0.0],[0.25,0.0,-0.125]]", {}},
      {"enabled", "false", "false", {}},
      {"visible", "0", "false", {}},
      {"twosided", "true", "true", {}},
  };
  return kWrites;
}

TEST(WrittenProperties, EachIsChangedAloneAndToldAgain) {
  Bench bench;
  const Client& by = bench.core.client(bench.administration);
  SceneModel& scene = bench.core.scene();
  ASSERT_EQ(*scene.textures().add(*parseTexture(reliefUpload(4, 3, std::vector<std::uint16_t>(12, 9))), by), 1u);
  ASSERT_EQ(*scene.textures().add(*parseTexture(vibrationUpload()), by), 2u);
  ObjectSpec spec;
  spec.name = "it";
  spec.shape = {ShapeKind::kBox, Vec3(0.01, 0.02, 0.03), 0};
  spec.material = kDefaultMaterial;
  ASSERT_TRUE(scene.create(spec, by).ok());
  ResourceTree tree(bench.core);
  const auto told = [&] {
    std::map<std::string, std::string> all;
    for (const ObjectProperty& property : objectProperties())
      all[property.name] = *tree.get(std::string("/objects/it/") + property.name, by);
    return all;
  };
  std::size_t writable = 0;
  for (const ObjectProperty& property : objectProperties()) writable += property.set == nullptr ? 0 : 1;
  EXPECT_EQ(writes().size(), writable) << "one that can be written is not tried";
  for (const Written& write : writes()) {
    SCOPED_TRACE(write.name);
    auto expected = told();
    EXPECT_NE(expected[write.name], write.json) << "it would say nothing";
    const auto answer = tree.set(std::string("/objects/it/") + write.name + "?value=" + write.value, by);
    ASSERT_TRUE(answer.ok()) << toString(answer.error());
    EXPECT_EQ(*answer, write.json);
    const auto now = told();
    expected[write.name] = write.json;
    for (const char* const other : write.follow) expected[other] = now.at(other);
    EXPECT_EQ(now, expected);
  }
}

TEST(WrittenProperties, ARefusalSaysWhereAndWhatToDo) {
  Bench bench;
  const Client& by = bench.core.client(bench.administration);
  ObjectSpec spec;
  spec.name = "it";
  spec.shape = {ShapeKind::kSphere, Vec3(0.01, 0, 0), 0};
  spec.material = kDefaultMaterial;
  ASSERT_TRUE(bench.core.scene().create(spec, by).ok());
  ResourceTree tree(bench.core);
  const auto check = [](const char* uri, const Result<std::string>& answer) {
    ASSERT_FALSE(answer.ok()) << uri;
    EXPECT_FALSE(answer.error().where.empty() || answer.error().remedy.empty())
        << uri << " " << toString(answer.error());
  };
  for (const ObjectProperty& property : objectProperties()) {
    for (const char* const value : {"x", "-1e99", "1,2"}) {
      const std::string uri = std::string("/objects/it/") + property.name + "?value=" + value;
      check(uri.c_str(), tree.set(uri, by));
    }
  }
  for (const char* const uri : {"/objects/it/pos/x?value=0,0,0", "/objects/it/velocity?value=0,0,101",
                                "/objects/it?value=1", "/world/gravity/x?value=1", "/devices/no/radius?value=0"})
    check(uri, tree.set(uri, by));
  for (const char* const path : {"/objects/it/pos/x", "/world/gravity/x", "/clients/x", "/config/x", "/volumes/x"})
    check(path, tree.get(path, by));
}

}  // namespace
}  // namespace hapticd::test
