/** @file
 * Numbers to and from text without the locale: "0.5" is a half in every country.
 */
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "rt/base/math.h"

namespace hapticd {

/** The whole of `text` as a finite number ("1e-3", "-2"); nothing if it is anything else. */
[[nodiscard]] std::optional<double> parseNumber(std::string_view text) noexcept;
/** The whole of `text` as a decimal integer >= 0. */
[[nodiscard]] std::optional<std::uint64_t> parseInteger(std::string_view text) noexcept;
/** "x,y,z". */
[[nodiscard]] std::optional<Vec3> parseVector(std::string_view text) noexcept;

/** Shortest text that parses to the same value. */
[[nodiscard]] std::string formatNumber(double value);
[[nodiscard]] std::string formatVector(const Vec3& value);

/** Without blanks and tabs at the ends. */
[[nodiscard]] std::string_view trimmed(std::string_view text) noexcept;

}  // namespace hapticd
