#include "tools/mesh_file/own/words.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "tools/mesh_file/mesh_error.h"

namespace hapticd_mesh_file {
namespace {

constexpr std::string_view kBlanks = " \t\r\n\v\f", kLineEnds = "\r\n";

}  // namespace

std::string bytesOf(const std::string& path) {
  if (!std::filesystem::is_regular_file(path)) {  // A pipe, say.
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  std::string bytes(std::filesystem::file_size(path), '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  bytes.resize(static_cast<std::size_t>(file.gcount()));  // Else what cannot be read were zeros.
  return bytes;
}

bool endsWith(const std::string& path, std::string_view ending) {
  return path.size() >= ending.size() && lower(std::string_view(path).substr(path.size() - ending.size())) == ending;
}

std::string_view withoutMark(std::string_view text) {
  constexpr std::string_view kMark = "\xef\xbb\xbf";
  return text.substr(text.substr(0, kMark.size()) == kMark ? kMark.size() : 0);
}

void refuse(const std::string& what) { throw MeshError(what, "it is damaged or cut short: export it again", kBadMesh); }

std::string shown(std::string_view word, std::size_t most) {
  std::string text(word.substr(0, most));
  for (char& c : text)
    if (c < 32 || c > 126) c = '?';
  return text;
}

std::string lower(std::string_view word) {
  std::string out(word);
  for (char& c : out) c = static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  return out;
}

std::string_view takeWord(std::string_view& text) {
  text.remove_prefix(std::min(text.size(), text.find_first_not_of(kBlanks)));
  const std::string_view word = text.substr(0, text.find_first_of(kBlanks));
  text.remove_prefix(word.size());
  return word;
}

std::string_view takeLine(std::string_view& text) {
  const std::string_view line = text.substr(0, text.find_first_of(kLineEnds));
  text.remove_prefix(std::min(text.size(), line.size() + 1));
  return line;
}

std::optional<double> numberIn(std::string_view word) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  std::string pointed;
  if (const std::size_t comma = word.find(','); comma != word.npos) {
    pointed = word;
    pointed[comma] = '.';
    word = pointed;
  }
  double value = 0;
  const auto [end, problem] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (end != word.data() + word.size()) return std::nullopt;
  if (problem == std::errc::result_out_of_range) return word.find('-', 1) != word.npos ? 0 : INFINITY;
  return problem == std::errc() ? std::optional(value) : std::nullopt;
}

}  // namespace hapticd_mesh_file
