// Packed files: small ones that unfold to gigabytes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <cstdlib>
#include <string_view>
#include <vector>

#include "tests/unit/mesh_file/mesh_files.h"

namespace hapticd_mesh_file {
namespace {

using ::testing::ElementsAre;

std::string number(std::uint32_t value, int bytes) {
  std::string out;
  for (int i = 0; i < bytes; ++i) out += static_cast<char>(value >> 8 * i & 255u);
  return out;
}

std::uint32_t crc32(std::string_view bytes) {
  std::uint32_t crc = ~0u;
  for (const char c : bytes) {
    crc ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
  }
  return ~crc;
}

/** A ZIP archive of files that are not packed. */
class Zip {
 public:
  /** `claimed`: the size it is said to have. */
  void add(const std::string& name, const std::string& bytes, std::uint32_t claimed) {
    const std::string common = number(20, 2) + number(0, 8) + number(crc32(bytes), 4) +
                               number(static_cast<std::uint32_t>(bytes.size()), 4) + number(claimed, 4) +
                               number(static_cast<std::uint32_t>(name.size()), 2) + number(0, 2);
    directory_ +=
        "PK\1\2" + number(20, 2) + common + number(0, 10) + number(static_cast<std::uint32_t>(files_.size()), 4) + name;
    files_ += "PK\3\4" + common + name + bytes;
    ++count_;
  }
  [[nodiscard]] std::string bytes() const {
    return files_ + directory_ + "PK\5\6" + number(0, 4) + number(count_, 2) + number(count_, 2) +
           number(static_cast<std::uint32_t>(directory_.size()), 4) +
           number(static_cast<std::uint32_t>(files_.size()), 4) + number(0, 2);
  }

 private:
  std::string files_, directory_;
  std::uint32_t count_ = 0;
};

/** A triangle; what describes it is said to have `more` bytes more than it has. */
std::string threeMf(std::uint32_t more) {
  const std::string rels =
      "<?xml version='1.0'?><Relationships xmlns='http://schemas.openxmlformats.org/package/2006/relationships'>"
      "<Relationship Target='/3D/m.model' Id='r' Type='http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel'/>"
      "</Relationships>";
  const std::string model =
      "<?xml version='1.0'?><model unit='millimeter' "
      "xmlns='http://schemas.microsoft.com/3dmanufacturing/core/2015/02'><resources><object id='1' type='model'><mesh>"
      "<vertices><vertex x='0' y='0' z='0'/><vertex x='2' y='0' z='0'/><vertex x='0' y='3' z='0'/></vertices>"
      "<triangles><triangle v1='0' v2='1' v3='2'/></triangles></mesh></object></resources><build><item objectid='1'/>"
      "</build></model>";
  Zip zip;
  zip.add("_rels/.rels", rels, static_cast<std::uint32_t>(rels.size()));
  zip.add("3D/m.model", model, static_cast<std::uint32_t>(model.size()) + more);
  return zip.bytes();
}

// Of a megabyte the reader took seven gigabytes, and whoever had less of them lost other programs.
TEST_F(ReadMeshTest, APackedFileUnfoldsToNoMoreThanItsSizeLetsExpect) {
  EXPECT_THAT(readMesh(file("a.3mf", threeMf(0)), "the test", never).upper, ElementsAre(2, 3, 0));
  EXPECT_EQ(refusal(file("a.3mf", threeMf(0xf0000000))), "holds more than 2048 MB, far more than its size lets expect");
}

TEST_F(ReadMeshTest, WhoTakesMoreMemoryThanItMayIsTold) {
  constexpr std::size_t kMost = 256 << 20;
  const auto told = [&](const std::function<MeshFile()>& read) {
    try {
      (void)readInChild(read, never, kMost);
    } catch (const MeshError& error) {
      return std::string(error.what());
    }
    return std::string("not refused");
  };
  const auto takes = [](std::size_t bytes) {
    return [bytes]() -> MeshFile {
      const std::vector<char> taken(bytes);
      return {};
    };
  };
  const std::string refused = "holds more than 256 MB, far more than its size lets expect";
  EXPECT_EQ(told(takes(kMost / 2)), "not refused");
  EXPECT_EQ(told(takes(2 * kMost)), refused);
  // An XML parser goes on without what it did not get, and finds nothing.
  const auto quiet = []() -> MeshFile {
    while (std::malloc(1 << 20) != nullptr) {
    }
    throw MeshError("holds no scene");
  };
  EXPECT_EQ(told(quiet), refused);
  EXPECT_EQ(told([]() -> MeshFile { throw MeshError("holds no scene"); }), "holds no scene");
}

}  // namespace
}  // namespace hapticd_mesh_file
