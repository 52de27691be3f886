/** @file
 * What ITK passes over of where a header puts an image.
 */
#pragma once

#include <string>
#include <string_view>

#include "tools/hapticctl-import/image.h"

namespace hapticctl_import {

/**
 * Puts right the place of an image that ITK has read from a NRRD or MetaImage with this header: lengths are in the unit
 * that it names (`space units`, `units`, `DistanceUnits`; millimetres if none that is known), and `space:
 * left-anterior-superior` is turned as it says, not half about. Throws ImportError for axes of different units.
 */
void placeAsSaid(std::string_view head, const std::string& format, Image& image);

/**
 * That a header says no spacing, in words to be put behind others: ITK takes 1 mm. Throws ImportError for a NRRD that
 * says it by the ends of its axes, which ITK does not read.
 */
[[nodiscard]] std::string whatIsNotSaid(std::string_view head, const std::string& format);

}  // namespace hapticctl_import
