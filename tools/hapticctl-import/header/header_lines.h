/** @file
 * Lines and words of an image's header.
 */
#pragma once

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <fstream>
#include <string>
#include <string_view>

namespace hapticctl_import {

inline std::string_view stripped(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r";
  const auto first = text.find_first_not_of(kBlanks);
  return first == std::string_view::npos ? "" : text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

inline constexpr std::size_t kMostHeader = 1 << 20;

/** The beginning of a file, in which its header must end. Empty if it cannot be read. */
inline std::string headOf(const std::string& path) {
  std::string head(kMostHeader, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(file.gcount()));
  return head;
}

/** Of A to Z alone, whatever the locale. */
inline std::string lower(std::string_view text) {
  std::string out(text);
  for (char& c : out) c = static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  return out;
}

/** What is no count, or negative, is 0. */
inline std::uint64_t countIn(std::string_view text) {
  std::uint64_t n = 0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), n);
  return problem == std::errc() ? n : 0;
}

/** Lines of a header one after the other. */
class Lines {
 public:
  explicit Lines(std::string_view text) : text_(text) {}
  bool next(std::string_view& line) {
    if (at_ >= text_.size()) return false;
    const auto end = std::min(text_.find('\n', at_), text_.size());
    line = text_.substr(at_, end - at_);
    at_ = end + 1;
    return true;
  }
  [[nodiscard]] std::uint64_t passed() const { return at_; }

 private:
  std::string_view text_;
  std::size_t at_ = 0;
};

/** The next word of `text`, which loses it; empty: there is none. */
inline std::string_view takeWord(std::string_view& text) {
  text = stripped(text);
  const std::string_view word = text.substr(0, std::min(text.find_first_of(" \t"), text.size()));
  text.remove_prefix(word.size());
  return word;
}

}  // namespace hapticctl_import
