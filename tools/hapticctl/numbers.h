/** @file
 * Numbers in and out, without the locale's help: 0.5 is a half wherever hapticctl runs.
 */
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace hapticctl {

/** The whole text as a finite number, else nothing. */
[[nodiscard]] std::optional<double> parseNumber(std::string_view text);
/** Numbers between commas. Fails with usage, naming `option` and the field, unless `count` (0: any) finite ones stand
 * there. */
[[nodiscard]] std::vector<double> parseNumbers(std::string_view option, std::string_view text, std::size_t count);
[[nodiscard]] std::array<double, 3> parseVec3(std::string_view option, std::string_view text);

/**
 * A rotation as a unit quaternion w, x, y, z: "x,90" turns by degrees about an axis, four numbers are a quaternion
 * (made unit). Fails with usage.
 */
[[nodiscard]] std::array<double, 4> parseRotation(std::string_view option, std::string_view text);
/** a after b. */
[[nodiscard]] std::array<double, 4> multiply(const std::array<double, 4>& a, const std::array<double, 4>& b);

/** Shortest text that reads back as the same number. */
[[nodiscard]] std::string exact(double value);
/** `digits` after the point; "-" where not finite; never "-0.00". */
[[nodiscard]] std::string fixed(double value, int digits);
/** 1234567 as "1 234 567". */
[[nodiscard]] std::string grouped(std::uint64_t value);
/** A duration with its unit: "870 ns", "12.4 us", "3.02 ms", "1.50 s". */
[[nodiscard]] std::string duration(double nanoseconds);
/** A length with its unit: "12.5 mm", "0.95 m". */
[[nodiscard]] std::string length(double metres);
/** Bytes with a binary unit: "3.4 MiB". */
[[nodiscard]] std::string bytes(std::uint64_t count);

}  // namespace hapticctl
