/** @file
 * From what the command line names to an image.
 */
#pragma once

#include <string>

#include "tools/hapticctl-import/image.h"

namespace hapticctl_import {

struct InputOptions {
  std::string file;  ///< Or a folder of DICOM slices.
  std::string series, grid;
  std::string scale;  ///< Unit of a .vdb that does not say: mm, cm, m, inch, um, ft or metres per unit.
  std::string raw, raw_size;
  std::string raw_spacing;  ///< Empty: not said, 1 mm.
  bool big_endian = false;
};

/** Asks on a terminal which series is meant where there are several. Throws ImportError. */
[[nodiscard]] Image readInput(const InputOptions& options);

/** "0:100,20:80,0:50" */
[[nodiscard]] Image cropped(const Image& image, const std::string& text);

/** What was found, in words. */
[[nodiscard]] std::string describe(const Image& image);

}  // namespace hapticctl_import
