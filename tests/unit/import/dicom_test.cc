// DICOM series against what was written into them.
#include <algorithm>
#include <optional>
#include <set>

#include "tests/unit/import/dicom_file.h"
#include "tools/hapticctl-import/input.h"
#include "tools/hapticctl-import/itk/scan_file.h"

namespace hapticctl_import::test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr std::size_t kSliceValues = 24 * 20;

/** Slices in files whose names and numbers have nothing to do with their order. */
void putSeries(const Folder& folder, const std::function<void(CtSlice&, double)>& change) {
  for (std::size_t i = 0; i < kSize[2]; ++i) {
    const std::size_t z = i * 7 % kSize[2];
    CtSlice slice = ballSlice(z);
    slice.number = static_cast<int>(100 - i);
    change(slice, static_cast<double>(z));
    (void)folder.put(fmt::format("IM{:03}", i), dicomFile(slice));
  }
}

constexpr const char* kCapture = "1.2.840.10008.5.1.4.1.1.7.3";  // Multi-frame grayscale word secondary capture.
constexpr const char* kDose = "1.2.840.10008.5.1.4.1.1.481.2";

/** The ball's slices as the frames of one file. */
CtSlice allSlices(const char* kind) {
  CtSlice all = ballSlice(0);
  all.kind = kind;
  all.frames = static_cast<int>(kSize[2]);
  all.values = samples();
  return all;
}

/** How far each stands from the first [mm], as a dose says it. */
std::string offsetsOfSlices() {
  std::string offsets = "0";
  for (std::size_t i = 1; i < kSize[2]; ++i) offsets += fmt::format("\\{}", 2 * i);
  return offsets;
}

Image readOne(const std::string& path) {
  const auto all = dicomSeriesIn(path);
  EXPECT_EQ(all.size(), 1u);
  return readSeries(all.at(0));
}

TEST(Dicom, aSeriesIsSortedByItsPositions) {
  const Folder folder;
  putSeries(folder, [](CtSlice&, double) {});
  (void)folder.put("README", "not an image");
  expectBall(readOne(folder.path()), {10, 20, 30}, kPlain);
  EXPECT_THAT(readOne(folder.path()).format, HasSubstr("CT, Ball"));
  auto series = dicomSeriesIn(folder.path()).at(0);  // GDCM has sorted them; that is not relied on.
  std::sort(series.files.begin(), series.files.end());
  expectBall(readSeries(series), {10, 20, 30}, kPlain);
  EXPECT_TRUE(isDicom(folder.path() + "/IM003"));
  EXPECT_FALSE(isDicom(folder.path() + "/README"));
  expectBall(readOne(folder.path() + "/IM003"), {10, 20, 30}, kPlain);  // All of the series it belongs to.
}

TEST(Dicom, orientationSlopeAndInterceptAreHonoured) {
  const Folder folder;
  // Rows along u, columns along v, and slices against u x v, oblique in the room.
  const Double3 u{0.6, 0.8, 0}, v{0, 0, -1}, w{0.8, -0.6, 0};
  putSeries(folder, [&](CtSlice& s, double z) {
    s.row = u;
    s.column = v;
    for (std::size_t k = 0; k < 3; ++k) s.position[k] = 5 - 2.5 * z * w[k];
    s.slope = 2;
    s.intercept = -1024;
  });
  const Image image = readOne(folder.path());
  ASSERT_EQ(image.size, kSize);
  // u x v = -w, along which positions grow: the slices' own order.
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(image.origin[k], 5, 1e-5);
    EXPECT_NEAR(image.step[0][k], u[k], 1e-5);
    EXPECT_NEAR(image.step[1][k], 1.5 * v[k], 1e-5);
    EXPECT_NEAR(image.step[2][k], -2.5 * w[k], 1e-5);
  }
  std::vector<float> rescaled = ballValues();
  for (float& value : rescaled) value = 2 * value - 1024;
  EXPECT_EQ(image.values, rescaled);
}

