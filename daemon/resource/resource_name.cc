#include "daemon/resource/resource_name.h"

#include <fmt/format.h>

#include <optional>

#include "drivers/number.h"

namespace hapticd {
namespace {

Error at(std::size_t byte, std::string what, std::string remedy) {
  return {ErrorCode::kInvalidArgument, fmt::format("byte {}", byte), std::move(what), std::move(remedy)};
}

int hexDigit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

/** Decodes text[begin, end). Only printable ASCII comes out: names and values need no more. */
Result<std::string> decode(std::string_view text, std::size_t begin, std::size_t end) {
  std::string out;
  for (std::size_t i = begin; i < end; ++i) {
    const std::size_t start = i;
    char c = text[i];
    if (c == '%') {
      if (end - i < 3 || hexDigit(text[i + 1]) < 0 || hexDigit(text[i + 2]) < 0) {
        return at(start, "'%' is not followed by two hexadecimal digits", "write %25 for a percent sign");
      }
      c = static_cast<char>(hexDigit(text[i + 1]) * 16 + hexDigit(text[i + 2]));
      i += 2;
    }
    if (c < 0x20 || c > 0x7e) {
      return at(start, fmt::format("character 0x{:02x} is not printable ASCII", static_cast<unsigned char>(c)),
                "names and values need no more than letters, digits and signs");
    }
    out.push_back(c);
  }
  return out;
}

}  // namespace

const std::string* ResourceName::find(std::string_view key) const {
  for (const auto& [k, v] : query) {
    if (k == key) return &v;
  }
  return nullptr;
}

std::string ResourceName::upTo(std::size_t last) const {
  std::string path;
  for (std::size_t i = 0; i <= last && i < element.size(); ++i) path += "/" + element[i];
  return path.empty() ? "/" : path;
}

Result<ResourceName> parseResourceName(std::string_view text) {
  if (text.size() > kMaxResourceName) {
    return at(kMaxResourceName, fmt::format("the name has {} bytes; {} is the most", text.size(), kMaxResourceName),
              "shorten it");
  }
  if (text.empty() || text[0] != '/') return at(0, "a resource name starts with '/'", "for example /objects");
  ResourceName name;
  const std::size_t question = std::min(text.find('?'), text.size());
  std::size_t begin = 1;
  while (begin < question) {
    const std::size_t end = std::min(text.find('/', begin), question);
    if (end == begin) return at(begin, "a path element is empty", "write a single '/' between elements");
    auto element = decode(text, begin, end);
    if (!element) return element.error();
    if (name.element.size() == kMaxResourceElements) {
      return at(begin, fmt::format("more than {} path elements", kMaxResourceElements), "shorten it");
    }
    name.element.push_back(std::move(*element));
    begin = end + 1;
  }
  begin = question + 1;
  while (begin < text.size()) {
    const std::size_t end = std::min(text.find('&', begin), text.size());
    const std::size_t equals = text.find('=', begin);
    if (equals == std::string_view::npos || equals >= end || equals == begin) {
      return at(begin, "a query is key=value", "for example ?value=0,0,0.02");
    }
    auto key = decode(text, begin, equals);
    if (!key) return key.error();
    auto value = decode(text, equals + 1, end);
    if (!value) return value.error();
    if (name.find(*key) != nullptr) return at(begin, fmt::format("'{}' is given twice", *key), "give it once");
    name.query.emplace_back(std::move(*key), std::move(*value));
    begin = end + 1;
  }
  return name;
}

Result<std::vector<double>> parseNumbers(std::string_view text, std::size_t count, const std::string& where) {
  const std::string how = fmt::format("give {} in SI units, with '.' as the decimal point",
                                      count == 1 ? "one number" : fmt::format("{} numbers separated by commas", count));
  std::vector<double> numbers;
  std::string_view rest = text;
  while (true) {
    const std::size_t comma = rest.find(',');
    const std::string_view token = trimmed(rest.substr(0, comma));
    const bool plus = token.size() > 1 && token[0] == '+' && token[1] != '-';  // As on the command line.
    const std::optional<double> value = parseNumber(token.substr(plus ? 1 : 0));
    if (!value) {
      return Error{
          ErrorCode::kInvalidArgument, where,
          count == 1 ? fmt::format("'{}' is not a finite number", token.substr(0, 40))
                     : fmt::format("number {} ('{}') is not a finite number", numbers.size() + 1, token.substr(0, 40)),
          how};
    }
    numbers.push_back(*value);
    if (comma == std::string_view::npos) break;
    rest.remove_prefix(comma + 1);
    if (numbers.size() > count) break;
  }
  if (numbers.size() == count) return numbers;
  return Error{ErrorCode::kInvalidArgument, where,
               fmt::format("{} needed, not {}{}", count == 1 ? "one number is" : fmt::format("{} numbers are", count),
                           numbers.size() > count ? "at least " : "", numbers.size()),
               how};
}

Result<bool> parseBool(std::string_view text, const std::string& where) {
  const std::string_view word = trimmed(text);
  if (word == "true" || word == "1" || word == "on") return true;
  if (word == "false" || word == "0" || word == "off") return false;
  return Error{ErrorCode::kInvalidArgument, where, fmt::format("'{}' is neither true nor false", word.substr(0, 40)),
               "true or false"};
}

}  // namespace hapticd
