/** @file
 * Texture models in the XML of the Penn Haptic Texture Toolkit (Culbertson, Lopez Delgado, Kuchenbecker, IEEE Haptics
 * Symposium 2014). The toolkit's files are their authors' and not part of hapticd: bring your own.
 */
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace hapticctl {

/** A model as the daemon takes it: SI units, coefficients. */
struct HattModel {
  double speed = 0, force = 0, variance = 0;  ///< [m/s, N, m^2/s^4]
  std::vector<double> a;                      ///< y[n] = e[n] - sum a[i] y[n - 1 - i]
};

struct HattFile {
  std::vector<HattModel> models;
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< Indices from 0.
  double friction = 0;                                  ///< mu, 0 where the file does not say.
};

inline constexpr double kHattRateHz = 10000;  ///< At which the toolkit recorded.

/** Reads a file. Throws Failure (kExitFile) that names the file and the element at fault. */
[[nodiscard]] HattFile readHatt(const std::string& path);
/** The same from text; `path` is for errors. */
[[nodiscard]] HattFile parseHatt(std::string_view xml, const std::string& path);

/**
 * Coefficients of the polynomial 1 + a1 z^-1 + ... whose line spectral frequencies are these, rising within (0, pi)
 * (Itakura 1975): a = (P + Q) / 2 with P, Q of roots exp(+-i w) at the even and odd ones, and z = -1 or 1.
 */
[[nodiscard]] std::vector<double> fromLineSpectrum(const std::vector<double>& frequencies);

}  // namespace hapticctl
