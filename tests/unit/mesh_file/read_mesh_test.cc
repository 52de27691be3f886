// Mesh files: joined, merged through their node transforms, and refused by name when they hold nothing to touch.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <functional>
#include <numbers>
#include <random>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/process/temporary_directory.h"
#include "tests/unit/mesh_file/mesh_files.h"
#include "tools/mesh_file/child.h"
#include "tools/mesh_file/own/words.h"
#include "tools/mesh_file/polygon.h"

namespace hapticd_mesh_file {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

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

TEST_F(ReadMeshTest, JoinsEqualVertices) {
  const MeshFile mesh = readMesh(file("t.stl", tetrahedron()), "the test", never);
  EXPECT_EQ(mesh.triangles.size(), 4u);
  EXPECT_EQ(mesh.vertices.size(), 4u);
  EXPECT_THAT(mesh.lower, ElementsAre(0, 0, 0));
  EXPECT_THAT(mesh.upper, ElementsAre(2, 3, 5));
}

TEST_F(ReadMeshTest, MinusZeroIsZero) {
  // Four of the twelve corners say -0.
  std::string text = tetrahedron();
  text.replace(text.find("vertex 0 0 0"), 12, "vertex -0 0 -0");
  EXPECT_EQ(readMesh(file("t.stl", text), "the test", never).vertices.size(), 4u);
}

// assimp left out lines that begin with blanks, in silence, and refused the others.
TEST_F(ReadMeshTest, AnObjMayBeIndentedAndHaveComments) {
  const std::string vertices = "v 0 0 0\nv 2 0 0\nv 0 3 0\nv 0 0 5\n";
  for (const char* const faces :
       {"f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n", "f 1 3 2\n  f 1 2 4\n\tf 1 4 3\r\nf 2 \\\n  3 4\n",
        "g a#1\nf 1 3 2 # the first\nf 1 2 4#\n # none\nf 1 4 3\nf 2 3 4 # of four"}) {
    for (const char* const mark : {"", "\xef\xbb\xbf"}) {
      const MeshFile mesh = readMesh(file("a.obj", mark + vertices + faces), "the test", never);
      EXPECT_EQ(mesh.triangles.size(), 4u) << faces;
      EXPECT_THAT(mesh.upper, ElementsAre(2, 3, 5)) << faces;
    }
  }
}

// assimp left out the vertex, and faces named others or none.
TEST_F(ReadMeshTest, AnObjNeedsNoDigitBeforeThePoint) {
  const MeshFile mesh = readMesh(
      file("a.obj",
           "v 0 0 0\nv .5 -.5 0\nv 0 \\\n .25\t.125\nvt .5 .5\n v\t0 0 .75e1\nusemtl .a\nf -4 -2 -3\nf -4 -3 -1\n"),
      "the test", never);
  EXPECT_EQ(mesh.triangles.size(), 2u);
  EXPECT_THAT(mesh.lower, ElementsAre(0, -0.5, 0));
  EXPECT_THAT(mesh.upper, ElementsAre(0.5, 0.25, 7.5));
  const std::string as_long = "v 0 0 0\n v .5 0 0\nv 0 1 0\nf 1 2 3\n";  // As before, when it is put right.
  EXPECT_THAT(readMesh(file("a.obj", as_long), "the test", never).upper, ElementsAre(0.5, 1, 0));
}

// assimp made a line of it: a hole, and a note of one line left out.
TEST_F(ReadMeshTest, AnObjThatEndsInAFaceIsRefused) {
  const std::string text = "v 0 0 0\nv 2 0 0\nv 0 3 0\nv 0 0 5\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4";
  EXPECT_EQ(refusal(file("a.obj", text)), "not refused");
  for (const char* const end : {"", "\n", " \r\n\n"}) {
    EXPECT_EQ(refusal(file("a.obj", text.substr(0, text.size() - 2) + end)),
              "is cut short: its last face has 2 corners");
    EXPECT_EQ(refusal(file("a.OBJ", text.substr(0, text.size() - 6) + end)),
              "is cut short: its last face has 0 corners");
    EXPECT_EQ(refusal(file("a.obj", text + "\nl 1 2" + end)), "not refused");
    EXPECT_EQ(refusal(file("a.obj", text.substr(0, text.size() - 2) + " \\\n 4" + end)), "not refused");
  }
}

/** The tetrahedron in words; what else stands in its header and among its values. */
struct PlyText {
  std::string before_vertices, before_faces, vertex_property, face_property;  ///< Of the header.
  std::string values_before, values_between, faces = "3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
  std::string face_element = "element face 4\nproperty list uchar int vertex_indices\n";

