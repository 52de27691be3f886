/** @file
 * What ITK does not say of a DICOM file: where each of its frames lies, where nothing was measured, and whether all its
 * values are there.
 */
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/hapticctl-import/image.h"

namespace hapticctl_import {

/** Of an image of several, as its functional groups have it (PS3.3 C.7.6.16), or position and spacing of the first. */
struct DicomFrame {
  Double3 position{}, row{}, column{};         ///< Of its first value [mm]; unit vectors.
  double row_spacing = 0, column_spacing = 0;  ///< Between rows, and between columns [mm].
  double slope = 1, intercept = 0;
};

/** One after the other; empty if the file does not say of each where it lies. */
[[nodiscard]] std::vector<DicomFrame> framesOf(const std::string& path);

/**
 * Puts an image of one slice where its file says: GDCM heeds position and orientation of few kinds of files (not of
 * secondary captures), and of radiography no spacing but that at the detector.
 */
void placeSlice(const std::string& path, Image& slice);

/**
 * What the file's scanner wrote where it measured nothing (PixelPaddingValue, PS3.3 C.7.5.1.1.2), as GDCM gives it;
 * none of a file that does not say, whose frames have slopes of their own, or whose values GDCM turns about.
 */
[[nodiscard]] std::optional<float> paddingOf(const std::string& path);

/** A dose in the unit of the file (Gy or relative), for which GDCM gives whole numbers (PS3.3 C.8.8.3,
 * DoseGridScaling). */
void scaleDose(const std::string& path, Image& image);

/**
 * What GDCM does without a word, in words to be put behind others: no spacing of values, which are 1 mm apart then, or
 * of frames; values turned about, so that low is dark as MONOCHROME2 has it.
 */
[[nodiscard]] std::string whatIsNotSaid(const std::string& path, bool several_frames, bool is_1_mm);

/**
 * Throws ImportError if values that are not compressed are fewer than rows, columns and frames make, or do not lie in
 * the lowest of their bits: GDCM cuts the upper ones off.
 */
void requireWholeDicom(const std::string& path);

}  // namespace hapticctl_import
