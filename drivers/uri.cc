/** @file
 * Device URIs: the subset of RFC 3986 that names devices, checked character by character.
 */
#include <fmt/format.h>

#include "drivers/registry.h"

namespace hapticd {
namespace {

constexpr std::size_t kMaxPairs = 128;
constexpr std::string_view kForm = "a device URI looks like sim://default?motion=circle&radius=0.03";

bool isLetter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
bool isDigit(char c) { return c >= '0' && c <= '9'; }
bool isKeyCharacter(char c) { return isLetter(c) || isDigit(c) || c == '_' || c == '-' || c == '.'; }
bool isControl(char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; }
char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

int hexValue(char c) {
  if (isDigit(c)) return c - '0';
  c = lower(c);
  return c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

std::string show(char c) {
  const auto byte = static_cast<unsigned char>(c);
  return byte > 0x20 && byte < 0x7f ? fmt::format("'{}'", c) : fmt::format("byte 0x{:02x}", byte);
}

Error fault(std::size_t position, std::string what, std::string remedy = std::string(kForm)) {
  return {ErrorCode::kInvalidArgument, fmt::format("device URI, character {}", position + 1), std::move(what),
          std::move(remedy)};
}

/** text[begin, end) percent-decoded. */
Result<std::string> decode(std::string_view text, std::size_t begin, std::size_t end) {
  std::string out;
  for (std::size_t i = begin; i < end; ++i) {
    char c = text[i];
    if (c == '#') return fault(i, "a fragment ('#') means nothing here", "write %23 for the character itself");
    if (c == '%') {
      const int high = i + 1 < end ? hexValue(text[i + 1]) : -1;
      const int low = i + 2 < end ? hexValue(text[i + 2]) : -1;
      if (high < 0 || low < 0) {
        return fault(i, "'%' is not followed by two hexadecimal digits", "write %25 for the character itself");
      }
      c = static_cast<char>(high * 16 + low);
      if (isControl(c)) return fault(i, "a control character", "take it out");
      i += 2;
    } else if (isControl(c)) {
      return fault(i, "a control character (" + show(c) + ")", "take it out");
    }
    out.push_back(c);
  }
  return out;
}

Result<void> parsePair(std::string_view text, std::size_t begin, std::size_t end, DeviceUri& uri) {
  const std::size_t equals = text.substr(begin, end - begin).find('=');
  if (begin == end) return fault(begin, "an empty key=value pair");
  if (equals == std::string_view::npos) {
    return fault(begin, fmt::format("\"{}\" has no value", text.substr(begin, end - begin)), "write key=value");
  }
  const std::string_view key = text.substr(begin, equals);
  if (key.empty()) return fault(begin, "a value without a key");
  for (std::size_t i = 0; i < key.size(); ++i) {
    if (!isKeyCharacter(key[i])) return fault(begin + i, show(key[i]) + " in a key");
  }
  for (const auto& [earlier, value] : uri.query) {
    if (earlier == key) return fault(begin, fmt::format("the key \"{}\" is given twice", key), "keep one of them");
  }
  Result<std::string> value = decode(text, begin + equals + 1, end);
  if (!value) return value.error();
  uri.query.emplace_back(std::string(key), std::move(*value));
  return {};
}

void encode(std::string_view text, std::string_view reserved, std::string& out) {
  for (const char c : text) {
    if (isControl(c) || c == '%' || c == '#' || c == ' ' || reserved.find(c) != std::string_view::npos) {
      out += fmt::format("%{:02X}", static_cast<unsigned char>(c));
    } else {
      out.push_back(c);
    }
  }
}

}  // namespace

Result<DeviceUri> parseDeviceUri(std::string_view text) {
  if (text.size() > kMaxUriBytes) {
    return fault(kMaxUriBytes, fmt::format("longer than {} bytes", kMaxUriBytes), "shorten it");
  }
  const std::size_t colon = text.find("://");
  if (colon == std::string_view::npos) return fault(text.size(), "no \"://\"");
  if (colon == 0) return fault(0, "no scheme before \"://\"");
  DeviceUri uri;
  for (std::size_t i = 0; i < colon; ++i) {
    const char c = text[i];
    const bool fits = isLetter(c) || (i > 0 && (isDigit(c) || c == '+' || c == '-' || c == '.'));
    if (!fits) return fault(i, show(c) + " in a scheme");
    uri.scheme.push_back(lower(c));
  }
  const std::size_t authority = colon + 3;
  const std::size_t question = std::min(text.find('?', authority), text.size());
  Result<std::string> decoded = decode(text, authority, question);
  if (!decoded) return decoded.error();
  uri.authority = std::move(*decoded);

  for (std::size_t begin = question + 1; begin <= text.size();) {
    if (uri.query.size() == kMaxPairs) return fault(begin, fmt::format("more than {} pairs", kMaxPairs), "shorten it");
    const std::size_t end = std::min(text.find('&', begin), text.size());
    if (begin == end && begin == text.size() && uri.query.empty()) break;  // "sim://default?" asks for nothing.
    Result<void> pair = parsePair(text, begin, end, uri);
    if (!pair) return pair.error();
    begin = end + 1;
  }
  return uri;
}

std::string formatDeviceUri(const DeviceUri& uri) {
  std::string out = uri.scheme + "://";
  encode(uri.authority, "?", out);
  char separator = '?';
  for (const auto& [key, value] : uri.query) {
    out.push_back(separator);
    out += key + '=';
    encode(value, "&", out);
    separator = '&';
  }
  return out;
}

}  // namespace hapticd
