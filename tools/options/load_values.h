/** @file
 * Which options of `hapticctl load`, and of hapticctl, have a value in the next word: hapticctl-import hands them on.
 */
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace hapticd_options {

/** But for --scale and --voxel, which are its own as well. */
inline constexpr std::array<std::string_view, 13> kLoadValues = {
    "--size",      "--weld",    "--points",   "--name", "--parent", "--at",     "--rotate",
    "--stiffness", "--damping", "--friction", "--mass", "--socket", "--timeout"};

/** Takes these with their values out of the words of a command line, up to "--". */
inline std::vector<std::string> takeLoadValues(std::vector<std::string>& words) {
  std::vector<std::string> taken, left;
  std::size_t i = 0;
  for (; i < words.size() && words[i] != "--"; ++i) {
    const bool value = std::find(kLoadValues.begin(), kLoadValues.end(), words[i]) != kLoadValues.end();
    (value ? taken : left).push_back(words[i]);
    if (value && i + 1 < words.size()) taken.push_back(words[++i]);
  }
  left.insert(left.end(), words.begin() + static_cast<std::ptrdiff_t>(i), words.end());
  words = std::move(left);
  return taken;
}

}  // namespace hapticd_options
