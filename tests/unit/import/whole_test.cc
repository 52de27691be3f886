// Images whose values are not all there: refused with the file, the bytes found and the bytes needed.
#include <fmt/core.h>

#include "tests/unit/import/ball.h"
#include "tools/hapticctl-import/header/data_place.h"
#include "tools/hapticctl-import/header/stream_length.h"
#include "tools/hapticctl-import/itk/scan_file.h"

namespace hapticctl_import::test {
namespace {

using ::testing::HasSubstr;

constexpr std::size_t kNeeded = 24 * 20 * 16 * 2;

/** An image in one file, or (values named) in two. */
struct Stored {
  const char* name;
  std::string header;
  const char* values;  ///< File of the values; null: behind the header.
  std::string data;
  bool packed;
};

std::vector<Stored> all() {
  const std::string zlib = compressed(samples()), gzip = compressed(samples(), 31);
  const std::string size = fmt::format("CompressedData = True\nCompressedDataSize = {}\n", zlib.size());
  const auto away = [](std::string header, const char* file) { return header.replace(header.find("LOCAL"), 5, file); };
  const std::string raw = "encoding: raw\nendian: little\n", gz = "encoding: gzip\nendian: little\n";
  return {{"a.mha", metaImage(), nullptr, samples(), false},
          {"b.mha", metaImage(size), nullptr, zlib, true},
          {"c.mhd", away(metaImage(), "c.raw"), "c.raw", samples(), false},
          {"d.mhd", away(metaImage(size), "d.zraw"), "d.zraw", zlib, true},
          {"e.mhd", away(metaImage("CompressedData = True\n"), "e.zraw"), "e.zraw", zlib, true},
          {"f.nrrd", nrrd(raw), nullptr, samples(), false},
          {"g.nrrd", nrrd(gz), nullptr, gzip, true},
          {"h.nhdr", nrrd(raw + "data file: h.raw\n"), "h.raw", samples(), false},
          {"i.nhdr", nrrd(gz + "datafile: ./i.gz\n"), "i.gz", gzip, true},
          {"j.nii", nifti(), nullptr, samples(), false}};
}

std::string told(const Folder& folder, const Stored& s, const std::string& data) {
  if (s.values != nullptr) (void)folder.put(s.values, data);
  const std::string path = folder.put(s.name, s.values != nullptr ? s.header : s.header + data);
  return refusal([&] { return readScan(path); });
}

TEST(Whole, everyByteThatIsMissingIsMissed) {
  const Folder folder;
  for (const Stored& s : all()) {
    ASSERT_EQ(told(folder, s, s.data), "read") << s.name;
    for (const std::size_t missing : {std::size_t{1}, std::size_t{2}, std::size_t{4}, std::size_t{8}, std::size_t{9},
                                      std::size_t{100}, s.data.size() / 2, s.data.size() - 1, s.data.size()}) {
      const std::string words = told(folder, s, s.data.substr(0, s.data.size() - missing));
      EXPECT_THAT(words, HasSubstr(fmt::format("{} are needed", s.name[0] == 'j' ? 352 + kNeeded : kNeeded)))
          << s.name << " less " << missing;
      EXPECT_THAT(words, HasSubstr(s.values != nullptr ? s.values : ""));
      if (!s.packed) {
        const std::size_t there = s.data.size() - missing + (s.name[0] == 'j' ? 352 : 0);
        EXPECT_THAT(words, HasSubstr(fmt::format("{} bytes are there", there))) << s.name;
      } else {
        EXPECT_THAT(words, HasSubstr("cut short")) << s.name << " less " << missing;
      }
    }
  }
}

TEST(Whole, whatWasPackedDifferentlyOrTooLittleIsMissed) {
  const Folder folder;
  for (const Stored& s : all()) {
    if (!s.packed) continue;
    std::string damaged = s.data;
    damaged[damaged.size() - (s.name[2] == 'm' ? 2 : 6)] ^= 1;  // Of the checksum.
    EXPECT_THAT(told(folder, s, damaged), HasSubstr("damaged")) << s.name;
    const std::string less = compressed(samples().substr(0, kNeeded - 2), s.name[2] == 'n' ? 31 : 15);
    std::string header = s.header;
    if (const auto at = header.find("CompressedDataSize"); at != std::string::npos)
      header.replace(at, header.find('\n', at) - at, fmt::format("CompressedDataSize = {}", less.size()));
    EXPECT_THAT(told(folder, {s.name, header, s.values, less, true}, less),
                HasSubstr(fmt::format("{} bytes can be unpacked, {} are needed", kNeeded - 2, kNeeded)))
        << s.name;
  }
  // A size that is too small hides what is behind it.
  const std::string zlib = compressed(samples());
  const std::string half = fmt::format("CompressedData = True\nCompressedDataSize = {}\n", zlib.size() / 2);
  EXPECT_THAT(told(folder, {"x.mha", metaImage(half), nullptr, zlib, true}, zlib), HasSubstr("cut short"));
}

TEST(Whole, headersSayWhereTheValuesAre) {
  DataPlace p = metaImagePlace(
      "NDims=3\r\nHeaderSize = 12\nCompressedData: true\nElementDataFile = a b.raw\nCompressedData = 0\n");
  EXPECT_EQ(p.file, "a b.raw");
  EXPECT_EQ(p.skip, 12u);
  EXPECT_TRUE(p.packed && p.countable);
  EXPECT_EQ(metaImagePlace("ElementDataFile = local\nxyz").skip, 24u);
  EXPECT_FALSE(metaImagePlace("ElementDataFile = LIST\na\nb\n").countable);
  EXPECT_FALSE(metaImagePlace("ElementDataFile = s%03d.raw 1 9 1\n").countable);
  EXPECT_FALSE(metaImagePlace("BinaryData = False\nElementDataFile = a.txt\n").countable);
  EXPECT_FALSE(metaImagePlace("NDims = 3\n").countable);
  p = nrrdPlace("NRRD0005\n# data file: no\nkey:=data file: no\nEncoding: gz\nbyte skip: 7\n\nvalues");
  EXPECT_EQ(p.file, "");
  EXPECT_EQ(p.skip, 71u);
  EXPECT_EQ(p.unpacked_skip, 7u);
  EXPECT_TRUE(p.packed && p.countable);
  EXPECT_EQ(nrrdPlace("NRRD0005\r\nencoding: raw\r\n\r\nvalues").skip, 27u);
  EXPECT_EQ(nrrdPlace("NRRD0005\nencoding: raw\nbyte skip: -1\ndata file: v.dcm\n").unpacked_skip, 0u);
  for (const char* many : {"LIST", "s%03d.raw 1 9 1", "LIST 2"})
    EXPECT_FALSE(nrrdPlace(fmt::format("NRRD0005\nencoding: raw\ndata file: {}\n", many)).countable) << many;
  for (const char* other : {"encoding: bzip2", "encoding: txt", "encoding: raw\nline skip: 3", "type: short"})
    EXPECT_FALSE(nrrdPlace(fmt::format("NRRD0005\n{}\n\n", other)).countable) << other;
}

TEST(Whole, membersOfAGzipFileAreOneStream) {
  const Folder folder;
  const std::string two = compressed(std::string(100'000, 'a'), 31) + compressed("bc", 31);
  const auto length = [&](const std::string& bytes) { return lengthOf(folder.put("x", bytes), 0, 0, true); };
  EXPECT_EQ(length(two).bytes, 100'002u);
  EXPECT_EQ(length(two).end, StreamEnd::kWhole);
  EXPECT_EQ(length(two).head.size(), 65536u);
  EXPECT_EQ(length(two.substr(0, two.size() - 1)).end, StreamEnd::kCut);
  EXPECT_EQ(length(two + "padding").end, StreamEnd::kWhole) << "as gunzip has it";
  EXPECT_EQ(length("no such thing").end, StreamEnd::kDamaged);
  EXPECT_EQ(length("").end, StreamEnd::kCut);
  EXPECT_EQ(readFile(folder.put("x", two + "padding")), std::string(100'000, 'a') + "bc");
  EXPECT_THROW((void)readFile(folder.put("x", two.substr(0, two.size() - 1))), ImportError);
}

}  // namespace
}  // namespace hapticctl_import::test