TEST(Dicom, slicesOfATiltedGantryStandObliquely) {
  const Folder folder;
  putSeries(folder, [](CtSlice& s, double z) { s.position[1] = 20 + 0.5 * z; });
  expectBall(readOne(folder.path()), {10, 20, 30}, {{{1, 0, 0}, {0, 1.5, 0}, {0, 0.5, 2}}});
}

TEST(Dicom, severalSeriesInAFolderAreTold) {
  const Folder folder;
  for (int s = 0; s < 3; ++s)
    for (std::size_t z = 0; z < 4; ++z) {
      CtSlice slice = ballSlice(z);
      slice.series = fmt::format("1.2.3.{}", s);
      slice.description = fmt::format("Phase {}", s);
      (void)folder.put(fmt::format("S{}I{}", s, z), dicomFile(slice));
    }
  const auto all = dicomSeriesIn(folder.path());
  ASSERT_EQ(all.size(), 3u);
  std::set<std::string> texts;
  for (const auto& series : all) {
    EXPECT_EQ(series.files.size(), 4u);
    texts.insert(series.text);
  }
  EXPECT_EQ(texts.size(), 3u);
  EXPECT_THAT(*texts.begin(), HasSubstr("Phase 0, 24 x 20 values, 4 files"));
  EXPECT_THAT(readOne(folder.path() + "/S1I2").format, HasSubstr("Phase 1"));
}

TEST(Dicom, aSeriesIsChosenByNumberOrIdentifier) {
  const Folder folder;
  for (int s = 0; s < 2; ++s)
    for (std::size_t z = 0; z < 4; ++z) {
      CtSlice slice = ballSlice(z);
      slice.series = fmt::format("1.2.{}.7", s + 5);
      slice.description = fmt::format("Phase {}", s);
      (void)folder.put(fmt::format("S{}I{}", s, z), dicomFile(slice));
    }
  InputOptions options;
  options.file = folder.path();
  const auto told = [&](const char* series) {
    options.series = series;
    return refusal([&] { return readInput(options); });
  };
  EXPECT_THAT(told("9"), HasSubstr("'9' names none of the 2 series:\n  1  CT, Phase"));
  EXPECT_THAT(told("1.3"), HasSubstr("--series: '1.3' names none of the 2 series"));
  EXPECT_EQ(told("1"), "read");
  options.series = "1.2.6";
  EXPECT_THAT(readInput(options).format, HasSubstr("Phase 1"));
}

// It was the first of those that begin so: 1.2.50 for 1.2.5, or either of two for 1.2.
TEST(Dicom, aSeriesIsNotTakenForAnotherThatBeginsLikeIt) {
  const Folder folder;
  for (const char* const series : {"1.2.50", "1.2.5", "1.2.51"})
    for (std::size_t z = 0; z < 4; ++z) {
      CtSlice slice = ballSlice(z);
      slice.series = series;
      slice.description = fmt::format("Phase {}", series);
      (void)folder.put(fmt::format("S{}I{}", series, z), dicomFile(slice));
    }
  InputOptions options;
  options.file = folder.path();
  for (const char* const series : {"1.2.50", "1.2.5", "1.2.51"}) {
    options.series = series;
    EXPECT_THAT(readInput(options).format, HasSubstr(fmt::format("Phase {},", series)));
  }
  options.series = "1.2";
  EXPECT_THAT(refusal([&] { return readInput(options); }), HasSubstr("'1.2' names none of the 3 series"));
}

TEST(Dicom, allSlicesMayBeInOneFile) {
  const Folder folder;
  const std::string path = folder.put("all.dcm", dicomFile(allSlices(kCapture)));
  const Image image = readOne(path);
  ASSERT_EQ(image.size, kSize);
  EXPECT_EQ(image.values, ballValues());
}

