// Mesh files: joined, merged through their node transforms, and refused by name when they hold nothing to touch.
#include "tools/hapticctl/mesh_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>

#include "tests/support/temporary_directory.h"
#include "tools/hapticctl/failure.h"

namespace hapticctl {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class MeshFileTest : public ::testing::Test {
 protected:
  std::string file(const std::string& name, const std::string& text) {
    std::ofstream(directory_ / name, std::ios::binary) << text;
    return (directory_ / name).string();
  }
  std::string refusal(const std::string& path) {
    try {
      (void)readMesh(path);
    } catch (const Failure& failure) {
      EXPECT_EQ(failure.exit, kExitFile);
      EXPECT_EQ(failure.where, path);
      return failure.what;
    }
    return "not refused";
  }

  hapticd::test::TemporaryDirectory temporary_;
  const std::filesystem::path directory_ = temporary_.path();
};

/** A tetrahedron of the four points 0, 2 x, 3 y, 5 z, each corner written three times as STL does. */
std::string tetrahedron(const std::string& origin = "0 0 0") {
  const std::string corner[4] = {origin, "2 0 0", "0 3 0", "0 0 5"};
  std::string out = "solid t\n";
  for (const auto& [a, b, c] : {std::array{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}) {
    out += "facet normal 0 0 0\nouter loop\n";
    for (const int i : {a, b, c}) out += "vertex " + corner[i] + "\n";
    out += "endloop\nendfacet\n";
  }
  return out + "endsolid t\n";
}

TEST_F(MeshFileTest, JoinsEqualVertices) {
  const MeshFile mesh = readMesh(file("t.stl", tetrahedron()));
  EXPECT_EQ(mesh.triangles.size(), 4u);
  EXPECT_EQ(mesh.vertices.size(), 4u);
  EXPECT_THAT(mesh.lower, ElementsAre(0, 0, 0));
  EXPECT_THAT(mesh.upper, ElementsAre(2, 3, 5));
}

TEST_F(MeshFileTest, MinusZeroIsZero) {
  // Four of the twelve corners say -0.
  std::string text = tetrahedron();
  text.replace(text.find("vertex 0 0 0"), 12, "vertex -0 0 -0");
  EXPECT_EQ(readMesh(file("t.stl", text)).vertices.size(), 4u);
}

TEST_F(MeshFileTest, MergesMeshesThroughTheirNodes) {
  // Two nodes show one triangle: one moved by x = 10, the other mirrored in x, which must not turn its winding.
  const MeshFile mesh = readMesh(file("two.gltf", R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,1]}],
    "nodes":[{"mesh":0,"translation":[10,0,0]},{"mesh":0,"scale":[-1,1,1]}],
    "meshes":[{"primitives":[{"attributes":{"POSITION":0},"mode":4}]}],
    "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}],
    "bufferViews":[{"buffer":0,"byteLength":36}],
    "buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})"));
  EXPECT_EQ(mesh.meshes, 2u);
  ASSERT_EQ(mesh.triangles.size(), 2u);
  EXPECT_EQ(mesh.vertices.size(), 6u);
  EXPECT_THAT(mesh.lower, ElementsAre(-1, 0, 0));
  EXPECT_THAT(mesh.upper, ElementsAre(11, 1, 0));
  for (const auto& t : mesh.triangles) {  // Both still face +z.
    const auto &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    EXPECT_GT((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]), 0);
  }
}

TEST_F(MeshFileTest, RefusesWhatCannotBeTouched) {
  EXPECT_EQ(refusal((directory_ / "none.stl").string()), "no such file");
  EXPECT_EQ(refusal(directory_.string()), "is a directory, not a mesh file");
  EXPECT_EQ(refusal(file("empty.stl", "")), "is empty");
  EXPECT_THAT(refusal(file("points.ply",
                           "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                           "property float z\nend_header\n0 0 0\n1 0 0\n0 1 0\n")),
              HasSubstr("no triangle"));
  EXPECT_THAT(refusal(file("lines.obj", "v 0 0 0\nv 1 0 0\nl 1 2\n")), HasSubstr("no triangle"));
  EXPECT_NE(refusal(file("text.stl", "this is no mesh at all, though it has the ending of one")), "not refused");
  EXPECT_NE(refusal(file("t.xyz-unknown", "abc")), "not refused");
}

TEST_F(MeshFileTest, NamesTheTriangleThatIsNotFinite) {
  EXPECT_THAT(refusal(file("nan.stl", tetrahedron("nan 0 0"))), HasSubstr("triangle 0 has a vertex at"));
  EXPECT_THAT(refusal(file("inf.stl", tetrahedron("inf 0 0"))), HasSubstr("triangle 0 has a vertex at"));
}

TEST_F(MeshFileTest, AFileThatIsCutShortEndsItsReaderAlone) {
  const std::string path = file("cut.ply",
                                "ply\nformat binary_little_endian 1.0\nelement vertex 3000\nproperty float x\n"
                                "property float y\nproperty float z\nelement face 7000\n"
                                "property list uchar int vertex_indices\nend_header\n" +
                                    std::string(100, 'x'));
  try {
    (void)readMesh(path);
    ADD_FAILURE() << "there is no mesh in it";
  } catch (const Failure& failure) {
    EXPECT_EQ(failure.exit, kExitFile);
    EXPECT_EQ(failure.where, path);
  }
}

TEST_F(MeshFileTest, AsksForAScale) {
  const MeshFile mesh = readMesh(file("t.stl", tetrahedron()));
  const std::string advice = scaleAdvice(mesh);
  EXPECT_THAT(advice, HasSubstr("its box is 2 x 3 x 5 file units"));
  EXPECT_THAT(advice, HasSubstr("--scale mm      would make it 2.00 mm x 3.00 mm x 5.00 mm"));
  EXPECT_THAT(advice, HasSubstr("--scale inch    would make it 50.8 mm x 76.2 mm x 127 mm"));
}

TEST_F(MeshFileTest, ScalesAndCentres) {
  MeshFile mesh = readMesh(file("t.stl", tetrahedron()));
  centre(mesh);
  scale(mesh, parseScale("cm"));
  EXPECT_NEAR(mesh.lower[2], -0.025, 1e-9);
  EXPECT_NEAR(mesh.upper[0], 0.01, 1e-9);
  for (const double wrong : {1e-60, 1e-30, 1e-5, 1e6}) {
    MeshFile other = mesh;
    try {
      scale(other, wrong);
      ADD_FAILURE() << wrong;
    } catch (const Failure& failure) {
      EXPECT_EQ(failure.where, "--scale");
      EXPECT_THAT(failure.what, HasSubstr("from 1e-06 to 200 m"));
      EXPECT_THAT(failure.remedy, HasSubstr("its box is 0.02 x 0.03 x 0.05 file units"));
    }
  }
}

TEST(Scale, IsAUnitOrAPositiveNumber) {
  EXPECT_EQ(parseScale("mm"), 1e-3);
  EXPECT_EQ(parseScale("in"), 0.0254);
  EXPECT_EQ(parseScale("0.0005"), 0.0005);
  for (const char* bad : {"0", "-1", "nan", "inf", "yard", ""}) EXPECT_THROW((void)parseScale(bad), Failure) << bad;
}

}  // namespace
}  // namespace hapticctl
