#include "daemon/resource/json.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <utility>

namespace hapticd {
namespace {

void printText(std::string_view text, std::string& out) {
  const auto plain = [](char c) { return c >= 0x20 && c < 0x7f && c != '"' && c != '\\'; };
  if (std::ranges::all_of(text, plain)) {
    out.append(1, '"').append(text).append(1, '"');
  } else {
    out += nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  }
}

/** The fewest digits that are read back as it is, as nlohmann::json sets them out. */
void printReal(double x, std::string& out) {
  if (!std::isfinite(x)) {
    out += "null";
    return;
  }
  const bool fixed = x == 0 || (std::fabs(x) >= 1e-4 && std::fabs(x) < 1e15);
  std::array<char, 32> text;
  const auto [end, error] =
      std::to_chars(text.begin(), text.end(), x, fixed ? std::chars_format::fixed : std::chars_format::scientific);
  out.append(text.begin(), end);
  if (fixed && std::find(text.begin(), end, '.') == end) out += ".0";
}

}  // namespace

Json::Json(const std::vector<std::string>& texts) : value_(Array(texts.begin(), texts.end())) {}

Json::Json(std::initializer_list<Json> list) {
  const auto named = [](const Json& pair) {
    const auto* const both = std::get_if<Array>(&pair.value_);
    return both != nullptr && both->size() == 2 && std::holds_alternative<std::string>(both->front().value_);
  };
  if (!std::ranges::all_of(list, named)) {
    value_ = Array(list);
    return;
  }
  Object object;
  for (const Json& pair : list) {
    const Array& both = std::get<Array>(pair.value_);
    object.emplace(std::get<std::string>(both.front().value_), both.back());
  }
  value_ = std::move(object);
}

Json& Json::operator[](std::string_view name) {
  if (std::holds_alternative<std::nullptr_t>(value_)) value_ = Object();
  auto& object = std::get<Object>(value_);
  const auto it = object.find(name);
  return it != object.end() ? it->second : object.emplace(name, Json()).first->second;
}

bool Json::contains(std::string_view name) const {
  const auto* const object = std::get_if<Object>(&value_);
  return object != nullptr && object->contains(name);
}

void Json::push_back(Json value) {
  if (std::holds_alternative<std::nullptr_t>(value_)) value_ = Array();
  std::get<Array>(value_).push_back(std::move(value));
}

std::string Json::print() const {
  std::string out;
  printTo(out);
  return out;
}

void Json::printTo(std::string& out) const {
  const auto each = [&](const auto& all, char begin, char end, auto&& print) {
    out += begin;
    for (auto it = all.begin(); it != all.end(); ++it) {
      if (it != all.begin()) out += ',';
      print(*it);
    }
    out += end;
  };
  if (const auto* const array = std::get_if<Array>(&value_)) {
    each(*array, '[', ']', [&](const Json& value) { value.printTo(out); });
  } else if (const auto* const object = std::get_if<Object>(&value_)) {
    each(*object, '{', '}', [&](const auto& pair) {
      printText(pair.first, out);
      out += ':';
      pair.second.printTo(out);
    });
  } else if (const auto* const text = std::get_if<std::string>(&value_)) {
    printText(*text, out);
  } else if (const auto* const real = std::get_if<double>(&value_)) {
    printReal(*real, out);
  } else if (const auto* const yes = std::get_if<bool>(&value_)) {
    out += *yes ? "true" : "false";
  } else if (const auto* const whole = std::get_if<std::int64_t>(&value_)) {
    fmt::format_to(std::back_inserter(out), "{}", *whole);
  } else if (const auto* const natural = std::get_if<std::uint64_t>(&value_)) {
    fmt::format_to(std::back_inserter(out), "{}", *natural);
  } else {
    out += "null";
  }
}

}  // namespace hapticd
