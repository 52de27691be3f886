/** @file
 * Resource names (thesis section 5.2.5): /objects/C/pos reads, /objects/C/pos?value=1,2,3 writes, /_objects/A/B/C is
 * the representation tree, /devices/NAME/... and /statistics/... tell the state.
 */
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "rt/base/error.h"

namespace hapticd {

struct ResourceName {
  std::vector<std::string> element;  ///< Percent-decoded; none for "/".
  std::vector<std::pair<std::string, std::string>> query;

  /** The value of a query key, if it is there. */
  [[nodiscard]] const std::string* find(std::string_view key) const;
  /** "/a/b" up to and including element `last`; for error messages. */
  [[nodiscard]] std::string upTo(std::size_t last) const;
};

inline constexpr std::size_t kMaxResourceName = 4096;  ///< Bytes.
inline constexpr std::size_t kMaxResourceElements = 64;

/** kInvalidArgument names the byte at fault. Any bytes may come in. Fuzzed. */
[[nodiscard]] Result<ResourceName> parseResourceName(std::string_view text);

/** `count` finite numbers separated by commas, spaces around them allowed; locale-free. */
[[nodiscard]] Result<std::vector<double>> parseNumbers(std::string_view text, std::size_t count,
                                                       const std::string& where);
[[nodiscard]] Result<bool> parseBool(std::string_view text, const std::string& where);

}  // namespace hapticd
