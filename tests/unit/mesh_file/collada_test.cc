// COLLADA: what assimp makes another shape of is refused, and what it reads is not.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/mesh_file/mesh_files.h"

namespace hapticd_mesh_file {
namespace {

using ::testing::ElementsAre;

constexpr const char* kShown = "<instance_geometry url='#g'/>";
constexpr const char* kTriangle =
    "<triangles count='1'><input semantic='VERTEX' source='#v' offset='0'/><p>0 1 2</p></triangles>";

/** A triangle as a scene shows it. */
std::string collada(const std::string& nodes, const std::string& faces = kTriangle, const std::string& more = "") {
  return "<?xml version='1.0'?><COLLADA xmlns='http://www.collada.org/2005/11/COLLADASchema' version='1.4.1'>"
         "<library_geometries><geometry id='g'><mesh><source id='p'><float_array id='a' count='9'>0 0 0 2 0 0 0 3 0"
         "</float_array><technique_common><accessor source='#a' count='3' stride='3'><param name='X' type='float'/>"
         "<param name='Y' type='float'/><param name='Z' type='float'/></accessor></technique_common></source>"
         "<vertices id='v'><input semantic='POSITION' source='#p'/></vertices>" +
         faces + "</mesh></geometry></library_geometries>" + more + "<library_visual_scenes><visual_scene id='s'>" +
         nodes + "</visual_scene></library_visual_scenes><scene><instance_visual_scene url='#s'/></scene></COLLADA>";
}

std::string node(const std::string& inside) { return "<node>" + inside + "</node>"; }

/** A skin of the triangle with one joint. */
std::string skin(const std::string& matrix) {
  const auto source = [](const std::string& id, const std::string& array, const std::string& type) {
    return "<source id='" + id + "'>" + array + "<technique_common><accessor source='#" + id +
           "a' count='1' stride='1'><param type='" + type + "'/></accessor></technique_common></source>";
  };
  const std::string none = "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1";
  return "<library_controllers><controller id='c'><skin source='#g'>" + matrix +
         source("j", "<Name_array id='ja' count='1'>a</Name_array>", "name") +
         source("b", "<float_array id='ba' count='16'>" + none + "</float_array>", "float4x4") +
         source("w", "<float_array id='wa' count='1'>1</float_array>", "float") +
         "<joints><input semantic='JOINT' source='#j'/><input semantic='INV_BIND_MATRIX' source='#b'/></joints>"
         "<vertex_weights count='3'><input semantic='JOINT' source='#j' offset='0'/><input semantic='WEIGHT' "
         "source='#w' offset='1'/><vcount>1 1 1</vcount><v>0 0 0 0 0 0</v></vertex_weights></skin></controller>"
         "</library_controllers>";
}

TEST_F(ReadMeshTest, AColladaIsPutInItsPlaces) {
  const MeshFile mesh = readMesh(
      file("a.dae", collada(node("<translate>10 0 0</translate>" + node("<scale>2 1 1</scale>" + std::string(kShown))) +
                            node("<matrix>1 0 0 0  0 1 0 5  0 0 1 7  0 0 0 1</matrix>" + std::string(kShown)))),
      "the test", never);
  EXPECT_EQ(mesh.triangles.size(), 2u);
  EXPECT_THAT(mesh.lower, ElementsAre(0, 0, 0));
  EXPECT_THAT(mesh.upper, ElementsAre(14, 8, 7));
}

// assimp died of the first, leaned the second over, and took a fan for a polygon.
TEST_F(ReadMeshTest, AColladaThatWouldBeAnotherShapeIsRefused) {
  const std::string lookat = "<lookat>1 2 3 0 0 0 0 1 0</lookat>";
  EXPECT_EQ(refusal(file("a.dae", collada(node("<skew>45 0 1 0 1 0 0</skew>" + std::string(kShown))))),
            "places its parts by <skew>, which is not read");
  EXPECT_EQ(refusal(file("a.dae", collada(node(lookat + node(kShown))))),
            "places its parts by <lookat>, which is not read");
  EXPECT_EQ(refusal(file("a.dae", collada(node(lookat) + node(kShown)))), "not refused");  // A camera.
  EXPECT_EQ(refusal(file("a.DAE", collada(node(kShown),
                                          "<trifans count='1'><input semantic='VERTEX' source='#v' "
                                          "offset='0'/><p>0 1 2</p></trifans>"))),
            "holds fans of triangles (<trifans>), which are not read");
}

// The matrix was passed over.
TEST_F(ReadMeshTest, ASkinOfColladaStandsWhereItsMeshDoes) {
  const auto skinned = [](const std::string& matrix) {
    return collada(node("<instance_controller url='#c'/>"), kTriangle, skin(matrix));
  };
  for (const char* const none :
       {"", "<bind_shape_matrix>1 0 0 0\n 0 1 0 0 \t0 0 1.0 0 0 -0 0 1 </bind_shape_matrix>"}) {
    EXPECT_THAT(readMesh(file("a.dae", skinned(none)), "the test", never).upper, ElementsAre(2, 3, 0));
  }
  EXPECT_EQ(refusal(file("a.dae", skinned("<bind_shape_matrix>2 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</bind_shape_matrix>"))),
            "holds a skin with a place of its own (<bind_shape_matrix>), which is not read");
}

}  // namespace
}  // namespace hapticd_mesh_file