  [[nodiscard]] std::string text() const {
    return "ply\nformat ascii 1.0\ncomment by a test\n" + before_vertices + "element vertex 4\n" + vertex_property +
           "property float x\nproperty float y\nproperty float z\n" + before_faces + face_element + face_property +
           "end_header\n" + values_before + "0 0 0\n2 0 0\n0 3 0\n\n 0 +0 5e0\n" + values_between + faces;
  }
};

// It was opened, closed and opened again: who wrote it had lost its reader by then, and the second opening had none.
TEST_F(ReadMeshTest, APipeIsReadOnceOrNotAtAll) {
  const std::string text[] = {tetrahedron(), "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", PlyText().text()};
  int i = 0;
  for (const char* const name : {"p.stl", "p.off", "p.ply"}) {
    const std::string pipe = (directory_ / name).string();
    ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
    std::thread writer([&] { std::ofstream(pipe) << text[i]; });
    EXPECT_EQ(refusal(pipe), "not refused");
    writer.join();
    ++i;
  }
  for (const char* const name : {"p.obj", "p"}) {
    const std::string pipe = (directory_ / name).string();
    ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
    EXPECT_EQ(refusal(pipe), "is no file on a disk, and is read more than once");
  }
}

// assimp took the numbers of elements that it did not know for corners, and of strips read one triangle.
TEST_F(ReadMeshTest, WhatCannotBeReadOfAFileIsNotTakenForZeros) {
  const std::string shorter = "/sys/devices/system/cpu/online";  // Of 4096 bytes, says the kernel.
  std::ifstream file(shorter);
  std::string first;
  if (!std::getline(file, first)) GTEST_SKIP() << "no " << shorter;
  EXPECT_EQ(bytesOf(shorter), first + '\n');
}

TEST_F(ReadMeshTest, APlyMayHoldMoreThanVerticesAndFaces) {
  const auto expectTetrahedron = [this](const std::string& text) {
    const MeshFile mesh = readMesh(file("a.ply", text), "the test", never);
    EXPECT_EQ(mesh.triangles, (std::vector<std::array<std::uint32_t, 3>>{{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {2, 1, 3}}));
    EXPECT_THAT(mesh.upper, ElementsAre(2, 3, 5));
  };
  const std::string camera = "element camera 2\nproperty float focus\nproperty list uchar int marks\n",
                    cameras = "1.5 2 7 8\n2.5 0\n";
  PlyText plain;
  expectTetrahedron(plain.text());
  PlyText first = plain, between = plain, strips = plain;
  first.before_vertices = between.before_faces = camera;
  first.values_before = between.values_between = cameras;
  expectTetrahedron(first.text());
  expectTetrahedron(between.text());
  strips.face_element = "element tristrips 1\nproperty list int int vertex_indices\n";
  strips.faces = "11 0 2 1 3 -1 0 3 2 -1 0 1\n";
  const MeshFile mesh = readMesh(file("s.ply", strips.text()), "the test", never);
  EXPECT_EQ(mesh.triangles, (std::vector<std::array<std::uint32_t, 3>>{{0, 1, 2}, {2, 1, 3}, {0, 3, 1}}));
}

TEST_F(ReadMeshTest, APlyThatLacksNumbersIsRefused) {
  const std::string text = PlyText().text();
  EXPECT_EQ(refusal(file("a.ply", text.substr(0, text.rfind("3 1 2 3")))), "is cut short: it ends before face 3 of 4");
  EXPECT_THAT(refusal(file("a.ply", text.substr(0, text.size() - 3))), HasSubstr("face 3 of 4 has too few"));
  const auto told = [&](const std::string& what, const std::string& lie) {
    std::string lying = text;
    lying.replace(lying.find(what), what.size(), lie);
    return refusal(file("a.ply", lying));
  };
  EXPECT_EQ(told("3 0 1 3", "3 0 1 -3"), "face 1 names vertex -3");
  EXPECT_EQ(told("3 0 1 3", "3 0 1 4"), "triangle 1 names vertex 4 of 4");
  EXPECT_EQ(told("3 0 1 3", "-3 0 1 3"), "face 1 of 4 has a list of -3");
  EXPECT_THAT(told("2 0 0", "2 0 1e999"), HasSubstr("has a vertex at"));
  EXPECT_THAT(told("2 0 0", "2 0 x\x1b"), HasSubstr("vertex 1 of 4: 'x?' is not a number"));
  EXPECT_THAT(told("vertex 4", "vertex 4000000000"), HasSubstr("is cut short"));
  EXPECT_THAT(told("property float z\n", ""), HasSubstr("no x, y and z"));
  EXPECT_THAT(told("float z", "quad z"), HasSubstr("no kind of number"));
  EXPECT_THAT(told("ascii", "binary"), HasSubstr("of a format that is not known"));
  EXPECT_EQ(told("end_header", "end"), "its header has no end");
}

// Of -0.01 the first byte is a line's end, which assimp took for one of the header's: one binary PLY in 256.
TEST_F(ReadMeshTest, ABinaryPlyMayBeginWithAnyByte) {
  for (const char* const ending : {"\n", "\r\n"}) {
    for (unsigned first = 0; first < 256; first += first < 16 ? 1 : 16) {
      std::array<float, 9> corners{-0.01f, 0, 0, 1, 0, 0, 0, 1, 0};
      std::memcpy(corners.data(), &first, 1);
      std::string text;
      for (const char* const line :
           {"ply", "format binary_little_endian 1.0", "element vertex 3", "property float x", "property float y",
            "property float z", "element face 1", "property list uchar int vertex_indices", "end_header"})
        text += std::string(line) + ending;
      text.append(reinterpret_cast<const char*>(corners.data()), sizeof corners);
      text.append("\3\0\0\0\0\1\0\0\0\2\0\0\0", 13);
      const MeshFile mesh = readMesh(file("a.ply", text), "the test", never);
      ASSERT_EQ(mesh.vertices.size(), 3u) << first;
      EXPECT_EQ(mesh.vertices[0][0], corners[0]) << first;
      EXPECT_EQ(mesh.triangles, (std::vector<std::array<std::uint32_t, 3>>{{0, 1, 2}}));
    }
  }
}

TEST_F(ReadMeshTest, MergesMeshesThroughTheirNodes) {
  // Two nodes show one triangle: one moved by x = 10, the other mirrored in x, which must not turn its winding.
  const MeshFile mesh = readMesh(file("two.gltf", R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,1]}],
    "nodes":[{"mesh":0,"translation":[10,0,0]},{"mesh":0,"scale":[-1,1,1]}],
    "meshes":[{"primitives":[{"attributes":{"POSITION":0},"mode":4}]}],
    "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}],
    "bufferViews":[{"buffer":0,"byteLength":36}],
    "buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})"),
                                 "the test", never);
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

