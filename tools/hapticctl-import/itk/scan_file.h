/** @file
 * Scans in the formats that ITK reads: NIfTI, NRRD, MetaImage, and DICOM, whose slices are files of their own.
 *
 * ITK and GDCM trust a file more than it deserves: call these in a process that may die (child.h).
 */
#pragma once

#include <string>
#include <vector>

#include "tools/hapticctl-import/image.h"

namespace hapticctl_import {

/**
 * NIfTI, NRRD or MetaImage, told by the name's ending and the first bytes; the data may be compressed or in a file
 * beside it. Of several components or times only one is allowed. Throws ImportError.
 */
[[nodiscard]] Image readScan(const std::string& path);

/** Slices that belong together. */
struct DicomSeries {
  std::string uid;
  std::string text;  ///< In words: what was taken, how many slices.
  std::vector<std::string> files;
};

[[nodiscard]] bool isDicom(const std::string& path);
/** The series in a folder (not below it), in the order of their numbers; of a file: the one it belongs to. */
[[nodiscard]] std::vector<DicomSeries> dicomSeriesIn(const std::string& path);
/**
 * One series as an image: slices in the order of their positions, values times slope plus intercept. Throws ImportError
 * if slices differ in size or orientation, or do not stand at even steps (one is missing, or stands twice).
 */
[[nodiscard]] Image readSeries(const DicomSeries& series);

}  // namespace hapticctl_import
