/** @file
 * Typed parameters of a device, settable in the query of its URI. One table of Parameter drives parsing, error
 * messages, the canonical URI and the documentation.
 */
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "rt/base/error.h"
#include "rt/base/math.h"

namespace hapticd {

/** What a user is told of a parameter. The range holds for each component of a vector. */
struct ParameterSpec {
  std::string_view key;
  std::string_view unit;  ///< "" for a bare number.
  double lowest = 0, highest = 0;
  std::string_view doc;      ///< One sentence.
  std::string_view choices;  ///< "a|b|c" for words that must be one of these; "" for free text.
};

/** Where a value goes; the alternative is its type. */
using ParameterSlot = std::variant<double*, std::uint64_t*, bool*, Vec3*, std::string*>;

/** A parameter of the struct S. */
template <class S>
struct Parameter {
  ParameterSpec spec;
  std::variant<double S::*, std::uint64_t S::*, bool S::*, Vec3 S::*, std::string S::*> member;

  [[nodiscard]] ParameterSlot slot(S& values) const {
    return std::visit([&](auto pointer) -> ParameterSlot { return &(values.*pointer); }, member);
  }
};

/** Sets the slot, or says why `text` does not fit: kInvalidArgument names key, value and what is allowed. */
[[nodiscard]] Result<void> setParameter(const ParameterSpec& spec, ParameterSlot slot, std::string_view text);
/** The text that setParameter turns into the same value. */
[[nodiscard]] std::string formatParameter(ParameterSlot slot);
/** "number", "integer", "yes or no", "x,y,z", "text" or the choices, with range and unit. */
[[nodiscard]] std::string describeRange(const ParameterSpec& spec, ParameterSlot slot);
/** kInvalidArgument naming the key and the nearest of `keys`. */
[[nodiscard]] Error unknownKey(std::string_view key, const std::vector<std::string_view>& keys);

/** Sets every pair of the query; stops at the first that is wrong. */
template <class S>
[[nodiscard]] Result<void> applyQuery(const std::vector<Parameter<S>>& table,
                                      const std::vector<std::pair<std::string, std::string>>& query, S& values) {
  for (const auto& [key, text] : query) {
    const Parameter<S>* found = nullptr;
    for (const Parameter<S>& parameter : table) {
      if (parameter.spec.key == key) found = &parameter;
    }
    if (found == nullptr) {
      std::vector<std::string_view> keys;
      keys.reserve(table.size());
      for (const Parameter<S>& parameter : table) keys.push_back(parameter.spec.key);
      return unknownKey(key, keys);
    }
    Result<void> set = setParameter(found->spec, found->slot(values), text);
    if (!set) return set.error();
  }
  return {};
}

/** The pairs in which `values` differs from `base`, in the order of the table. */
template <class S>
[[nodiscard]] std::vector<std::pair<std::string, std::string>> difference(const std::vector<Parameter<S>>& table,
                                                                          S values, S base) {
  std::vector<std::pair<std::string, std::string>> query;
  for (const Parameter<S>& parameter : table) {
    std::string text = formatParameter(parameter.slot(values));
    if (text != formatParameter(parameter.slot(base))) query.emplace_back(parameter.spec.key, std::move(text));
  }
  return query;
}

}  // namespace hapticd
