/** @file
 * A JSON value to be printed. nlohmann::json's destructor allocates, and so ends the process where memory is out; this
 * one's does not.
 */
#pragma once

#include <concepts>
#include <cstdint>
#include <initializer_list>
#include <map>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace hapticd {

/** Built as nlohmann::json is: a list of pairs, each with a text first, is an object; every other list an array. */
class Json {
 public:
  Json() = default;
  // NOLINTBEGIN(google-explicit-constructor): a value stands for itself.
  Json(std::nullptr_t) {}
  template <std::integral Number>
  Json(Number n) {
    if constexpr (std::same_as<Number, bool>) {
      value_ = n;
    } else if constexpr (std::signed_integral<Number>) {
      value_ = std::int64_t{n};
    } else {
      value_ = std::uint64_t{n};
    }
  }
  Json(double x) : value_(x) {}
  template <std::convertible_to<std::string_view> Text>
  Json(const Text& text) : value_(std::string(std::string_view(text))) {}
  Json(const std::vector<std::string>& texts);
  Json(std::initializer_list<Json> list);
  // NOLINTEND(google-explicit-constructor)

  [[nodiscard]] static Json array() { return Json(Array()); }
  [[nodiscard]] static Json object() { return Json(Object()); }

  /** Of an object, or of null, which becomes one: the value of that name, null if it is new. */
  Json& operator[](std::string_view name);
  [[nodiscard]] bool contains(std::string_view name) const;
  /** To an array, or to null, which becomes one. */
  void push_back(Json value);  // NOLINT(readability-identifier-naming): as std::vector's

  /** Names of an object in their order; what is not UTF-8 is replaced. */
  [[nodiscard]] std::string print() const;

 private:
  using Array = std::vector<Json>;
  using Object = std::map<std::string, Json, std::less<>>;
  explicit Json(Array array) : value_(std::move(array)) {}
  explicit Json(Object object) : value_(std::move(object)) {}
  void printTo(std::string& out) const;

  std::variant<std::nullptr_t, bool, std::int64_t, std::uint64_t, double, std::string, Array, Object> value_ = nullptr;
};

}  // namespace hapticd