// GDCM told 1 mm for all axes where frames were not in order, and took the first one's slope for all.
TEST(Dicom, framesOfAnEnhancedImageStandWhereEachSays) {
  const Folder folder;
  std::vector<std::size_t> order(kSize[2]);
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  expectBall(readOne(folder.put("a.dcm", dicomFile(enhanced(order)))), {10, 20, 30}, kPlain);
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i * 7 % order.size();
  expectBall(readOne(folder.put("a.dcm", dicomFile(enhanced(order)))), {10, 20, 30}, kPlain);
  const Image sloping = readOne(folder.put("a.dcm", dicomFile(enhanced(order, true))));
  for (std::size_t z = 0; z < kSize[2]; ++z)
    ASSERT_EQ(sloping.values[480 * z + 99], (z % 2 != 0 ? 4 * valueAt(3, 4, z) - 7 : 2 * valueAt(3, 4, z))) << z;
  const auto told = [&] { return refusal([&] { return readOne(folder.put("a.dcm", dicomFile(enhanced(order)))); }); };
  order.back() = order.front();
  EXPECT_THAT(told(), HasSubstr("a.dcm, frame 16: stands where a.dcm, frame 1 does"));
  order.pop_back();
  EXPECT_THAT(told(), HasSubstr("is a slice missing?"));
}

/** The image with each value that much higher, and what each was before. */
void expectToldApart(const Image& image, int above, const std::string& what) {
  ASSERT_EQ(image.exact.size(), image.values.size()) << what;
  for (const std::size_t low : {0u, 1u, 2u}) {
    Image chosen = image;
    chooseLabel(chosen, static_cast<double>(above) + static_cast<double>(low));
    for (std::size_t i = 0; i < chosen.values.size(); ++i)
      ASSERT_EQ(chosen.values[i], i % 3 == low ? 1 : 0) << what << i;
  }
}

TEST(Dicom, labelsThatFloatsRoundAreToldApart) {
  constexpr int kAbove = 33554432;  // From here on a float counts by fours.
  const auto labelled = [](CtSlice slice, std::size_t first) {
    slice.intercept = kAbove;
    const std::size_t count = slice.values.size() / 2;
    slice.values.clear();
    for (std::size_t i = 0; i < count; ++i) append(slice.values, static_cast<short>((first + i) % 3));
    return slice;
  };
  const Folder folder;
  putSeries(folder, [&](CtSlice& s, double z) { s = labelled(s, kSliceValues * static_cast<std::size_t>(z)); });
  expectToldApart(readOne(folder.path()), kAbove, "a file for each slice");
  const Folder one;
  expectToldApart(readOne(one.put("a.dcm", dicomFile(labelled(allSlices(kCapture), 0)))), kAbove, "one file");
  CtSlice frames = labelled(allSlices(kCapture), 0);
  frames.between = 2;
  expectToldApart(readOne(one.put("a.dcm", dicomFile(frames))), kAbove, "frames");
}

// Of computed tomography and secondary captures GDCM took no spacing between frames, and told 1 mm.
TEST(Dicom, framesWithoutGroupsStandAsFarApartAsIsSaid) {
  const Folder folder;
  for (const char* const kind : {"1.2.840.10008.5.1.4.1.1.2", kCapture}) {
    CtSlice all = allSlices(kind);
    all.between = 2;
    expectBall(readOne(folder.put("a.dcm", dicomFile(all))), {10, 20, 30}, kPlain);
    all.between = 0;
    all.groups = element(0x18, 0x88, "DS", "+2");  // A sign that DICOM allows (PS3.5 6.2).
    expectBall(readOne(folder.put("a.dcm", dicomFile(all))), {10, 20, 30}, kPlain);
  }
  CtSlice dose = allSlices(kDose);
  std::string offsets = offsetsOfSlices();
  dose.groups = element(0x3004, 0xc, "DS", offsets);
  expectBall(readOne(folder.put("a.dcm", dicomFile(dose))), {10, 20, 30}, kPlain);
  dose.groups = element(0x3004, 0xc, "DS", offsets.replace(offsets.find("10"), 2, "11"));
  EXPECT_THAT(refusal([&] { return readOne(folder.put("a.dcm", dicomFile(dose))); }), HasSubstr("is a slice missing?"));
}

