// X3D: shapes in their places, as the standard writes them and H3D does; what is not known is refused by name.
#include "tools/mesh_file/own/x3d.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "tests/unit/mesh_file/mesh_files.h"

namespace hapticd_mesh_file {
namespace {

using ::testing::DoubleNear;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class X3dTest : public ReadMeshTest {
 protected:
  static std::string x3d(const std::string& scene, const std::string& head = {}) {
    return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<X3D version='3.3'>" + head + "<Scene>" + scene +
           "</Scene></X3D>";
  }
  MeshFile read(const std::string& scene, const std::string& head = {}) {
    return readMesh(file("a.x3d", x3d(scene, head)), "the test", never);
  }
  std::string refused(const std::string& scene) { return refusal(file("a.x3d", x3d(scene))); }
};

/** What the triangles enclose, if they look outward. */
double volumeOf(const MeshFile& mesh) {
  double sum = 0;
  for (const auto& t : mesh.triangles) {
    std::array<std::array<double, 3>, 3> p{};
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t k = 0; k < 3; ++k) p[c][k] = double{mesh.vertices[t[c]][k]};
    for (std::size_t k = 0; k < 3; ++k)
      sum += p[0][k] * (p[1][(k + 1) % 3] * p[2][(k + 2) % 3] - p[1][(k + 2) % 3] * p[2][(k + 1) % 3]) / 6;
  }
  return sum;
}

// A tetrahedron of 0, 2 x, 3 y, 5 z.
const std::string kCoordinate = "<Coordinate point='0 0 0, 2 0 0, 0 3 0, 0 0 5'/>";
const std::string kFaces = "0 2 1 -1 0 1 3 -1, 0 3 2 -1 1 2 3";
const std::string kTetrahedron =
    "<Shape><IndexedFaceSet coordIndex='" + kFaces + "'>" + kCoordinate + "</IndexedFaceSet></Shape>";

TEST_F(X3dTest, FacesAreReadInEveryWayTheStandardWritesThem) {
  const std::string clockwise = "0 1 2 -1 0 3 1 -1 0 2 3 -1 1 3 2 -1";
  const std::string triangles = "0 2 1 0 1 3 0 3 2 1 2 3";
  std::string corners = "<Coordinate point='";
  for (const char* const p : {"0 0 0 0 3 0 2 0 0", "0 0 0 2 0 0 0 0 5", "0 0 0 0 0 5 0 3 0", "2 0 0 0 3 0 0 0 5"})
    corners += p + std::string(" ");
  corners += "'/>";
  for (const std::string& geometry : {
           "<IndexedFaceSet coordIndex='" + kFaces + "'>" + kCoordinate + "</IndexedFaceSet>",
           "<IndexedFaceSet ccw='false' coordIndex='" + clockwise + "'>" + kCoordinate + "</IndexedFaceSet>",
           "<IndexedTriangleSet index='" + triangles + "'>" + kCoordinate + "</IndexedTriangleSet>",
           "<TriangleSet>" + corners + "</TriangleSet>",
           "<TriangleStripSet stripCount='3 3 3 3'>" + corners + "</TriangleStripSet>",
           "<TriangleFanSet fanCount='3 3 3 3'>" + corners + "</TriangleFanSet>",
           "<IndexedTriangleStripSet index='0 2 1 3 0 -1 3 2 0'>" + kCoordinate + "</IndexedTriangleStripSet>",
           "<IndexedTriangleFanSet index='0 2 1 3 2 -1 1 2 3 -1'>" + kCoordinate + "</IndexedTriangleFanSet>",
       }) {
    const MeshFile mesh = read("<Shape><Appearance><Material/></Appearance>" + geometry + "</Shape>");
    EXPECT_EQ(mesh.triangles.size(), 4u) << geometry;
    EXPECT_NEAR(volumeOf(mesh), 5, 1e-6) << geometry;
  }
  const std::string square = "<Coordinate point='0 0 0 1 0 0 1 1 0 0 1 0'/>";
  EXPECT_NEAR(areaOf(read("<Shape><QuadSet>" + square + "</QuadSet></Shape>")), 1, 1e-6);
  EXPECT_NEAR(areaOf(read("<Shape><IndexedQuadSet index='3 2 1 0'>" + square + "</IndexedQuadSet></Shape>")), 1, 1e-6);
  const MeshFile tent =
      read("<Shape><ElevationGrid xDimension='3' zDimension='2' xSpacing='2' height='0 3 0 0 3 0'/></Shape>");
  EXPECT_THAT(tent.upper, ElementsAre(4, 3, 1));
  EXPECT_NEAR(areaOf(tent), 2 * std::sqrt(13), 1e-6);
}

// assimp drew the round ones with holes, or of other measures.
TEST_F(X3dTest, SolidsAreClosedAndOfTheirMeasures) {
  constexpr double kPi = std::numbers::pi;
  EXPECT_NEAR(volumeOf(read("<Shape><Box size='2 4 6'/></Shape>")), 48, 1e-6);
  EXPECT_NEAR(volumeOf(read("<Shape><Box/></Shape>")), 8, 1e-6);
  EXPECT_NEAR(volumeOf(read("<Shape><Sphere radius='3'/></Shape>")) / (36 * kPi), 1, 2e-3);
  EXPECT_NEAR(volumeOf(read("<Shape><Cylinder radius='3' height='4'/></Shape>")) / (36 * kPi), 1, 2e-3);
  EXPECT_NEAR(volumeOf(read("<Shape><Cone bottomRadius='3' height='4'/></Shape>")) / (12 * kPi), 1, 2e-3);
  EXPECT_THAT(read("<Shape><Cone/></Shape>").upper[1], 1) << "its tip";
  EXPECT_NEAR(areaOf(read("<Shape><Cylinder top='false' bottom='FALSE'/></Shape>")) / (4 * kPi), 1, 2e-3);
}

TEST_F(X3dTest, StandsWhereItsGroupsPutIt) {
  const auto boxOf = [this](const std::string& attributes) {
    const MeshFile mesh = read("<Transform " + attributes + ">" + kTetrahedron + "</Transform>");
    EXPECT_GT(volumeOf(mesh), 0) << attributes << ": also in a mirror";
    std::array<double, 6> out{};
    for (std::size_t k = 0; k < 3; ++k) out[k] = mesh.lower[k], out[k + 3] = mesh.upper[k];
    return out;
  };
  const auto near = [](double a, double b, double c, double d, double e, double f) {
    constexpr double kLittle = 1e-5;
    return ElementsAre(DoubleNear(a, kLittle), DoubleNear(b, kLittle), DoubleNear(c, kLittle), DoubleNear(d, kLittle),
                       DoubleNear(e, kLittle), DoubleNear(f, kLittle));
  };
  EXPECT_THAT(boxOf("translation='10 20 30'"), near(10, 20, 30, 12, 23, 35));
  EXPECT_THAT(boxOf("rotation='0 0 2 1.5707963'"), near(-3, 0, 0, 0, 2, 5)) << "the axis need not be a unit";
  EXPECT_THAT(boxOf("rotation='0 0 1 1.5707963' center='2 0 0'"), near(-1, -2, 0, 2, 0, 5));
  EXPECT_THAT(boxOf("scale='2 1 1' rotation='0 0 1 1.5707963' translation='1 0 0'"), near(-2, 0, 0, 1, 4, 5));
  EXPECT_THAT(boxOf("scale='-1 1 1'"), near(-2, 0, 0, 0, 3, 5));
  EXPECT_THAT(boxOf("scale='2 1 1' scaleOrientation='0 0 1 1.5707963'"), near(0, 0, 0, 2, 6, 5))
      << "twice as long in y";
  const MeshFile nested = read("<Transform translation='10 0 0'><Group><Transform rotation='0 0 1 1.5707963'>" +
                               kTetrahedron + "</Transform></Group></Transform>");
  EXPECT_NEAR(nested.lower[0], 7, 1e-5);
  const std::string inch = "<head><unit category='length' name='inch' conversionFactor='0.0254'/></head>";
  EXPECT_NEAR(read(kTetrahedron, inch).upper[2], 5 * 0.0254, 1e-7) << "in metres";
}

TEST_F(X3dTest, AnglesHaveTheirUnitToo) {
  const std::string degrees =
      "<head><unit category='angle' name='degree' conversionFactor='0.017453292519943295'/></head>";
  const MeshFile mesh = read("<Transform rotation='0 0 1 90'>" + kTetrahedron + "</Transform>", degrees);
  EXPECT_NEAR(mesh.lower[0], -3, 1e-5);
  EXPECT_NEAR(mesh.upper[1], 2, 1e-5);
}

/** Each file has its own units, and what names it has given its own already. */
TEST_F(X3dTest, AFileThatAnotherNamesIsAsLargeAsByItself) {
  const std::string mm = "<head><unit category='length' name='mm' conversionFactor='0.001'/></head>";
  (void)file("mm.x3d", x3d(kTetrahedron, mm));
  (void)file("m.x3d", x3d(kTetrahedron));
  EXPECT_NEAR(read("<Inline url='mm.x3d'/>", mm).upper[2], 0.005, 1e-7);
  EXPECT_NEAR(read("<Inline url='mm.x3d'/>").upper[2], 0.005, 1e-7);
  EXPECT_NEAR(read("<Inline url='m.x3d'/>", mm).upper[2], 5, 1e-5) << "without a unit it is in metres";
  EXPECT_NEAR(read("<Inline url='mm.x3d'/>" + kTetrahedron, mm).upper[2], 0.005, 1e-7) << "and then as before";
}

/** What no viewer shows is not felt. */
TEST_F(X3dTest, WhatIsNotVisibleIsNotThere) {
  const std::string box = "<Shape><Box size='1 1 1'/></Shape>", hidden = "<Shape visible='false'><Box/></Shape>";
  EXPECT_NEAR(volumeOf(read(box + hidden)), 1, 1e-6);
  EXPECT_NEAR(volumeOf(read(box + "<Transform visible='false'><Group>" + box + "</Group></Transform>")), 1, 1e-6);
  EXPECT_NEAR(volumeOf(read("<CADLayer visible='true false'>" + box + "<Shape><Box/></Shape>" + box + "</CADLayer>")),
              2, 1e-6);
  EXPECT_NEAR(volumeOf(read("<Group visible='false'><Shape DEF='S'><Box/></Shape></Group><Shape USE='S'/>")), 8, 1e-6);
}

TEST_F(X3dTest, WhatIsUsedAgainIsThereAgain) {
  const MeshFile mesh = read("<Shape DEF='S'><IndexedFaceSet DEF='G' coordIndex='" + kFaces + "'>" + kCoordinate +
                             "</IndexedFaceSet></Shape><Transform translation='10 0 0'><Shape USE='S'/></Transform>"
                             "<Transform translation='0 10 0'><Shape><IndexedFaceSet USE='G'/></Shape></Transform>"
                             "<Switch><Shape DEF='hidden'><Box size='1 1 1'/></Shape></Switch><Shape USE='hidden'/>");
  EXPECT_EQ(mesh.meshes, 4u);
  EXPECT_NEAR(volumeOf(mesh), 16, 1e-6);
  EXPECT_THAT(refused("<Shape USE='none'/>"), HasSubstr("uses 'none', which is not there before it"));
  EXPECT_THAT(refused("<Group DEF='A'><Group USE='A'/></Group>"), HasSubstr("nested"));
}

TEST_F(X3dTest, ShowsWhatASwitchChooses) {
  const std::string two = "<Shape><Box size='1 1 1'/></Shape><MetadataString/><Shape><Box size='2 2 2'/></Shape>";
  EXPECT_NEAR(volumeOf(read("<Switch whichChoice='1'>" + two + "</Switch>")), 8, 1e-6);
  EXPECT_NEAR(volumeOf(read("<LOD range='1'>" + two + "</LOD>")), 1, 1e-6) << "the finest";
  EXPECT_EQ(refused("<Switch>" + two + "</Switch>"), "holds no triangle");
}

// assimp refused them for their surfaces.
TEST_F(X3dTest, ReadsScenesOfH3d) {
  const MeshFile mesh = read(
      "<DeviceInfo><AnyDevice><Shape containerField='stylus'><Sphere radius='0.01'/></Shape></AnyDevice></DeviceInfo>"
      "<Viewpoint position='0 0 1'/><DynamicTransform mass='1' position='1 0 0' orientation='0 0 1 1.5707963'>"
      "<Shape><Appearance><Material/><FrictionalSurface staticFriction='0.5'/></Appearance>" +
      kTetrahedron.substr(7) + "</DynamicTransform>");
  EXPECT_EQ(mesh.meshes, 1u);
  EXPECT_NEAR(mesh.lower[0], -2, 1e-5);
}

TEST_F(X3dTest, NamesOtherFiles) {
  (void)file("other one.x3d", x3d(kTetrahedron));
  const MeshFile mesh =
      read("<Transform translation='10 0 0'><Inline url='\"http://x/y.x3d\" \"other%20one.x3d\"'/></Transform>");
  EXPECT_THAT(mesh.lower, ElementsAre(10, 0, 0));
  EXPECT_THAT(refused("<Inline url='none.x3d'/>"), HasSubstr("names a file that is not there: none.x3d"));
  EXPECT_THAT(refused("<Inline url='a.x3d'/>"), HasSubstr("nested")) << "itself";
}

TEST_F(X3dTest, LooksForWhatAnotherFileNamesBesideThatOne) {
  std::filesystem::create_directory(directory_ / "parts of it");
  (void)file("parts of it/screw.x3d", x3d("<Inline url='\"thread.x3d\"'/>"));
  (void)file("parts of it/thread.x3d", x3d(kTetrahedron));
  (void)file("thread.x3d", x3d("<Transform translation='100 0 0'>" + kTetrahedron + "</Transform>"));
  const MeshFile mesh = read(
      "<Inline url='parts%20of%20it/screw.x3d'/><Transform translation='10 0 0'><Inline "
      "url='thread.x3d'/></Transform>");
  EXPECT_THAT(mesh.lower, ElementsAre(0, 0, 0));
  EXPECT_THAT(mesh.upper, ElementsAre(112, 3, 5)) << "and the next one beside the first again";
  EXPECT_THAT(refused("<Inline url='parts%20of%20it/screw.x3d'/><Inline url='screw.x3d'/>"),
              HasSubstr("not there: screw.x3d"));
  EXPECT_THAT(refused("<Inline url='" + std::string(5000, 'a') + ".x3d'/>"),
              HasSubstr("names a file that is not there"));
}

TEST_F(X3dTest, LeavesOutNothingWithASurface) {
  EXPECT_THAT(refused("<Shape><Extrusion/></Shape>"), HasSubstr("'Extrusion', which is not read"));
  EXPECT_THAT(refused("<Strange>" + kTetrahedron + "</Strange>"), HasSubstr("'Strange', which is not known"));
  EXPECT_THAT(refused("<ProtoInstance name='Screw'/>" + kTetrahedron), HasSubstr("prototype"));
  const MeshFile mesh = read("<Shape><IndexedLineSet coordIndex='0 1 -1'>" + kCoordinate +
                             "</IndexedLineSet></Shape><Script>x</Script><NavigationInfo/>" + kTetrahedron);
  EXPECT_EQ(mesh.triangles.size(), 4u);
  EXPECT_EQ(mesh.skipped, 1u);
  EXPECT_THAT(refusal(file("a.wrl", "#VRML V2.0 utf8\n")), HasSubstr("VRML"));
}

TEST_F(X3dTest, SaysWhatIsDamaged) {
  const auto faces = [this](const std::string& index, const std::string& points) {
    return refused("<Shape><IndexedFaceSet coordIndex='" + index + "'><Coordinate point='" + points +
                   "'/></IndexedFaceSet></Shape>");
  };
  EXPECT_EQ(faces("0 1 2", "0 0 0 1 0 0 0 1 0"), "not refused");
  EXPECT_EQ(faces("0 1 3", "0 0 0 1 0 0 0 1 0"), "triangle 0 names vertex 3 of 3");
  EXPECT_EQ(faces("0 1 -2", "0 0 0 1 0 0 0 1 0"), "'IndexedFaceSet' names vertex -2");
  EXPECT_EQ(faces("0 1 2", "0 0 0 1 0 0 0 1"), "'Coordinate' has 8 numbers");
  EXPECT_EQ(faces("0 1 2", "0 0 0 1 0 0 0 1 x"), "point of 'Coordinate': 'x' is not a number");
  EXPECT_THAT(faces("0 1 2", "0 0 0 1 0 0 0 1 nan"), HasSubstr("has a vertex at"));
  EXPECT_EQ(refused("<Shape><TriangleStripSet stripCount='4'/></Shape>"),
            "'TriangleStripSet' has 0 vertices, and a run of 4 after 0");
  EXPECT_EQ(refused("<Shape><Box size='1 1'/></Shape>"), "size of 'Box' has 2 numbers, not 3");
  for (const char* const solid : {"Sphere radius='-1'", "Sphere radius='0'", "Sphere radius='nan'", "Box size='1 -1 1'",
                                  "Cylinder radius='-1'", "Cylinder height='0'", "Cone bottomRadius='0'"})
    EXPECT_THAT(refused(fmt::format("<Shape><{}/></Shape>", solid)), HasSubstr("is not above 0")) << solid;
  EXPECT_THAT(refused("<Shape><ElevationGrid xDimension='1e9' zDimension='1e9' height='1'/></Shape>"),
              HasSubstr("heights"));
  EXPECT_THAT(refusal(file("a.x3d", x3d(kTetrahedron).substr(0, 200))), HasSubstr("no whole XML"));
  EXPECT_EQ(refusal(file("a.x3d", "<svg/>")), "is no X3D");
  std::string deep;
  for (int i = 0; i < 100'000; ++i) deep += "<Group>";
  for (const char* const around : {"", "<Switch>", "<Strange>"})
    EXPECT_NE(refusal(file("a.x3d", "<X3D>" + std::string(around) + deep)), "not refused");
  for (int i = 0; i < 100'000; ++i) deep += "</Group>";
  for (const char* const around : {"Group", "Switch", "Strange"})
    EXPECT_THAT(refused(fmt::format("<{0}>{1}</{0}>", around, deep)), HasSubstr("nested more than")) << around;
}

}  // namespace
}  // namespace hapticd_mesh_file
