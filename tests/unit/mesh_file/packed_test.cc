// Packed files: small ones that unfold to gigabytes.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

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

std::uint32_t checkOf(std::string_view bytes) {
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
  /** `claimed`: the size it is said to have; `packed`: what stands there in place of the bytes. */
  void add(const std::string& name, const std::string& bytes, std::uint32_t claimed, const std::string& packed = {}) {
    const std::string& stands = packed.empty() ? bytes : packed;
    const std::string common = number(20, 2) + number(0, 2) + number(packed.empty() ? 0 : 8, 2) + number(0, 4) +
                               number(checkOf(bytes), 4) + number(static_cast<std::uint32_t>(stands.size()), 4) +
                               number(claimed, 4) + number(static_cast<std::uint32_t>(name.size()), 2) + number(0, 2);
    directory_ +=
        "PK\1\2" + number(20, 2) + common + number(0, 10) + number(static_cast<std::uint32_t>(files_.size()), 4) + name;
    files_ += "PK\3\4" + common + name + stands;
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

constexpr const char* kRelations =
    "<?xml version='1.0'?><Relationships xmlns='http://schemas.openxmlformats.org/package/2006/relationships'>"
    "<Relationship Target='/3D/m.model' Id='r' Type='http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel'/>"
    "</Relationships>";
constexpr const char* kMesh =
    "<mesh><vertices><vertex x='0' y='0' z='0'/><vertex x='2' y='0' z='0'/><vertex x='0' y='3' z='0'/></vertices>"
    "<triangles><triangle v1='0' v2='1' v3='2'/></triangles></mesh>";

std::string modelOf(const std::string& resources, const std::string& build) {
  return "<?xml version='1.0'?><model unit='millimeter' "
         "xmlns='http://schemas.microsoft.com/3dmanufacturing/core/2015/02'><resources>" +
         resources + "</resources><build>" + build + "</build></model>";
}

std::string packageOf(const std::string& model, std::uint32_t more = 0, const std::string& packed = {}) {
  Zip zip;
  zip.add("_rels/.rels", kRelations, static_cast<std::uint32_t>(std::string_view(kRelations).size()));
  zip.add("3D/m.model", model, static_cast<std::uint32_t>(model.size()) + more, packed);
  return zip.bytes();
}

/** A triangle; what describes it is said to have `more` bytes more than it has. */
std::string threeMf(std::uint32_t more) {
  return packageOf(modelOf(fmt::format("<object id='1' type='model'>{}</object>", kMesh), "<item objectid='1'/>"),
                   more);
}

/** Whatever it is, packed. */
std::string deflated(std::string bytes) {
  std::string out(bytes.size() + 1000, '\0');
  z_stream stream{};
  EXPECT_EQ(deflateInit2(&stream, 9, Z_DEFLATED, -MAX_WBITS, 8, Z_DEFAULT_STRATEGY), Z_OK);
  stream.next_in = reinterpret_cast<Bytef*>(bytes.data());
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
  out.resize(stream.total_out);
  EXPECT_EQ(deflateEnd(&stream), Z_OK);
  return out;
}

// What a printer breaks off was felt with the part, and a slicer's bodies, which are not even printed.
TEST_F(ReadMeshTest, APackageThatShowsWhatIsNoModelIsRefused) {
  const auto part = [](int id, const std::string& type) {
    return fmt::format("<object id='{}'{}>{}</object>", id, type.empty() ? "" : " type='" + type + "'", kMesh);
  };
  const std::string both = "<item objectid='1'/><item objectid='2' transform='1 0 0 0 1 0 0 0 1 10 0 0'/>";
  for (const char* const type : {"", "model", "surface"})
    EXPECT_THAT(
        readMesh(file("a.3mf", packageOf(modelOf(part(1, "model") + part(2, type), both))), "the test", never).upper,
        ElementsAre(12, 3, 0));
  for (const char* const type : {"support", "solidsupport", "other"}) {
    const std::string model = modelOf(part(1, "model") + part(2, type), both);
    const std::string expected = fmt::format("shows an object that is no part of the model: 2 is of type '{}'", type);
    EXPECT_EQ(refusal(file("a.3mf", packageOf(model))), expected);
    EXPECT_EQ(refusal(file("A.3MF", packageOf(model, 0, deflated(model)))), expected);
  }
  const std::string whole =
      "<object id='3'><components><component objectid='1'/><component objectid='2'/></components></object>";
  EXPECT_THAT(
      refusal(file("a.3mf", packageOf(modelOf(part(1, "") + part(2, "other") + whole, "<item objectid='3'/>")))),
      ::testing::HasSubstr("2 is of type 'other'"));
  EXPECT_EQ(refusal(file("a.3mf", packageOf(modelOf(part(1, "") + part(2, "other"), "<item objectid='1'/>")))),
            "not refused")
      << "nobody shows it";
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
    const void* volatile got = "";  // Else a compiler may leave them out.
    while (got != nullptr) got = std::malloc(1 << 20);
    throw MeshError("holds no scene");
  };
  EXPECT_EQ(told(quiet), refused);
  EXPECT_EQ(told([]() -> MeshFile { throw MeshError("holds no scene"); }), "holds no scene");
}

}  // namespace
}  // namespace hapticd_mesh_file
