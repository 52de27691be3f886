// DXF: blocks that assimp would put elsewhere than the program that made the file.
#include "tools/mesh_file/assimp/dxf.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/mesh_file/mesh_files.h"

namespace hapticd_mesh_file {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

/** Groups "0 INSERT 2 PART", each word in a line of its own, as DXF has them. */
std::string lines(std::string words) {
  for (char& c : words)
    if (c == ' ') c = '\n';
  return words + "\n";
}

constexpr const char* kTwoFaces =
    "0 3DFACE 8 0 10 0 20 0 30 0 11 2 21 0 31 0 12 0 22 3 32 0 13 0 23 3 33 0 "
    "0 3DFACE 8 0 10 0 20 0 30 0 11 2 21 0 31 0 12 0 22 0 32 5 13 0 23 0 33 5 ";

/** A block PART, 2 x 3 x 5 with a corner at its base, further blocks, and what stands in the scene. */
std::string dxf(const std::string& entities, const std::string& blocks = {}, const char* base = "10 0 20 0 30 0") {
  return lines(
      fmt::format("0 SECTION 2 BLOCKS 0 BLOCK 8 0 2 PART 70 0 {} 3 PART {}0 ENDBLK 8 0 {}0 ENDSEC "
                  "0 SECTION 2 ENTITIES {} 0 ENDSEC 0 EOF",
                  base, kTwoFaces, blocks, entities));
}
std::string insert(const std::string& how, const char* block = "PART") {
  return fmt::format("0 INSERT 8 0 2 {} {}", block, how);
}

TEST_F(ReadMeshTest, BlocksOfADxfStandWhereTheyAreInserted) {  // With y up: y is at the back, -z.
  const auto box = [&](const std::string& text) { return readMesh(file("a.DXF", text), "the test", never); };
  MeshFile mesh = box(dxf(insert("10 10 20 20 30 30")));
  EXPECT_THAT(mesh.lower, ElementsAre(10, 30, -23));
  EXPECT_THAT(mesh.upper, ElementsAre(12, 35, -20));
  mesh = box(dxf(insert("10 10 20 0 30 0") + " " + insert("10 20 20 0 30 0 50 360 70 1 71 1 230 1.0 41 1 42 1.0"), "",
                 "10 1 20 0 30 0"));
  EXPECT_THAT(mesh.lower, ElementsAre(9, 0, -3));
  EXPECT_THAT(mesh.upper, ElementsAre(21, 5, 0));
  mesh = box(dxf(insert("10 0 20 0 30 0 41 2 42 3 43 4")));
  EXPECT_THAT(mesh.lower, ElementsAre(0, 0, -9));
  EXPECT_THAT(mesh.upper, ElementsAre(4, 20, 0));
}

// assimp left out turns, rows and what is nested, and scaled where a block stands with it, all without a word.
TEST_F(ReadMeshTest, ADxfThatInsertsBlocksOtherwiseIsRefused) {
  for (const auto& [how, what] : {std::pair("50 90", "turned"),
                                  {"50 -0.5", "turned"},
                                  {"70 3 44 10", "in rows"},
                                  {"71 2 45 10", "in rows"},
                                  {"210 0 220 0 230 -1", "upside down or on its side"},
                                  {"210 1 220 0 230 0", "upside down or on its side"},
                                  {"10 1 20 0 30 0 43 2", "scaled beside the origin"},
                                  {"41 -1", "mirrored"},
                                  {"42 0", "mirrored"}})
    EXPECT_EQ(refusal(file("a.dxf", dxf(insert(how)))),
              fmt::format("inserts the block 'PART' {}, which is not read", what));
  EXPECT_THAT(refusal(file("a.dxf", dxf(insert("42 2"), "", "10 0 20 1 30 0"))), HasSubstr("scaled beside"));
  const std::string outer =
      fmt::format("0 BLOCK 8 0 2 OUTER 70 0 10 0 20 0 30 0 3 OUTER {} 0 ENDBLK 8 0 ", insert("10 5 20 0 30 0"));
  EXPECT_THAT(refusal(file("a.dxf", dxf(std::string(kTwoFaces) + insert("", "OUTER"), outer))),
              HasSubstr("in another block"));
  std::string windows = dxf(insert("50 90"));
  for (std::size_t at = 0; (at = windows.find('\n', at)) != windows.npos; at += 2) windows.replace(at, 1, "\r\n");
  EXPECT_THAT(refusal(file("a.dxf", windows)), HasSubstr("turned"));
}

TEST_F(ReadMeshTest, BlocksOfADxfThatHaveNoFacesMayStandAnyhow) {
  const std::string arrows =
      "0 BLOCK 8 0 2 ARROW 70 0 10 0 20 0 30 0 3 ARROW 0 LINE 8 0 10 0 20 0 30 0 11 1 21 0 31 0 0 ENDBLK 8 0 "
      "0 BLOCK 8 0 2 *D1 70 0 10 0 20 0 30 0 3 *D1 " +
      insert("50 45", "ARROW") + " 0 ENDBLK 8 0 ";
  EXPECT_EQ(refusal(file("a.dxf", dxf(insert("10 1 20 0 30 0") + " " + insert("50 45 41 -2", "*D1") + " " +
                                          insert("50 1", "NOWHERE"),
                                      arrows))),
            "not refused");
  for (const auto& [flags, refused] : {std::pair("0", false), {"1", false}, {"8", false}, {"64", true}, {"65", true}}) {
    const std::string block = fmt::format(
        "0 BLOCK 8 0 2 SIGN 70 0 10 0 20 0 30 0 3 SIGN 0 POLYLINE 8 0 66 1 70 {} 0 VERTEX 8 0 10 0 20 0 30 0 0 SEQEND "
        "0 ENDBLK 8 0 ",
        flags);
    const std::string file = dxf(insert("50 45", "SIGN"), block);
    if (refused) {
      EXPECT_THROW(requirePlainInserts(file), MeshError) << flags;
    } else {
      EXPECT_NO_THROW(requirePlainInserts(file)) << flags;
    }
  }
  const std::string itself = "0 BLOCK 8 0 2 A 70 0 10 0 20 0 30 0 3 A " + insert("50 1", "A") + " 0 ENDBLK 8 0 ";
  EXPECT_NO_THROW(requirePlainInserts(dxf(insert("10 0"), itself)));
}

}  // namespace
}  // namespace hapticd_mesh_file
