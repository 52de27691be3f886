#include "tools/mesh_file/own/ply.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <vector>

#include "tools/mesh_file/own/words.h"

namespace hapticd_mesh_file {
namespace {

constexpr std::string_view kPlyBlanks = " \t\r\v\f";

enum class PlyType : std::uint8_t { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat, kDouble };

PlyType typeOf(std::string_view word) {
  static constexpr std::pair<const char*, PlyType> kTypes[] = {
      {"char", PlyType::kInt8},     {"int8", PlyType::kInt8},     {"uchar", PlyType::kUint8},
      {"uint8", PlyType::kUint8},   {"short", PlyType::kInt16},   {"int16", PlyType::kInt16},
      {"ushort", PlyType::kUint16}, {"uint16", PlyType::kUint16}, {"int", PlyType::kInt32},
      {"int32", PlyType::kInt32},   {"uint", PlyType::kUint32},   {"uint32", PlyType::kUint32},
      {"float", PlyType::kFloat},   {"float32", PlyType::kFloat}, {"double", PlyType::kDouble},
      {"float64", PlyType::kDouble}};
  for (const auto& [name, type] : kTypes)
    if (word == name) return type;
  refuse(fmt::format("its header names no kind of number that PLY has: '{}'", shown(word)));
}

struct PlyProperty {
  std::string_view name;
  PlyType type = PlyType::kFloat;
  std::optional<PlyType> count;  ///< Of a list.
};

struct PlyElement {
  std::string_view name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;

  /** Its place among the properties; none: properties.size(). */
  [[nodiscard]] std::size_t find(std::string_view property) const {
    const auto found =
        std::find_if(properties.begin(), properties.end(), [&](const PlyProperty& p) { return p.name == property; });
    return static_cast<std::size_t>(found - properties.begin());
  }
};

/** The file, and how far it has been read. */
class Ply {
 public:
  explicit Ply(std::string_view bytes) : rest_(bytes) {
    if (rest_.size() > 4 && rest_[3] == '\r' && rest_[4] != '\n') line_end_ = '\r';
    std::string_view line, format;
    (void)takeLine(line);
    for (;;) {
      if (!takeLine(line)) refuse("its header has no end");
      const std::string_view key = takeWord(line);
      if (key == "end_header") break;
      if (key == "format") format = takeWord(line);
      if (key == "element") element(line);
      if (key == "property") property(line);
    }
    if (format == "binary_big_endian") order_ = std::endian::big;
    in_words_ = format == "ascii";
    if (!in_words_ && format != "binary_big_endian" && format != "binary_little_endian")
      refuse(fmt::format("is PLY of a format that is not known: '{}'", shown(format)));
  }

  [[nodiscard]] const std::vector<PlyElement>& elements() const { return elements_; }

  /** One more of an element: `list` becomes what property `wanted` holds, `numbers` those that are no lists. */
  void take(const PlyElement& element, std::uint64_t number, std::vector<double>& numbers, std::size_t wanted,
            std::vector<double>& list) {
    at_ = &element;
    number_ = number;
    std::string_view line;
    for (bool empty = in_words_; empty; empty = line.find_first_not_of(kPlyBlanks) == line.npos)
      if (!takeLine(line)) cutShort();
    numbers.assign(element.properties.size(), 0);
    for (std::size_t i = 0; i < element.properties.size(); ++i) {
      const PlyProperty& p = element.properties[i];
      if (!p.count) {
        numbers[i] = next(p.type, line);
        continue;
      }
      const double count = next(*p.count, line);
      if (!(count >= 0) || count != std::floor(count)) refuse(fmt::format("{} has a list of {}", where(), count));
      if (i == wanted) list.clear();
      for (double left = count; left > 0; --left) {
        const double value = next(p.type, line);
        if (i == wanted) list.push_back(value);
      }
    }
  }

  /** Whether so many of an element can be there: each of its properties takes a byte at least. */
  void requireRoom(const PlyElement& element) {
    at_ = &element;
    number_ = 0;
    if (element.count > rest_.size() / std::max<std::size_t>(1, element.properties.size()) + 1) {
      refuse(fmt::format("is cut short: it has {} bytes for {} of element '{}'", rest_.size(), element.count,
                         shown(element.name)));
    }
  }

 private:
  bool takeLine(std::string_view& line) {
    if (rest_.empty()) return false;
    const std::size_t end = std::min(rest_.find(line_end_), rest_.size());
    line = rest_.substr(0, end);
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
    return true;
  }

  void element(std::string_view line) {
    PlyElement one;
    one.name = takeWord(line);
    const std::string_view count = takeWord(line);
    const auto [end, problem] = std::from_chars(count.data(), count.data() + count.size(), one.count);
    if (problem != std::errc() || end != count.data() + count.size())
      refuse(fmt::format("its header does not say how many of element '{}'", shown(one.name)));
    elements_.push_back(std::move(one));
  }