// assimp moved a part that is turned by 90 degrees about z by 90 along z, and one turned by none back.
TEST_F(ReadMeshTest, AnAmfThatTurnsItsPartsIsRefused) {
  const auto amf = [](const std::string& instance) {
    std::string corners;
    for (const char* const x : {"0", "1", "2"})
      corners +=
          "<vertex><coordinates><x>" + std::string(x) + "</x><y>" + x + x + "</y><z>1</z></coordinates></vertex>";
    return "<?xml version=\"1.0\"?><amf unit=\"millimeter\"><object id=\"0\"><mesh><vertices>" + corners +
           "</vertices><volume><triangle><v1>0</v1><v2>1</v2><v3>2</v3></triangle></volume></mesh></object>"
           "<constellation id=\"1\"><instance objectid=\"0\"/><instance objectid=\"0\">" +
           instance + "</instance></constellation></amf>";
  };
  EXPECT_EQ(refusal(file("a.amf", amf("<deltax>10</deltax><rz> 90 </rz>"))), "turns its parts (rz), which is not read");
  EXPECT_EQ(refusal(file("a.amf", amf("<deltax>10</deltax><rx>0</rx>"))), "turns its parts (rx), which is not read");
  const MeshFile mesh = readMesh(file("a.amf", amf("<deltax>10</deltax><rz>0</rz>")), "the test", never);
  EXPECT_EQ(mesh.triangles.size(), 2u);
  EXPECT_THAT(mesh.upper, ElementsAre(12, 22, 1));
}

