// Scans in every format: values, place, and what is refused.
#include <fmt/core.h>

#include <algorithm>
#include <limits>

#include "tests/unit/import/ball.h"
#include "tools/hapticctl-import/format/image_file.h"
#include "tools/hapticctl-import/input.h"
#include "tools/hapticctl-import/itk/scan_file.h"

namespace hapticctl_import::test {
namespace {

using ::testing::HasSubstr;

TEST(Import, readsMetaImages) {
  const Folder folder;
  expectBall(readScan(folder.put("a.mha", metaImage() + samples())), {10, 20, 30}, kPlain);
  expectBall(
      readScan(folder.put("b.mha", metaImage("BinaryData = True\nBinaryDataByteOrderMSB = True\n") + samples(true))),
      {10, 20, 30}, kPlain);
  const std::string packed = compressed(samples());
  const std::string told = fmt::format("CompressedData = True\nCompressedDataSize = {}\n", packed.size());
  expectBall(readScan(folder.put("c.mha", metaImage(told) + packed)), {10, 20, 30}, kPlain);
  std::string header = metaImage("TransformMatrix = 0 1 0 -1 0 0 0 0 1\n");
  header.replace(header.find("LOCAL"), 5, "ball.raw");
  (void)folder.put("ball.raw", samples());
  expectBall(readScan(folder.put("d.mhd", header)), {10, 20, 30}, {{{0, 1, 0}, {-1.5, 0, 0}, {0, 0, 2}}});
}

// MetaIO does not take them for its own.
TEST(Import, readsMetaImagesNamedInCapitals) {
  const Folder folder;
  expectBall(readScan(folder.put("A.MHA", metaImage() + samples())), {10, 20, 30}, kPlain);
  std::string header = metaImage();
  header.replace(header.find("LOCAL"), 5, "BALL.RAW");
  (void)folder.put("BALL.RAW", samples());
  expectBall(readScan(folder.put("B.Mhd", header)), {10, 20, 30}, kPlain);
}

// They became 0: bone of --iso -300 all about the head.
TEST(Import, whatIsNoNumberIsNothingSolid) {
  const Folder folder;
  std::vector<float> values = ballValues();
  for (std::size_t row = 0; row < values.size(); row += kSize[0]) {
    values[row + 3] = std::numeric_limits<float>::quiet_NaN();
    values[row + 4] = -std::numeric_limits<float>::infinity();
    values[row + 5] = std::numeric_limits<float>::infinity();
  }
  std::string floats(reinterpret_cast<const char*>(values.data()), values.size() * sizeof values[0]);
  std::string header = metaImage();
  header.replace(header.find("MET_SHORT"), 9, "MET_FLOAT");
  const Image image = readScan(folder.put("a.mha", header + floats));
  const auto [low, high] = std::minmax_element(image.values.begin(), image.values.end());
  EXPECT_EQ(image.values[3], *low);
  EXPECT_EQ(image.values[4], *low);
  EXPECT_EQ(image.values[5], *high);
  EXPECT_LT(*low, -1000);
  EXPECT_EQ(*high, valueAt(11, 9, 7));
  EXPECT_THAT(describe(image), HasSubstr("960 of them no numbers"));
  for (std::size_t i = 0; i < floats.size(); ++i) floats[i] = '\xff';
  EXPECT_THAT(refusal([&] { return readScan(folder.put("a.mha", header + floats)); }), HasSubstr("none of them is a"));
}

// MetaIO says that it could not uncompress, NRRD's library that it is sorry.
TEST(Import, whatCannotBeUnpackedIsSaid) {
  const Folder folder;
  const std::string packed = compressed(samples());
  const auto remedy = [&](const std::string& name, const std::string& bytes) {
    try {
      (void)readScan(folder.put(name, bytes));
    } catch (const ImportError& error) {
      return error.remedy;
    }
    return std::string("read");
  };
  for (const char* const size : {"", "CompressedDataSize = 0\n"}) {
    EXPECT_THAT(remedy("a.mha", metaImage(std::string("CompressedData = True\n") + size) + packed),
                HasSubstr(fmt::format("a line CompressedDataSize = {} ", packed.size())));
  }
  EXPECT_THAT(remedy("a.nrrd", nrrd("encoding: bzip2\nendian: little\n") + samples()), HasSubstr("gzip, or raw"));
}

// ITK takes 1 mm, of the ends of axes too.
TEST(Import, aSpacingThatIsNotSaidIsTold) {
  const Folder folder;
  const auto format = [&](const std::string& more) {
    return readScan(folder.put("a.nrrd", nrrd("encoding: raw\nendian: little\n" + more) + samples())).format;
  };
  EXPECT_EQ(format("spacings: 1 1.5 2\n"), "NRRD");
  EXPECT_EQ(format("space: LPS\nspace directions: (1,0,0) (0,1,0) (0,0,1)\n"), "NRRD");
  for (const char* const none : {"", "spacings: NaN NaN NaN\n", "thicknesses: 1 1 1\n", "axis mins: 1 2 3\n"})
    EXPECT_EQ(format(none), "NRRD, does not say its spacing") << none;
  EXPECT_THAT(refusal([&] { return format("axis mins: 0 0 0\naxis maxs: 24 30 32\n"), Image(); }),
              HasSubstr("axis maxs: says how far apart"));
  std::string header = metaImage();
  EXPECT_EQ(readScan(folder.put("a.mha", header + samples())).format, "MetaImage");
  header.erase(header.find("ElementSpacing"),
               header.find('\n', header.find("ElementSpacing")) + 1 - header.find("ElementSpacing"));
  EXPECT_EQ(readScan(folder.put("a.mha", header + samples())).format, "MetaImage, does not say its spacing");
}

TEST(Import, readsNrrd) {
  const Folder folder;
  expectBall(readScan(folder.put("a.nrrd", nrrd("encoding: raw\nendian: little\nspacings: 1 1.5 2\n") + samples())),
             {0, 0, 0}, kPlain);
  const std::string placed =
      "endian: big\nspace: right-anterior-superior\nspace directions: (1,0,0) (0,1.5,0) (0,0,2)\n"
      "space origin: (1,2,3)\n";
  const std::array<Double3, 3> turned{{{-1, 0, 0}, {0, -1.5, 0}, {0, 0, 2}}};
  expectBall(readScan(folder.put("b.nrrd", nrrd("encoding: raw\n" + placed) + samples(true))), {-1, -2, 3}, turned);
  expectBall(readScan(folder.put("c.nrrd", nrrd("encoding: gzip\n" + placed) + compressed(samples(true), 31))),
             {-1, -2, 3}, turned);
}

TEST(Import, readsNifti) {
  const Folder folder;
  // Without an orientation the axes are right, anterior, superior.
  const std::array<Double3, 3> plain{{{-1, 0, 0}, {0, -1.5, 0}, {0, 0, 2}}};
  std::string turned = nifti();
  put<std::int16_t>(turned, 252, 1);  // A quarter turn about z: x to y, y to -x.
  put<float>(turned, 264, static_cast<float>(std::sqrt(0.5)));
  put<float>(turned, 268, 7);
  expectBall(readScan(folder.put("b.nii", turned + samples())), {-7, 0, 0}, {{{0, -1, 0}, {1.5, 0, 0}, {0, 0, 2}}});
  put<std::int16_t>(turned, 254, 1);
  put<std::int16_t>(turned, 252, 0);
  const float rows[12] = {1, 0, 0, 5, 0, 1.5f, 0, 6, 0, 0, 2, 7};
  std::memcpy(turned.data() + 280, rows, sizeof rows);
  expectBall(readScan(folder.put("c.nii", turned + samples())), {-5, -6, 7}, plain);
  expectBall(readScan(folder.put("c.nii.gz", compressed(turned + samples(), 31))), {-5, -6, 7}, plain);
  std::string pair = turned.substr(0, 348);  // Header and data in files of their own.
  pair[345] = 'i';
  put<float>(pair, 108, 0);
  (void)folder.put("e.img", samples());
  expectBall(readScan(folder.put("e.hdr", pair)), {-5, -6, 7}, plain);
  (void)folder.put("e.img", samples().substr(2));
  EXPECT_THAT(refusal([&] { return readScan(folder.path() + "/e.hdr"); }), HasSubstr("are needed"));
  put<float>(turned, 112, 2);
  put<float>(turned, 116, -5);
  EXPECT_EQ(readScan(folder.put("d.nii", turned + samples())).values[0], 2.0f * valueAt(0, 0, 0) - 5);
}

// ITK takes the one or the other place of a header that names two, as 3D Slicer does; nibabel always takes the sform.
TEST(Import, ofTwoPlacesOfANiftiTheOneTakenIsTold) {
  const Folder folder;
  const auto placed = [&](std::int16_t sform_code, float x, char unit) {
    std::string header = nifti();
    header[123] = unit;
    put<std::int16_t>(header, 252, 1);  // A quarter turn about z: x to y, y to -x.
    put<float>(header, 264, static_cast<float>(std::sqrt(0.5)));
    put<float>(header, 268, 7);
    put<std::int16_t>(header, 254, sform_code);
    const float rows[12] = {0, -1.5f, 0, x, 1, 0, 0, 0, 0, 0, 2, 0};
    std::memcpy(header.data() + 280, rows, sizeof rows);
    const Image image = readScan(folder.put("a.nii", header + samples()));
    return fmt::format("{} at {:g}", image.format, image.origin[0]);
  };
  EXPECT_EQ(placed(4, 7, 2), "NIfTI at -7");
  EXPECT_EQ(placed(4, 7.05f, 2), "NIfTI at -7");
  EXPECT_EQ(placed(4, 10, 2), "NIfTI, placed by its qform; its sform puts it 3 mm elsewhere at -7");
  EXPECT_EQ(placed(1, 10, 2), "NIfTI, placed by its sform; its qform puts it 3 mm elsewhere at -10");
  EXPECT_EQ(placed(0, 10, 2), "NIfTI at -7");
  EXPECT_EQ(placed(4, 10, 1), "NIfTI, placed by its qform; its sform puts it 3e+03 mm elsewhere at -7000");
}

// Of a pair either file may be named; which of the two that ITK could take it takes is the one whose length is told.
TEST(Import, readsNiftiPairsByEitherName) {
  const Folder folder;
  std::string pair = nifti().substr(0, 348);
  pair[345] = 'i';
  put<float>(pair, 108, 0);
  const std::string header = folder.put("a.b.hdr", pair), packed = folder.put("a.b.img.gz", compressed(samples(), 31));
  expectBall(readScan(header), {0, 0, 0}, kPlain);
  expectBall(readScan(packed), {0, 0, 0}, kPlain);
  const std::string values = folder.put("a.b.img", samples());
  (void)folder.put("a.b.img.gz", "damaged, and not read");
  expectBall(readScan(header), {0, 0, 0}, kPlain);
  expectBall(readScan(values), {0, 0, 0}, kPlain);
  const std::string capital = folder.put("C.HDR", pair);
  (void)folder.put("C.IMG", samples().substr(2));
  EXPECT_THAT(refusal([&] { return readScan(capital); }), HasSubstr("15358 bytes are there"));
}

// niftilib looks for scan.nii first, whose values it took for those of scan.nii.gz.
TEST(Import, readsNoNiftiOfAnotherFile) {
  const Folder folder;
  const std::string packed = folder.put("a.nii.gz", compressed(nifti() + samples(), 31));
  const std::string beside = folder.put("a.nii", nifti() + samples());
  expectBall(readScan(packed), {0, 0, 0}, kPlain);
  (void)folder.put("a.nii", nifti() + samples(true));
  EXPECT_THAT(refusal([&] { return readScan(packed); }), HasSubstr("a.nii: lies beside it"));
  EXPECT_NO_THROW((void)readScan(beside));
}

// ITK passes units over, but for the spacing of a NIfTI image, whose origin it then leaves.
TEST(Import, lengthsAreInTheUnitThatTheHeaderNames) {
  const Folder folder;
  std::string small = nifti();
  small[123] = 3;
  const float microns[] = {1000, 1500, 2000}, rows[12] = {1000, 0, 0, 5000, 0, 1500, 0, 6000, 0, 0, 2000, 7000};
  std::memcpy(small.data() + 80, microns, sizeof microns);
  std::memcpy(small.data() + 280, rows, sizeof rows);
  put<std::int16_t>(small, 254, 1);
  const std::array<Double3, 3> plain{{{-1, 0, 0}, {0, -1.5, 0}, {0, 0, 2}}};
  expectBall(readScan(folder.put("a.nii", small + samples())), {-5, -6, 7}, plain);
  put<std::int16_t>(small, 254, 0);
  put<std::int16_t>(small, 252, 1);
  put<float>(small, 268, 9000);
  expectBall(readScan(folder.put("a.nii", small + samples())), {-9, 0, 0}, plain);
  const std::string placed =
      "encoding: raw\nendian: little\nspace: LPS\nspace directions: (1000,0,0) (0,1500,0) (0,0,2000)\n"
      "space origin: (10000,20000,30000)\nspace units: ";
  expectBall(readScan(folder.put("b.nrrd", nrrd(placed + "\"microns\" \"microns\" \"microns\"\n") + samples())),
             {10, 20, 30}, kPlain);
  EXPECT_THAT(
      refusal([&] { return readScan(folder.put("b.nrrd", nrrd(placed + "\"m\" \"m\" \"cm\"\n") + samples())); }),
      HasSubstr("units: differ"));
  const std::string spaced = "encoding: raw\nendian: little\nspacings: 0.1 0.15 0.2\nunits: \"cm\" \"cm\" \"cm\"\n";
  expectBall(readScan(folder.put("c.nrrd", nrrd(spaced) + samples())), {0, 0, 0}, kPlain);
  std::string in_cm = metaImage("DistanceUnits = cm\n");
  in_cm.replace(in_cm.find("1 1.5 2"), 7, ".1 .15 .2").replace(in_cm.find("10 20 30"), 8, "1 2 3");
  expectBall(readScan(folder.put("d.mha", in_cm + samples())), {10, 20, 30}, kPlain);
}

TEST(Import, leftAnteriorSuperiorIsTurnedAsItSays) {
  const Folder folder;
  expectBall(
      readScan(folder.put("a.nrrd", nrrd("encoding: raw\nendian: little\nspace: left-anterior-superior\n"
                                         "space directions: (1,0,0) (0,1.5,0) (0,0,2)\nspace origin: (1,2,3)\n") +
                                        samples())),
      {1, -2, 3}, {{{1, 0, 0}, {0, -1.5, 0}, {0, 0, 2}}});
}

TEST(Import, whatNiftiCannotBeReadIsSaid) {
  const Folder folder;
  for (const float none : {0.0f, std::numeric_limits<float>::quiet_NaN()}) {  // ITK took it for 1.
    std::string header = nifti();
    put<float>(header, 84, none);
    EXPECT_THAT(refusal([&] { return readScan(folder.put("a.nii", header + samples())); }), HasSubstr("along axis 2"));
  }
  std::string sheared = nifti();
  put<std::int16_t>(sheared, 254, 1);
  const float rows[12] = {1, 0.5f, 0, 5, 0, 1.5f, 0, 6, 0, 0, 2, 7};
  std::memcpy(sheared.data() + 280, rows, sizeof rows);
  EXPECT_THAT(refusal([&] { return readScan(folder.put("b.nii", sheared + samples())); }), HasSubstr("right angles"));
  std::string second(540, '\0');
  put<std::int32_t>(second, 0, 540);
  std::memcpy(second.data() + 4, "n+2\0\r\n\032\n", 8);
  EXPECT_THAT(refusal([&] { return readScan(folder.put("c.nii", second + samples())); }), HasSubstr("is NIfTI-2"));
  std::string analyze = nifti().substr(0, 348);
  put<std::int32_t>(analyze, 344, 0);
  (void)folder.put("d.img", samples());
  EXPECT_THAT(refusal([&] { return readScan(folder.put("d.hdr", analyze)); }), HasSubstr("is ANALYZE"));
}

std::string tarFile(const std::string& name, const std::string& bytes) {
  std::string head(512, '\0');
  std::memcpy(head.data(), name.data(), name.size());
  std::snprintf(head.data() + 124, 12, "%011zo", bytes.size());
  std::memcpy(head.data() + 257, "ustar", 5);
  return head + bytes + std::string((512 - bytes.size() % 512) % 512, '\0');
}

std::string invesalius() {
  return tarFile("tmp/main.plist",
                 "<?xml version=\"1.0\"?><plist><dict><key>matrix</key><dict><key>dtype</key><string>int16</string>"
                 "<key>filename</key><string>matrix.dat</string><key>shape</key><array><integer>16</integer>"
                 "<integer>20</integer><integer>24</integer></array></dict><key>spacing</key><array><real>1</real>"
                 "<real>1.5</real><real>2</real></array></dict></plist>") +
         tarFile("tmp/matrix.dat", samples()) + std::string(1024, '\0');
}

TEST(Import, readsInvesaliusProjects) {
  EXPECT_TRUE(isInvesalius(invesalius()));
  expectBall(parseInvesalius(invesalius()), {0, 0, 0}, kPlain);
  const std::string project = invesalius();
  for (std::size_t n = 0; n + 1536 < project.size(); n += 311)
    EXPECT_THROW((void)parseInvesalius(std::string_view(project).substr(0, n)), ImportError) << n;
}

TEST(Import, aSpacingThatIsNotGivenForRawNumbersIsTold) {
  const Folder folder;
  InputOptions options;
  options.file = folder.put("ball.raw", samples());
  options.raw = "int16";
  options.raw_size = "24,20,16";
  const Image image = readInput(options);
  EXPECT_EQ(image.format, "raw numbers, does not say its spacing");
  EXPECT_EQ(spacing(image, 2), 1);
  options.raw_spacing = "1,1,2";
  EXPECT_EQ(readInput(options).format, "raw numbers");
  EXPECT_EQ(spacing(readInput(options), 2), 2);
}

TEST(Import, readsRawNumbers) {
  RawLayout layout;
  layout.size = kSize;
  layout.spacing = {1, 1.5, 2};
  expectBall(parseRaw(samples(), layout), {0, 0, 0}, kPlain);
  EXPECT_THROW((void)parseRaw(samples().substr(1), layout), ImportError);
  EXPECT_THAT(refusal([&] { return parseRaw(samples() + '\0', layout); }), HasSubstr("are needed")) << "another size";
  layout.big_endian = true;
  expectBall(parseRaw(samples(true), layout), {0, 0, 0}, kPlain);
  layout.spacing = {1, 0, 2};
  EXPECT_THAT(refusal([&] { return parseRaw(samples(), layout); }), HasSubstr("spacing"));
}

TEST(Import, rawNumbersThatBeginLikeGzipAreNone) {
  std::string bytes = samples();
  bytes.replace(0, 3, "\x1f\x8b\x08");
  const Folder folder;
  InputOptions options;
  options.raw = "int16";
  options.raw_size = "24,20,16";
  options.file = folder.put("ball.raw", bytes);
  EXPECT_EQ(readInput(options).values[0], -29921);
  options.file = folder.put("ball.raw.gz", compressed(bytes, 31));
  EXPECT_EQ(readInput(options).values[0], -29921) << "packed";
}

TEST(Import, labelsThatFloatsRoundAreToldApart) {
  constexpr std::uint32_t kLabels[] = {312782574, 312782578, 0, 1};  // Of Allen's atlas of the mouse's brain.
  std::string bytes(std::size_t{24} * 20 * 16 * 4, '\0');
  for (std::size_t i = 0; i < 24 * 20 * 16; ++i) put<std::uint32_t>(bytes, 4 * i, kLabels[i % 4]);
  std::string header = metaImage();
  header.replace(header.find("MET_SHORT"), 9, "MET_UINT");
  const Folder folder;
  RawLayout layout;
  layout.size = kSize;
  layout.sample = Sample::kUint32;
  for (std::size_t k = 0; k < 4; ++k) {
    for (Image image : {readScan(folder.put("a.mha", header + bytes)), parseRaw(bytes, layout)}) {
      chooseLabel(image, kLabels[k]);
      for (std::size_t i = 0; i < image.values.size(); ++i) ASSERT_EQ(image.values[i], i % 4 == k ? 1 : 0) << i;
    }
  }
}

TEST(Import, liesInHeadersAreRefusedInWords) {
  const Folder folder;
  const auto told = [&](std::string header, const std::string& what, const std::string& lie) {
    header.replace(header.find(what), what.size(), lie);
    const char* const name = header[0] == 'N' ? "lie.nrrd" : "lie.mha";
    return refusal([&] { return readScan(folder.put(name, header + samples())); });
  };
  EXPECT_NE(told(metaImage(), "24 20 16", "24 20"), "read");
  EXPECT_NE(told(metaImage(), "24 20 16", "24 20 1"), "read");
  EXPECT_THAT(told(metaImage(), "24 20 16", "60000 60000 60000"), HasSubstr("2^31"));
  EXPECT_NE(told(metaImage(), "MET_SHORT", "MET_COMPLEX"), "read");
  EXPECT_NE(told(metaImage(), "LOCAL", "away.raw"), "read");
  EXPECT_THAT(told(metaImage("ElementNumberOfChannels = 3\n"), "24 20 16", "8 20 16"), HasSubstr("3 components"));
  EXPECT_NE(told(nrrd("encoding: bzip3\n"), "short", "short"), "read");
  EXPECT_THAT(told(metaImage(), "24 20 16", "24 320 1"), HasSubstr("a single slice"));
  const std::string away = folder.put("away.mhd", metaImage().replace(metaImage().find("LOCAL"), 5, "away.raw"));
  try {
    (void)readScan(away);
    ADD_FAILURE() << "there are no values";
  } catch (const ImportError& error) {
    EXPECT_THAT(error.remedy, HasSubstr("that it names"));
  }
  EXPECT_THAT(refusal([&] { return readScan(folder.path() + "/nowhere.nii"); }),
              HasSubstr("cannot be read: No such file"));
  InputOptions circle;
  circle.file = folder.path() + "/circle.nii";
  std::filesystem::create_symlink(circle.file, circle.file);
  EXPECT_THAT(refusal([&] { return readInput(circle); }),
              HasSubstr("cannot be read: Too many levels of symbolic links"));
  EXPECT_THAT(refusal([&] { return readScan("/dev/null"); }), HasSubstr("is no file on a disk"));
  EXPECT_THAT(refusal([&] { return readScan(folder.put("text.mha", "just words\n")); }), HasSubstr("is no NIfTI"));
}

}  // namespace
}  // namespace hapticctl_import::test