// GDCM gave the whole numbers of the file.
TEST(Dicom, aDoseIsInItsUnit) {
  const Folder folder;
  CtSlice dose = allSlices(kDose);
  dose.groups = element(0x3004, 0xc, "DS", offsetsOfSlices()) + element(0x3004, 0xe, "DS", "2.5E-3");
  const Image image = readOne(folder.put("a.dcm", dicomFile(dose)));
  for (std::size_t z = 0; z < kSize[2]; ++z)
    EXPECT_FLOAT_EQ(image.values[480 * z + 99], 0.0025f * valueAt(3, 4, z)) << z;
}

// A scanner's round field in its square picture became a solid frame about the patient.
TEST(Dicom, paddingAboveAllThatWasMeasuredIsNothing) {
  constexpr short kPadding = 30000;
  const Folder folder;
  const auto put = [&](std::optional<int> said, short written, double slope) {
    putSeries(folder, [&](CtSlice& s, double z) {
      std::string two;
      append(two, written);
      for (std::size_t i = 0; i < (z == 3 ? kSliceValues : 5); ++i) s.values.replace(2 * i, 2, two);
      s.padding = said;
      s.slope = slope;
      s.intercept = 2 - slope;
    });
    return readOne(folder.path());
  };
  const std::size_t corner = 0, in_padded_slice = 3 * kSliceValues + 200, beside = 5;
  for (const double slope : {1.0, 2.5}) {
    const auto shown = [&](double stored) { return static_cast<float>(stored * slope + 2 - slope); };
    const Image image = put(kPadding, kPadding, slope);
    const float lowest = *std::min_element(image.values.begin(), image.values.end());
    EXPECT_EQ(image.values[corner], lowest);
    EXPECT_EQ(image.values[in_padded_slice], lowest);
    EXPECT_EQ(image.values[beside], shown(valueAt(5, 0, 0)));
    EXPECT_LT(*std::max_element(image.values.begin(), image.values.end()), shown(1000));
    EXPECT_THAT(image.format, HasSubstr(fmt::format(", {} values of it padding", 15 * 5 + kSliceValues)));
    EXPECT_EQ(put({}, kPadding, slope).values[corner], shown(kPadding)) << "nobody says that it is one";
    EXPECT_EQ(put(-3000, -3000, slope).values[corner], shown(-3000)) << "it is low";
    EXPECT_EQ(put(500, 500, slope).values[corner], shown(500)) << "it may be a measurement";
  }
}

// ITK turns them about, and its warning is kept from the terminal.
TEST(Dicom, valuesThatAreTurnedAboutAreTold) {
  const Folder folder;
  putSeries(folder, [](CtSlice& s, double) { s.photometric = "MONOCHROME1"; });
  const Image image = readOne(folder.path());
  EXPECT_THAT(image.format, HasSubstr("values turned about (MONOCHROME1)"));
  EXPECT_EQ(image.values[99], -1 - valueAt(3, 4, 0));
  putSeries(folder, [](CtSlice&, double) {});
  EXPECT_THAT(readOne(folder.path()).format, Not(HasSubstr("turned about")));
}

// GDCM cut them off above the lowest twelve.
TEST(Dicom, valuesInTheUpperBitsAreRefused) {
  const Folder folder;
  putSeries(folder, [](CtSlice& s, double) { s.bits_stored = 12; });
  EXPECT_THAT(refusal([&] { return readOne(folder.path()); }), HasSubstr("HighBit: is 15 of 12 bits stored"));
  putSeries(folder, [](CtSlice& s, double) { s.bits_stored = 12, s.high_bit = 11; });
  EXPECT_EQ(refusal([&] { return readOne(folder.path()); }), "read");
}