// Of an L three corners lie in a line: cut off along it, its hollow had a lid in the air.
TEST_F(ReadMeshTest, NoLidLiesOverTheHollowOfAPolygon) {
  const std::string text =
      "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nv 0 0 2\nv 2 0 2\nv 2 1 2\nv 1 1 2\nv 1 2 2\nv 0 2 2\n"
      "f 6 5 4 3 2 1\nf 7 8 9 10 11 12\nf 1 2 8 7\nf 2 3 9 8\nf 3 4 10 9\nf 4 5 11 10\nf 5 6 12 11\nf 6 1 7 12\n";
  const MeshFile mesh = readMesh(file("l.obj", text), "the test", never);
  EXPECT_EQ(mesh.triangles.size(), 20u);
  EXPECT_NEAR(areaOf(mesh), 22, 1e-6);
}

TEST_F(ReadMeshTest, APolygonKeepsItsHoleAndTheCornersOnItsSides) {
  // A frame: its hole is joined to the rim by a doubled edge.
  const MeshFile frame = readMesh(file("frame.obj",
                                       "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\nv 1 1 0\nv 1 3 0\nv 3 3 0\n"
                                       "v 3 1 0\nf 1 5 6 7 8 5 1 2 3 4\n"),
                                  "the test", never);
  EXPECT_EQ(frame.triangles.size(), 8u);
  EXPECT_NEAR(areaOf(frame), 12, 1e-6);
  const MeshFile halved = readMesh(
      file("halved.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 1 1 0\nv 0 2 0\nv 0 1 0\nf 1 2 3 4 5 6\n"), "the test", never);
  ASSERT_EQ(halved.triangles.size(), 4u);
  for (const auto& t : halved.triangles) {
    MeshFile one = halved;
    one.triangles = {t};
    EXPECT_NEAR(areaOf(one), 0.5, 1e-6) << "none is without area";
  }
}

// Each ear was held against every inner corner: a minute for this one.
TEST(Polygon, OfManyCornersIsCutInTime) {
  constexpr int kCorners = 200'000;
  std::vector<std::array<float, 3>> corners;
  std::mt19937 random(1);
  std::uniform_real_distribution<double> radius(0.2, 1.2);
  for (int i = 0; i < kCorners; ++i) {
    const double a = 2 * std::numbers::pi * i / kCorners, r = radius(random);
    corners.push_back({static_cast<float>(r * std::cos(a)), static_cast<float>(r * std::sin(a)), 0});
  }
  const auto twice = [&](std::size_t i, std::size_t k) {
    return double{corners[i][0]} * double{corners[k][1]} - double{corners[i][1]} * double{corners[k][0]};
  };
  double all = 0, sum = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) all += twice(i, (i + 1) % corners.size());
  const std::clock_t begin = std::clock();
  const auto triangles = trianglesOf(corners);
  EXPECT_LT(static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC, 15);
  ASSERT_EQ(triangles.size(), corners.size() - 2);
  for (const auto& t : triangles) sum += std::abs(twice(t[0], t[1]) + twice(t[1], t[2]) + twice(t[2], t[0]));
  EXPECT_NEAR(sum, all, 1e-9 * all) << "some overlap";
}

