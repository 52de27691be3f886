// COLLADA and skins: what assimp makes another shape of is refused, and what it reads is not.
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
  const auto source = [](const std::string& id, const std::string& array, const std::string& type, int stride) {
    return "<source id='" + id + "'>" + array + "<technique_common><accessor source='#" + id + "a' count='1' stride='" +
           std::to_string(stride) + "'><param type='" + type + "'/></accessor></technique_common></source>";
  };
  const std::string none = "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1";
  return "<library_controllers><controller id='c'><skin source='#g'>" + matrix +
         source("j", "<Name_array id='ja' count='1'>a</Name_array>", "name", 1) +
         source("b", "<float_array id='ba' count='16'>" + none + "</float_array>", "float4x4", 16) +
         source("w", "<float_array id='wa' count='1'>1</float_array>", "float", 1) +
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

// It was read unseen.
TEST_F(ReadMeshTest, AColladaThatIsPackedIsRefused) {
  for (const char* name : {"a.zae", "a.ZAE", "a.dae", "a.xml"})
    EXPECT_EQ(refusal(file(name, "PK\3\4")), "is a packed COLLADA file, which is not read");
}

// assimp looks into it for the format.
TEST_F(ReadMeshTest, AColladaByAnotherNameIsRefusedAlike) {
  const std::string skewed = collada(node("<skew>45 0 1 0 1 0 0</skew>" + std::string(kShown)));
  EXPECT_EQ(refusal(file("a.xml", skewed)), "places its parts by <skew>, which is not read");
  EXPECT_EQ(refusal(file("a.xml", collada(node(kShown)))), "not refused");
  const std::string turned = collada(node("<lookat>1 2 3 0 0 0 0 1 0</lookat>" + node(kShown)));
  for (const char* name : {"a.gltf", "a.GLB"})
    EXPECT_EQ(refusal(file(name, turned)), "holds another format than the ending of its name says") << name;
  for (const char* name : {"a.csm", "a.obj", "a.ase", "a.x3db"})  // To these endings alone it keeps.
    EXPECT_EQ(refusal(file(name, turned)), "holds no triangle") << name;
  for (const char* name : {"a", "a.zip", "a.dae.old"})
    EXPECT_EQ(refusal(file(name, collada(node(kShown)))), "has a name whose ending says no format") << name;
}