  void property(std::string_view line) {
    if (elements_.empty()) refuse("its header has a property before all elements");
    PlyProperty one;
    std::string_view type = takeWord(line);
    if (type == "list") {
      one.count = typeOf(takeWord(line));
      type = takeWord(line);
    }
    one.type = typeOf(type);
    one.name = takeWord(line);
    elements_.back().properties.push_back(one);
  }

  [[nodiscard]] std::string where() const { return fmt::format("{} {} of {}", shown(at_->name), number_, at_->count); }
  [[noreturn]] void cutShort() const { refuse("is cut short: it ends before " + where()); }

  double next(PlyType type, std::string_view& line) {
    if (in_words_) return word(line);
    switch (type) {
      case PlyType::kInt8:
        return binary<std::int8_t>();
      case PlyType::kUint8:
        return binary<std::uint8_t>();
      case PlyType::kInt16:
        return binary<std::int16_t>();
      case PlyType::kUint16:
        return binary<std::uint16_t>();
      case PlyType::kInt32:
        return binary<std::int32_t>();
      case PlyType::kUint32:
        return binary<std::uint32_t>();
      case PlyType::kFloat:
        return static_cast<double>(binary<float>());
      case PlyType::kDouble:
        return binary<double>();
    }
    return 0;
  }

  double word(std::string_view& line) const {
    std::string_view text = takeWord(line);
    if (text.empty()) refuse(where() + " has too few numbers in its line");
    const auto value = numberIn(text);
    if (!value) refuse(fmt::format("{}: '{}' is not a number", where(), shown(text)));
    return *value;
  }

  template <class T>
  T binary() {
    std::array<char, sizeof(T)> raw;
    if (rest_.size() < raw.size()) cutShort();
    std::memcpy(raw.data(), rest_.data(), raw.size());
    rest_.remove_prefix(raw.size());
    if (order_ != std::endian::native) std::reverse(raw.begin(), raw.end());
    return std::bit_cast<T>(raw);
  }

  std::string_view rest_;
  std::vector<PlyElement> elements_;
  char line_end_ = '\n';
  bool in_words_ = true;
  std::endian order_ = std::endian::little;
  const PlyElement* at_ = nullptr;
  std::uint64_t number_ = 0;  ///< Which of them is read.
};

unsigned cornerOf(double number, const PlyElement& element, std::uint64_t i) {
  if (number >= 0 && number <= 4294967295.0 && number == std::floor(number)) return static_cast<unsigned>(number);
  refuse(fmt::format("{} {} names vertex {}", element.name == "face" ? "face" : "strip", i, number));
}

/** Every three in a row, of which every other one is turned; -1 begins anew. */
void addStrip(const std::vector<double>& list, const PlyElement& element, std::uint64_t i, Polygons& faces) {
  std::vector<unsigned> strip;
  for (const double number : list) {
    if (number == -1) {
      strip.clear();
      continue;
    }
    strip.push_back(cornerOf(number, element, i));
    const std::size_t n = strip.size();
    if (n < 3) continue;
    const unsigned a = strip[n - 3], b = strip[n - 2], c = strip[n - 1];
    if (a == b || b == c || c == a) continue;  // It joins two strips.
    n % 2 != 0 ? faces.add({a, b, c}) : faces.add({b, a, c});
  }
}

}  // namespace

bool isPly(const std::string& path) {
  if (!std::filesystem::is_regular_file(path)) return endsWith(path, ".ply");  // It can be read but once.
  char first[4] = {};
  std::ifstream(path, std::ios::binary).read(first, sizeof first);
  const std::string_view magic(first, 3);
  return (magic == "ply" || magic == "PLY") && (first[3] == '\n' || kPlyBlanks.find(first[3]) != kPlyBlanks.npos);
}

Polygons parsePly(std::string_view bytes) {
  Ply ply(bytes);
  Polygons out;
  std::vector<double> numbers, list;
  for (const PlyElement& element : ply.elements()) {
    const bool is_vertex = element.name == "vertex", is_face = element.name == "face";
    const std::size_t none = element.properties.size();
    const std::size_t x = element.find("x"), y = element.find("y"), z = element.find("z");
    std::size_t wanted = element.find("vertex_indices");
    if (wanted == none) wanted = element.find("vertex_index");
    if (is_vertex && (x == none || y == none || z == none)) refuse("its vertices have no x, y and z");
    if (none == 0) continue;
    ply.requireRoom(element);
    for (std::uint64_t i = 0; i < element.count; ++i) {
      list.clear();
      ply.take(element, i, numbers, wanted, list);
      if (is_vertex) {
        out.vertices.push_back(
            {static_cast<float>(numbers[x]), static_cast<float>(numbers[y]), static_cast<float>(numbers[z])});
      } else if (is_face) {
        for (const double number : list) out.corners.push_back(cornerOf(number, element, i));
        out.sizes.push_back(static_cast<unsigned>(list.size()));
      } else if (element.name == "tristrips") {
        addStrip(list, element, i, out);
      }
    }
  }
  return out;
}

}  // namespace hapticd_mesh_file