// assimp left out faces of more than nine corners, and what comments and colours stand about.
TEST_F(ReadMeshTest, AnOffFileMayHoldMoreThanPlacesAndTriangles) {
  const std::string places = "0 0 0\n2 0 0\n0 3 0\n0 0 5\n", faces = "3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
  for (const std::string& text :
       {"OFF\n4 4 6\n" + places + faces, "OFF 4 4 0\n" + places + faces + "# the end\n", "OFF4 4 0\n" + places + faces,
        "4 4\n" + places + faces, "\xef\xbb\xbfOFF # t\r\n\n# of four\n4 4 6\r\n" + places + "\n" + faces,
        "COFF\n4 4 6\n0 0 0 1 0 0 1\n2 0 0 1 0 0 1\n0 3 0 1 0 0 1\n0,0 0 5 1 0 0 1 # the last\n3 0 2 1 0.5 0.5 1\n" +
            faces.substr(8)}) {
    const MeshFile mesh = readMesh(file("a.OFF", text), "the test", never);
    EXPECT_EQ(mesh.triangles.size(), 4u) << text;
    EXPECT_THAT(mesh.upper, ElementsAre(2, 3, 5)) << text;
  }
  std::string ring = "OFF\n20 1 0\n", face = "20";
  for (int i = 0; i < 20; ++i) {
    ring += std::to_string(std::cos(0.1 * std::numbers::pi * i)) + " " +
            std::to_string(std::sin(0.1 * std::numbers::pi * i)) + " 0\n";
    face += " " + std::to_string(i);
  }
  const MeshFile disc = readMesh(file("disc", ring + face), "the test", never);  // Told by its first word.
  EXPECT_EQ(disc.triangles.size(), 18u);
  EXPECT_NEAR(areaOf(disc), 10 * std::sin(0.1 * std::numbers::pi), 1e-5);
}

// assimp made corners of what a cut line lacks, and of a negative number another one.
TEST_F(ReadMeshTest, AnOffFileThatIsNotWholeIsRefused) {
  const std::string text = "OFF\n4 4 6\n0 0 0\n2 0 0\n0 3 0\n0 0 5\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
  const auto told = [&](const std::string& what, const std::string& lie) {
    std::string lying = text;
    lying.replace(lying.find(what), what.size(), lie);
    return refusal(file("a.off", lying));
  };
  EXPECT_EQ(told("3 1 2 3\n", "3 1 2"), "face 3 of 4 has too few numbers in its line");
  EXPECT_EQ(told("3 1 2 3\n", ""), "is cut short: it ends before face 3 of 4");
  EXPECT_EQ(told("3 1 2 3\n", "3 1 2 -1\n"), "face 3 of 4 names vertex -1 of 4");
  EXPECT_EQ(told("3 1 2 3\n", "3 1 2 4\n"), "face 3 of 4 names vertex 4 of 4");
  EXPECT_EQ(told("3 1 2 3\n", "3 1 2 1.5\n"), "face 3 of 4 names vertex 1.5 of 4");
  EXPECT_EQ(told("3 1 2 3\n", "-3 1 2 3\n"), "face 3 of 4 has -3 corners");
  EXPECT_EQ(told("3 1 2 3\n", "3 1 2 3\n3 1 2 3\n"), "has more lines than its 4 vertices and 4 faces");
  EXPECT_EQ(told("2 0 0", "2 x\x1b 0"), "vertex 1 of 4: 'x?' is not a number");
  EXPECT_EQ(told("4 4 6", "4 many 6"), "does not say how many faces it has: 'many'");
  EXPECT_EQ(told("4 4 6", "4000000000 4 6"), "is cut short: it ends before vertex 8 of 4000000000");
  EXPECT_EQ(told("OFF", "OFF BINARY"), "is OFF of a kind that is not read: 'OFF BINARY'");
  EXPECT_THAT(told("OFF", "4OFF"), HasSubstr("of a kind that is not read"));
  EXPECT_THAT(told("2 0 0", "2 0 1e999"), HasSubstr("has a vertex at"));
}

