/** @file
 * A picture in three dimensions, as a scanner made it, and what may be done to it before a surface is drawn.
 */
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace hapticctl_import {

using Double3 = std::array<double, 3>;

/** Values at lattice points, x fastest. Millimetres; left-posterior-superior, as DICOM has it. */
struct Image {
  std::array<std::uint32_t, 3> size{};  ///< Values along each axis, at least 2.
  std::vector<float> values;
  std::vector<double> exact;                                       ///< The same, only if floats round whole numbers.
  std::size_t no_numbers = 0;                                      ///< How many the file had that are not finite.
  Double3 origin{};                                                ///< Of value (0, 0, 0) [mm].
  std::array<Double3, 3> step{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};  ///< From one value to the next along each axis [mm].
  std::string format;                                              ///< In words: what the file was.
  bool distances = false;  ///< Values are distances, negative inside: solid is what is at most iso, not at least.
  std::optional<float> usual_iso;  ///< Where such files have their surface, if they do.
};

/** Why a file cannot be used. */
struct ImportError : std::runtime_error {
  ImportError(std::string at, const std::string& what, std::string help = {})
      : std::runtime_error(what), where(std::move(at)), remedy(std::move(help)) {}
  std::string where, remedy;
};

/** The part from `first` to before `end` along each axis. Throws ImportError if less than 2 values are left. */
[[nodiscard]] Image crop(const Image& image, const std::array<std::uint32_t, 3>& first,
                         const std::array<std::uint32_t, 3>& end);
/** Each block of n^3 values becomes its mean; what is left over at the far ends goes. n at least 1. */
[[nodiscard]] Image shrink(const Image& image, std::uint32_t n);
/**
 * The same space at points `spacing_mm` apart along each axis, in its middle, by linear interpolation; where they are
 * farther apart than the image's, smoothed before so that nothing is stepped over.
 */
[[nodiscard]] Image resample(Image image, double spacing_mm);
/** Convolves with a Gaussian of `sigma_mm` along each axis; borders are continued. */
void smooth(Image& image, double sigma_mm);
/** 1 where the value is `label`, else 0. Of the image as it was read: `exact` goes with no other change. */
void chooseLabel(Image& image, double label);
/** Length of a step [mm]. */
[[nodiscard]] double spacing(const Image& image, std::size_t axis);
/** Of the cell that one step along each axis spans; negative if they are left-handed [mm^3]. */
[[nodiscard]] double cellVolume(const Image& image);
/** Throws ImportError at `where` unless two values are left along each axis. */
void requireTwo(const Image& image, const char* where);
/** Throws ImportError unless every number is finite and the steps span a space. */
void checkPlace(const Image& image);

}  // namespace hapticctl_import