// GDCM takes 1 mm, of what may be times and no places.
TEST(Dicom, aSpacingThatIsNotSaidIsTold) {
  const Folder folder;
  EXPECT_THAT(readOne(folder.put("all.dcm", dicomFile(allSlices(kCapture)))).format,
              HasSubstr("does not say the spacing of its frames"));
  const Folder series;
  putSeries(series, [](CtSlice& s, double) { s.row_spacing = 0; });
  EXPECT_THAT(readOne(series.path()).format, HasSubstr("does not say its spacing"));
  putSeries(series, [](CtSlice& s, double) {  // That at the detector, of which GDCM takes nothing for CT.
    s.row_spacing = 0;
    s.groups = element(0x18, 0x1164, "DS", "0.5\\0.5");
  });
  EXPECT_THAT(readOne(series.path()).format, HasSubstr("does not say its spacing"));
  putSeries(series, [](CtSlice&, double) {});
  EXPECT_THAT(readOne(series.path()).format, Not(HasSubstr("does not say")));
}

// Of secondary captures GDCM takes no position, of radiography no spacing but that at the detector.
TEST(Dicom, slicesOfEachKindStandWhereTheySay) {
  for (const char* const kind :
       {"1.2.840.10008.5.1.4.1.1.7", "1.2.840.10008.5.1.4.1.1.1", "1.2.840.10008.5.1.4.1.1.12.1"}) {
    const Folder folder;
    putSeries(folder, [&](CtSlice& s, double) {
      s.kind = kind;
      s.groups = element(0x18, 0x1164, "DS", "2\\2");  // At the detector.
    });
    const Image image = readOne(folder.path());
    expectBall(image, {10, 20, 30}, kPlain);
    EXPECT_THAT(image.format, Not(HasSubstr("does not say")));
  }
}

TEST(Dicom, whatGdcmWarnsOfIsKeptFromTheTerminal) {
  const Folder folder;
  putSeries(folder, [](CtSlice& s, double) { s.groups = element(0x28, 0x11, "US", number16(s.columns)); });  // Again.
  testing::internal::CaptureStderr();
  const Image image = readOne(folder.path());
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  expectBall(image, {10, 20, 30}, kPlain);
}

// They were what the memory held, or zeros.
TEST(Dicom, valuesThatAreFewerThanFramesMakeAreMissed) {
  const Folder folder;
  CtSlice all = allSlices(kCapture);
  all.values.erase(0, 2);
  EXPECT_THAT(refusal([&] { return readOne(folder.put("all.dcm", dicomFile(all))); }),
              HasSubstr("15358 bytes are there, 15360 are needed"));
}

TEST(Dicom, slicesThatMakeNoImageAreNamed) {
  const auto told = [](const std::function<void(const Folder&)>& spoil) {
    const Folder folder;
    putSeries(folder, [](CtSlice&, double) {});
    spoil(folder);
    return refusal([&] { return readSeries(dicomSeriesIn(folder.path()).at(0)); });
  };
  EXPECT_EQ(told([](const Folder&) {}), "read");
  // IM003 is slice 5, IM010 slice 6.
  const std::string missing = told([](const Folder& f) { std::filesystem::remove(f.path() + "/IM003"); });
  EXPECT_THAT(missing, HasSubstr("stands 4 mm after"));
  EXPECT_THAT(missing, HasSubstr("steps are 2 mm: is a slice missing?"));
  EXPECT_THAT(told([](const Folder& f) {
                CtSlice twice = ballSlice(5);
                twice.number = 300;
                (void)f.put("again", dicomFile(twice));
              }),
              HasSubstr("stands where"));
  EXPECT_THAT(told([](const Folder& f) {
                CtSlice other = ballSlice(5);
                other.column_spacing = 1.2;
                (void)f.put("IM003", dicomFile(other));
              }),
              HasSubstr("spaced otherwise"));
  const Folder mixed;  // A slice of another size is a series of its own.
  putSeries(mixed, [](CtSlice&, double) {});
  CtSlice other = ballSlice(5);
  other.rows = 10;
  other.values.resize(480);
  (void)mixed.put("IM003", dicomFile(other));
  EXPECT_EQ(dicomSeriesIn(mixed.path()).size(), 2u);
  const Folder empty;
  EXPECT_THAT(refusal([&] { return dicomSeriesIn(empty.path()); }), HasSubstr("holds no DICOM images"));
}

}  // namespace
}  // namespace hapticctl_import::test