// A scan in a surveyor's coordinates became a staircase, or triangles without area.
TEST_F(ReadMeshTest, WhatLiesTooFarFromTheOriginToBeFineIsRefused) {
  const auto at = [](double x) { return fmt::format("v {0} 0 0\nv {1} 0 0\nv {0} 0.5 0\nf 1 2 3\n", x, x + 1); };
  EXPECT_EQ(refusal(file("a.obj", at(-4000))), "not refused");
  EXPECT_EQ(refusal(file("a.obj", at(-10001))),
            "is 1 long and lies 1e+04 from the origin, where its coordinates come in steps of 0.00098");
  EXPECT_THAT(refusal(file("a.obj", at(512345))), HasSubstr("in steps of 0.031"));
  EXPECT_EQ(refusal(file("a.obj", "v 1e9 0 0\nf 1 1 1\n")), "not refused");  // A point.
}

TEST_F(ReadMeshTest, RefusesWhatCannotBeTouched) {
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

// assimp wanted `solid` first and in small letters, normals that are numbers, and no byte too many.
TEST_F(ReadMeshTest, AnStlIsReadAsProgramsWriteIt) {
  const std::string text = tetrahedron();
  const auto with = [&](const std::string& what, const std::string& instead) {
    std::string out = text;
    for (std::size_t at = 0; (at = out.find(what, at)) != out.npos; at += instead.size())
      out.replace(at, what.size(), instead);
    return out;
  };
  std::string capitals = text, binary(84, ' '), normal(12, '\xff');
  for (char& c : capitals) c = static_cast<char>(std::toupper(c));
  binary.replace(80, 4, std::string("\4\0\0\0", 4));
  const MeshFile whole = readMesh(file("t.stl", text), "the test", never);
  for (const auto& t : whole.triangles) {
    binary += normal;
    for (const std::uint32_t v : t) binary.append(reinterpret_cast<const char*>(whole.vertices[v].data()), 12);
    binary += std::string(2, '\0');
  }
  std::string binary_solid = binary;
  binary_solid.replace(0, 7, "solid t");
  for (const std::string& as_written :
       {"\n \n" + text, "\xef\xbb\xbf" + text, capitals, with("\n", "\r"), with("\n", "\r\n"),
        with("normal 0 0 0", "normal -1.#IND nan(ind) 1,5"), with("normal 0 0 0", ""),
        with("vertex 2 0 0", "vertex 2,0 +0 0e5"), text + "solid facet of another\nendsolid\n",
        with("solid t", "solid facet normal"), binary, binary + "\n", binary + std::string(49, '\0'), binary_solid,
        binary_solid + "\n"}) {
    const MeshFile mesh = readMesh(file("a.Stl", as_written), "the test", never);
    EXPECT_EQ(mesh.triangles, whole.triangles) << as_written;
    EXPECT_EQ(mesh.vertices, whole.vertices) << as_written;
  }
  EXPECT_EQ(refusal(file("a.stl", with("vertex 2 0 0", "vertex 2 zero 0"))), "facet 1: 'zero' is not a number");
  EXPECT_EQ(refusal(file("a.stl", with("outer loop", "loop"))), "facet 1: 'vertex' stands where 'outer loop' should");
  EXPECT_EQ(refusal(file("a.stl", with("facet normal", "f normal"))), "'outer' stands behind facet 0, in none");
  EXPECT_EQ(refusal(file("a.stl", with("endloop\n", ""))), "facet 1: 'endfacet' stands where 'vertex' should");
  EXPECT_THAT(refusal(file("a.stl", binary + std::string(50, '\0'))), HasSubstr("binary STL of 4 triangles has 284"));
}

// In words assimp left out the facet; of the others it said that a storage representation could not be determined.
TEST_F(ReadMeshTest, AnStlThatIsCutShortIsRefused) {
  const std::string text = tetrahedron();
  const std::size_t last = text.rfind("facet normal"), end = text.rfind("endfacet");
  for (const std::size_t at : {last + 6, last + 30, end - 20, end - 1})
    EXPECT_EQ(refusal(file("t.stl", text.substr(0, at))), "is cut short: its last facet has no end") << at;
  EXPECT_EQ(refusal(file("t.STL", text.substr(0, text.rfind("endsolid")))), "not refused") << "its end is not missed";
  EXPECT_EQ(refusal(file("t.stl", text.substr(0, text.size() - 1) + " of a\tfacet\n")), "not refused");
  std::string lines = text.substr(0, text.rfind("endsolid"));  // A facet a line.
  for (std::size_t at = lines.find("facet"); (at = lines.find('\n', at)) != lines.npos; ++at)
    if (lines.substr(at - 8, 8) != "endfacet") lines[at] = ' ';
  EXPECT_EQ(readMesh(file("l.stl", lines), "the test", never).triangles.size(), 4u);
  EXPECT_EQ(refusal(file("l.stl", lines.substr(0, lines.size() - 9))), "is cut short: its last facet has no end");
  std::string binary(84 + 4 * 50, '\0');
  binary[80] = 4;
  EXPECT_EQ(refusal(file("b.stl", binary.substr(0, 200))),
            "is no STL in words ('solid'), and of 200 bytes; binary STL of 4 triangles has 284");
}

TEST_F(ReadMeshTest, NamesTheTriangleThatIsNotFinite) {
  EXPECT_THAT(refusal(file("nan.stl", tetrahedron("nan 0 0"))), HasSubstr("triangle 0 has a vertex at"));
  EXPECT_THAT(refusal(file("inf.stl", tetrahedron("inf 0 0"))), HasSubstr("triangle 0 has a vertex at"));
}

TEST_F(ReadMeshTest, WhatAReaderDiesOfIsSaid) {
  EXPECT_THAT(refusalOf([]() -> MeshFile { std::abort(); }), HasSubstr("the reader died of it (Aborted)"));
  EXPECT_EQ(refusalOf([]() -> MeshFile { throw std::runtime_error("of no kind"); }), "cannot be read");
}

// The message was that of std::bad_alloc, with the advice to fit the ending of the name.
TEST_F(ReadMeshTest, WhatMemoryCannotHoldIsSaid) {
  const std::string path = file("large.ply", PlyText().text());
  std::filesystem::resize_file(path, std::uintmax_t{1} << 34);  // Nearly all of it a hole.
  rlimit all{};
  ASSERT_EQ(::getrlimit(RLIMIT_AS, &all), 0);
  const rlimit some{std::min<rlim_t>(all.rlim_max, rlim_t{1} << 33), all.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_AS, &some), 0);
  EXPECT_EQ(refusal(path), "is too large for this machine's memory, or damaged");
  ASSERT_EQ(::setrlimit(RLIMIT_AS, &all), 0);
}

TEST_F(ReadMeshTest, AFileThatKeepsItsReaderBusyIsGivenUp) {
  int asked = 0;
  const auto busy = []() -> MeshFile {
    for (;;) ::pause();
  };
  EXPECT_THAT(refusalOf(busy, [&] { return ++asked > 20; }), HasSubstr("cancelled"));
  EXPECT_THROW((void)readMesh(file("a.ply", PlyText().text()), "the test", [] { return true; }), MeshError);
}

TEST_F(ReadMeshTest, TheRemedyNamesTheProgram) {
  try {
    (void)readMesh(file("t.xyz-unknown", "abc"), "the test", never);
    ADD_FAILURE() << "no such format";
  } catch (const MeshError& error) {
    EXPECT_THAT(error.remedy, HasSubstr("the test reads STL, OBJ"));
    EXPECT_EQ(error.code, "");
  }
}

}  // namespace
}  // namespace hapticd_mesh_file
