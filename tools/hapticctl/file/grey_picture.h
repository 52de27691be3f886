/** @file
 * Pictures as heights: a PNG file in shades of grey, 16 bits a pixel.
 */
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace hapticctl {

struct GreyPicture {
  std::uint32_t width = 0, height = 0;
  std::vector<std::uint16_t> grey;  ///< Row by row from the upper edge; 65535 is white.
};

/**
 * Reads a PNG of any kind: colours become their luminance by the weights of ITU-R BT.709, what is transparent is seen
 * over white. Values are taken as they stand, 8 or 16 bits, without gamma: a height is no light. Throws Failure
 * (kExitFile) that names the file and what is wrong.
 */
[[nodiscard]] GreyPicture readPng(const std::string& path);

}  // namespace hapticctl
