/** @file
 * What ITK does not say of a DICOM file: where each of its frames lies, and whether all its values are there.
 */
#pragma once

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

/** What GDCM takes for 1 mm without a word, in words to be put behind others: no spacing of values, or of frames. */
[[nodiscard]] std::string whatIsNotSaid(const std::string& path, bool several_frames);

/** Throws ImportError if values that are not compressed are fewer than rows, columns and frames make. */
void requireWholeDicom(const std::string& path);

}  // namespace hapticctl_import
