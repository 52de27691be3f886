/** @file
 * The files of a MetaImage or NRRD whose values lie in several.
 */
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace hapticctl_import {

/**
 * Their names, as the header `head` has them: lines behind "ElementDataFile = LIST", or what
 * "ElementDataFile = name%03d.raw FIRST LAST STEP" makes. MetaIO reads as many as there are, whatever the image needs:
 * with fewer it leaves zeros or dies, with more it writes beyond the image. So throws ImportError unless there are as
 * many as its DimSize asks for. Any bytes can be given.
 */
[[nodiscard]] std::vector<std::string> metaImageFiles(std::string_view head);

/**
 * Their names behind "data file: " of a NRRD: LIST, and the lines below, or "name%03d.raw FIRST LAST STEP". Whether
 * there are as many as are needed its own reader sees to. None if the name is of a kind that only that one knows. Any
 * bytes can be given.
 */
[[nodiscard]] std::vector<std::string> nrrdFiles(std::string_view value, std::string_view below);

}  // namespace hapticctl_import
