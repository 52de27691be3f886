// MetaImages and NRRDs whose values lie in several files, packed or not: read, or refused with the file that is not
// whole.
#include <fmt/core.h>

#include "tests/unit/import/ball.h"
#include "tools/hapticctl-import/header/data_files.h"
#include "tools/hapticctl-import/itk/scan_file.h"

namespace hapticctl_import::test {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr std::size_t kSlices = 16, kSliceBytes = 24 * 20 * 2;

/** A header that names files, and the files. */
struct Several : ::testing::Test {
  /** A slice in each of s00.raw to s15.raw, or so. */
  void put(bool packed, const std::string& ending) {
    for (std::size_t i = 0; i < kSlices; ++i) {
      const std::string values = samples().substr(i * kSliceBytes, kSliceBytes);
      (void)folder.put(fmt::format("s{:02}{}", i, ending), packed ? compressed(values) : values);
    }
  }
  static std::string listOf(const std::string& ending, std::size_t count = kSlices) {
    std::string names = "LIST";
    for (std::size_t i = 0; i < count; ++i) names += fmt::format("\ns{:02}{}", i, ending);
    return names + "\n";
  }
  /** Of metaImage(more). */
  Image read(const std::string& files, const std::string& more = "") {
    std::string header = metaImage(more);
    header.replace(header.find("LOCAL"), std::string::npos, files);
    return readScan(folder.put("several.mhd", header));
  }
  std::string told(const std::string& files, const std::string& more = "") {
    return refusal([&] { return read(files, more); });
  }
  static constexpr const char* kPacked = "CompressedData = True\n";
  Folder folder;
};

TEST_F(Several, AreReadLikeOne) {
  const Image one = readScan(folder.put("one.mha", metaImage() + samples()));
  put(false, ".raw");
  put(true, ".z");
  const std::string unix_list = listOf(".z");
  std::string dos_list;
  for (const char c : unix_list) dos_list += c == '\n' ? "\r\n" : std::string(1, c);
  for (const auto& [files, more] :
       {std::pair(listOf(".raw"), ""), std::pair(std::string("s%02d.raw 0 15 1\n"), ""), std::pair(unix_list, kPacked),
        std::pair(dos_list, kPacked), std::pair(std::string("s%02d.z 0 15 1\n"), kPacked),
        std::pair(std::string("s%02d.z 0\n"), kPacked)}) {
    const Image image = read(files, more);
    EXPECT_EQ(image.size, one.size) << files;
    EXPECT_EQ(image.values, one.values) << files;
  }
  for (std::size_t i = 0; i < kSlices * 20; ++i)
    (void)folder.put(fmt::format("r{:03}", i), compressed(samples().substr(i * 48, 48)));
  std::string rows = "LIST 1\n";
  for (std::size_t i = 0; i < kSlices * 20; ++i) rows += fmt::format("r{:03}\n", i);
  EXPECT_EQ(read(rows, kPacked).values, one.values) << "a row in each";
}

TEST_F(Several, EachMustBeWhole) {
  const std::string slice = samples().substr(7 * kSliceBytes, kSliceBytes), zlib = compressed(slice);
  put(true, ".z");
  for (const std::size_t missing : {std::size_t{1}, std::size_t{4}, std::size_t{5}, zlib.size() / 2, zlib.size()}) {
    (void)folder.put("s07.z", zlib.substr(0, zlib.size() - missing));
    for (const std::string& files : {listOf(".z"), std::string("s%02d.z 0 15 1\n")}) {
      EXPECT_THAT(told(files, kPacked), HasSubstr("s07.z: ")) << missing;
      EXPECT_THAT(told(files, kPacked),
                  HasSubstr(fmt::format("{} are needed: the compressed data are cut short", kSliceBytes)));
    }
  }
  std::string damaged = zlib;
  damaged.back() ^= 1;  // Of the checksum.
  (void)folder.put("s07.z", damaged);
  EXPECT_THAT(told(listOf(".z"), kPacked), HasSubstr("damaged"));
  (void)folder.put("s07.z", compressed(slice.substr(2)));
  EXPECT_THAT(told(listOf(".z"), kPacked), HasSubstr(fmt::format("{} bytes can be unpacked", kSliceBytes - 2)));
  put(false, ".raw");
  (void)folder.put("s07.raw", slice.substr(2));
  EXPECT_THAT(told(listOf(".raw")), HasSubstr(fmt::format("s07.raw: {} bytes are there", kSliceBytes - 2)));
  std::filesystem::remove(folder.path() + "/s07.raw");
  EXPECT_THAT(told(listOf(".raw")), HasSubstr("s07.raw: cannot be read"));
}

TEST_F(Several, ThereMustBeAsManyAsTheImageNeeds) {
  put(true, ".z");
  for (const auto& [files, words] : {std::pair(listOf(".z", 15), "names 15 files, 16 are needed"),
                                     std::pair(listOf(".z", 17), "more files, 16 are needed"),
                                     std::pair("LIST\n\n" + listOf(".z").substr(5), "names 0 files"),
                                     std::pair(std::string("LIST 1\ns00.z\n"), "320 are needed"),
                                     std::pair(std::string("LIST 3\ns00.z\n"), "MetaIO reads nothing"),
                                     std::pair(std::string("s%02d.z 0 14 1\n"), "names 15 files"),
                                     std::pair(std::string("s%02d.z 0 16 1\n"), "more files"),
                                     std::pair(std::string("s%02d.z 0 15\n"), "a step of at least 1"),
                                     std::pair(std::string("s%02d.z 0 15 0\n"), "a step of"),
                                     std::pair(std::string("s%s%n.z 0 15 1\n"), "one number such as %03d"),
                                     std::pair(std::string("s%d%d.z 0 15 1\n"), "one number"),
                                     std::pair(std::string("s%9999d.z 0 15 1\n"), "one number")}) {
    EXPECT_THAT(told(files, kPacked), HasSubstr(words)) << files;
  }
  EXPECT_THAT(told(listOf(".z"), "CompressedData = True\nCompressedDataSize = 99\n"),
              HasSubstr("CompressedDataSize: "));
  EXPECT_THAT(told(listOf(".z"), "CompressedData = True\nHeaderSize = 4\n"), HasSubstr("HeaderSize: "));
}

TEST_F(Several, OfANrrdToo) {
  put(false, ".raw");
  put(true, ".z");
  const auto readNrrd = [&](const std::string& encoding, const std::string& files) {
    return readScan(
        folder.put("several.nhdr", "NRRD0004\ntype: short\ndimension: 3\nsizes: 24 20 16\nendian: little\n" + encoding +
                                       "spacings: 1 1.5 2\ndata file: " + files));
  };
  const auto toldOf = [&](const std::string& encoding, const std::string& files) {
    return refusal([&] { return readNrrd(encoding, files); });
  };
  constexpr const char* kRaw = "encoding: raw\n";
  const Image one = readScan(folder.put("one.mha", metaImage() + samples()));
  for (const auto& [name, files] :
       {std::pair("list", listOf(".raw")), std::pair("pattern", std::string("s%02d.raw 0 15 1\n"))}) {
    EXPECT_EQ(readNrrd(kRaw, files).values, one.values) << name;
    const std::string slice = samples().substr(7 * kSliceBytes, kSliceBytes);
    (void)folder.put("s07.raw", slice.substr(2));
    EXPECT_THAT(toldOf(kRaw, files),
                HasSubstr(fmt::format("s07.raw: {} bytes are there, {} are", kSliceBytes - 2, kSliceBytes)));
    std::filesystem::remove(folder.path() + "/s07.raw");
    EXPECT_THAT(toldOf(kRaw, files), AllOf(HasSubstr("s07.raw\""), Not(HasSubstr("[nrrd]"))));
    (void)folder.put("s07.raw", slice);
  }
  EXPECT_THAT(toldOf(kRaw, listOf(".raw", 15)), HasSubstr("expected 16 filenames"));
  std::string back = "LIST\n";
  for (std::size_t i = kSlices; i-- > 0;) back += fmt::format("s{:02}.raw\n", i);
  EXPECT_EQ(readNrrd(kRaw, "s%02d.raw 15 0 -1\n").values, readNrrd(kRaw, back).values);
}

TEST(MetaImageFiles, AreNamedAsTheHeaderHasThem) {
  const auto names = [](const std::string& files) {
    return metaImageFiles("NDims = 3\nDimSize = 9 9 3\nElementDataFile = " + files);
  };
  EXPECT_THAT(names("LIST\na b.raw\r\n/c\nd"), ElementsAre("a b.raw", "/c", "d"));
  EXPECT_THAT(names("x%d.raw"), ElementsAre("x1.raw", "x2.raw", "x3.raw"));
  EXPECT_THAT(names("x%3d.raw 8 12 2"), ElementsAre("x  8.raw", "x 10.raw", "x 12.raw"));
  EXPECT_THAT(names("%04d 2147483645 2147483647 1"), ElementsAre("2147483645", "2147483646", "2147483647"));
  EXPECT_THROW((void)names("x%d.raw 2147483646"), ImportError);
  for (const char* head :
       {"", "NDims = 3\nDimSize = 3 3\nElementDataFile = LIST\na\nb\nc\n", "DimSize = 3 1\nElementDataFile = LIST\na\n",
        "ElementDataFile = LIST\na\n", "NDims = 2\nDimSize = 3 0\nElementDataFile = LIST\n",
        "NDims = 2\nDimSize = 3 3\n", "NDims = 2\nDimSize = 3 99999999999999999999\nElementDataFile = LIST\n",
        "NDims = 11\nDimSize = 1 1 1 1 1 1 1 1 1 1 1\nElementDataFile = LIST\na\n"})
    EXPECT_THROW((void)metaImageFiles(head), ImportError) << head;
}

TEST(NrrdFiles, AreNamedAsTheHeaderHasThem) {
  EXPECT_THAT(nrrdFiles("LIST", "a b.raw\r\n/c\n"), ElementsAre("a b.raw", "/c"));
  EXPECT_THAT(nrrdFiles("x%03d.raw 8 12 2", {}), ElementsAre("x008.raw", "x010.raw", "x012.raw"));
  EXPECT_THAT(nrrdFiles("x%d 3 1 -1 2", {}), ElementsAre("x3", "x2", "x1"));
  for (const char* other : {"", "x%d", "x%d 1 2", "x%d 1 2 0", "x%s 1 2 1", "x%d%d 1 2 1", "x 1 2 1"})
    EXPECT_TRUE(nrrdFiles(other, "a\n").empty()) << other;
  EXPECT_LE(nrrdFiles("x%d -2147483648 2147483647 1", {}).size(), 65537u);
}

}  // namespace
}  // namespace hapticctl_import::test