// assimp looks into these for it as well, past what is asked of an AMF.
TEST_F(ReadMeshTest, AnAmfByAnotherNameIsRefused) {
  const std::string corners =
      "<vertex><coordinates><x>0</x><y>0</y><z>0</z></coordinates></vertex><vertex><coordinates><x>2</x><y>0</y><z>0</"
      "z>"
      "</coordinates></vertex><vertex><coordinates><x>0</x><y>3</y><z>0</z></coordinates></vertex>";
  const std::string amf =
      "<?xml version='1.0'?><amf unit='millimeter'><object id='0'><mesh><vertices>" + corners +
      "</vertices><volume><triangle><v1>0</v1><v2>1</v2><v3>2</v3></triangle></volume></mesh></object>";
  const std::string turned = "<constellation id='1'><instance objectid='0'><rx>90</rx></instance></constellation>";
  EXPECT_EQ(refusal(file("a.amf", amf + "</amf>")), "not refused");
  for (const char* name : {"a.xml", "a.gltf"}) {
    try {
      (void)readMesh(file(name, amf + turned + "</amf>"), "the test", never);
      ADD_FAILURE() << name << " was read";
    } catch (const MeshError& error) {
      EXPECT_STREQ(error.what(), "holds another format than the ending of its name says") << name;
      EXPECT_EQ(error.remedy, "end its name with .amf, by which it is checked and read") << name;
    }
  }
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

// It was felt as at rest.
TEST_F(ReadMeshTest, ASkinOfColladaThatIsPosedIsRefused) {
  const auto at = [](const std::string& joint, const std::string& mesh) {
    return collada("<node id='n' sid='a' name='a' type='JOINT'>" + joint + "</node>" +
                       node(mesh + "<instance_controller url='#c'><skeleton>#n</skeleton></instance_controller>"),
                   kTriangle, skin("<bind_shape_matrix>1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1</bind_shape_matrix>"));
  };
  EXPECT_THAT(readMesh(file("a.dae", at("", "")), "the test", never).upper, ElementsAre(2, 3, 0));
  EXPECT_EQ(refusal(file("a.dae", at("<rotate>0 0 1 0.001</rotate>", ""))), "not refused");  // Rounding.
  EXPECT_EQ(refusal(file("a.dae", at("<rotate>0 0 1 30</rotate>", ""))),
            "holds a skin that its joints have moved from its rest, which is not read");
}

// assimp left the mesh out, and drew a bone in its place.
TEST_F(ReadMeshTest, AColladaWithShapeKeysIsRefused) {
  const std::string morph =
      "<library_controllers><controller id='c'><morph source='#g'/></controller></library_controllers>";
  EXPECT_EQ(refusal(file("a.dae", collada(node("<instance_controller url='#c'/>"), kTriangle, morph))),
            "holds a mesh with shape keys (<morph>), which is not read");
  EXPECT_EQ(refusal(file("a.bvh",
                         "HIERARCHY\nROOT hips\n{\nOFFSET 0 0 0\nCHANNELS 3 Xposition Yposition Zposition\n"
                         "End Site\n{\nOFFSET 0 1 0\n}\n}\nMOTION\nFrames: 1\nFrame Time: 0.1\n0 0 0\n")),
            "holds no triangle");
}

/** A triangle bound to one joint, that has been moved so far along x. */
std::string fbx(double moved) {
  const auto list = [](const char* name, int count, const std::string& numbers) {
    return std::string(name) + ": *" + std::to_string(count) + " {\na: " + numbers + "\n}\n";
  };
  const auto shift = [&](const char* name, int x) {
    return list(name, 16, "1,0,0,0,0,1,0,0,0,0,1,0," + std::to_string(x) + ",0,0,1");
  };
  return "; FBX 7.4.0 project file\nFBXHeaderExtension: {\nFBXHeaderVersion: 1003\nFBXVersion: 7400\n}\nObjects: {\n"
         "Geometry: 1, \"Geometry::body\", \"Mesh\" {\n" +
         list("Vertices", 9, "0,0,0,2,0,0,0,3,0") + list("PolygonVertexIndex", 3, "0,1,-3") +
         "}\nModel: 2, \"Model::body\", \"Mesh\" {\nVersion: 232\n}\nModel: 3, \"Model::arm\", \"LimbNode\" "
         "{\nVersion: "
         "232\nProperties70: {\nP: \"Lcl Translation\", \"Lcl Translation\", \"\", \"A\"," +
         std::to_string(5 + moved) +
         ",0,0\n}\n}\nDeformer: 4, \"Deformer::skin\", \"Skin\" {\nVersion: 101\n}\n"
         "Deformer: 5, \"SubDeformer::arm\", \"Cluster\" {\nVersion: 100\n" +
         list("Indexes", 3, "0,1,2") + list("Weights", 3, "1,1,1") + shift("Transform", -5) +
         shift("TransformLink", 5) +
         "}\n}\nConnections: {\nC: \"OO\",2,0\nC: \"OO\",3,0\nC: \"OO\",1,2\nC: \"OO\",4,1\nC: \"OO\",5,4\nC: "
         "\"OO\",3,5\n}\n";
}

TEST_F(ReadMeshTest, ASkinOfFbxIsReadAtItsRestAlone) {
  EXPECT_THAT(readMesh(file("a.fbx", fbx(0)), "the test", never).upper, ElementsAre(2, 3, 0));
  EXPECT_EQ(refusal(file("a.fbx", fbx(2))), "holds a skin that its joints have moved from its rest, which is not read");
}

}  // namespace
}  // namespace hapticd_mesh_file
