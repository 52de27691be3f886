#include "tools/hapticctl/file/hatt_file.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>
#include <pugixml.hpp>

#include "tools/hapticctl/exit_code.h"
#include "tools/hapticctl/failure.h"
#include "tools/hapticctl/numbers.h"

namespace hapticctl {
namespace {

constexpr std::size_t kMostModels = 256, kMostTriangles = 512, kMostOrder = 32;  // What the daemon takes.

/** Names the file and the place in every refusal. */
class Reader {
 public:
  explicit Reader(const std::string& path) : path_(path) {}

  [[noreturn]] void fail(const std::string& where, const std::string& what, const std::string& remedy = {}) const {
    throw Failure{kExitFile, path_ + ": " + where, what, remedy, "BAD_TEXTURE"};
  }

  [[nodiscard]] double number(const pugi::xml_node& node, const std::string& where) const {
    std::string_view text = node.child_value();
    const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; };
    while (!text.empty() && blank(text.front())) text.remove_prefix(1);
    while (!text.empty() && blank(text.back())) text.remove_suffix(1);
    if (const auto value = parseNumber(text)) return *value;
    fail(where, node ? fmt::format("'{}' is not a number", text.substr(0, 40)) : std::string("is missing"));
  }

  /** The <value> children of a node. */
  [[nodiscard]] std::vector<double> values(const pugi::xml_node& node, const std::string& where,
                                           std::size_t most) const {
    if (!node) fail(where, "is missing");
    std::vector<double> all;
    for (const pugi::xml_node value : node.children("value")) {
      if (all.size() == most) fail(where, fmt::format("has more than {} values", most));
      all.push_back(number(value, fmt::format("{}.value[{}]", where, all.size() + 1)));
    }
    return all;
  }

  [[nodiscard]] HattModel model(const pugi::xml_node& node, const std::string& where) const {
    HattModel model;
    model.speed = 1e-3 * number(node.child("speedMod"), where + ".speedMod");  // The toolkit counts in mm/s.
    model.force = number(node.child("forceMod"), where + ".forceMod");
    model.variance = number(node.child("var"), where + ".var");
    const std::vector<double> lines = values(node.child("ARlsf"), where + ".ARlsf", kMostOrder);
    double before = 0;
    for (std::size_t i = 0; i < lines.size(); ++i) {
      if (lines[i] > before && lines[i] < std::numbers::pi) {
        before = lines[i];
        continue;
      }
      fail(fmt::format("{}.ARlsf.value[{}]", where, i + 1),
           fmt::format("line spectral frequencies rise within (0, pi); {} does not", lines[i]));
    }
    if (lines.empty()) fail(where + ".ARlsf", "is empty");
    model.a = fromLineSpectrum(lines);
    return model;
  }

 private:
  const std::string& path_;
};

/** Multiplies a polynomial in z^-1 by 1 + b z^-1 + c z^-2. */
void multiply(std::vector<double>& p, double b, double c) {
  p.resize(p.size() + 2);
  for (std::size_t i = p.size(); i-- > 0;) {
    p[i] += (i >= 1 ? b * p[i - 1] : 0) + (i >= 2 ? c * p[i - 2] : 0);
  }
}

}  // namespace

std::vector<double> fromLineSpectrum(const std::vector<double>& frequencies) {
  std::vector<double> sum{1}, difference{1};  // P has the 1st, 3rd, ...; Q the 2nd, 4th, ...
  for (std::size_t i = 0; i < frequencies.size(); ++i) {
    multiply(i % 2 == 0 ? sum : difference, -2 * std::cos(frequencies[i]), 1);
  }
  if (frequencies.size() % 2 == 0) {
    multiply(sum, 1, 0);          // z = -1
    multiply(difference, -1, 0);  // z = 1
  } else {
    multiply(difference, 0, -1);  // both
  }
  std::vector<double> a(frequencies.size());
  for (std::size_t i = 0; i < a.size(); ++i) a[i] = 0.5 * (sum[i + 1] + difference[i + 1]);
  return a;
}

HattFile parseHatt(std::string_view xml, const std::string& path) {
  const Reader reader(path);
  pugi::xml_document document;
  const pugi::xml_parse_result parsed = document.load_buffer(xml.data(), xml.size());
  if (!parsed) reader.fail(fmt::format("byte {}", parsed.offset), parsed.description(), "it is not well-formed XML");
  const pugi::xml_node set = document.child("modelSet");
  if (!set) reader.fail("modelSet", "is missing", "this is not a model of the Haptic Texture Toolkit");
  HattFile file;
  if (const pugi::xml_node mu = set.child("mu")) file.friction = reader.number(mu, "mu");
  if (const pugi::xml_node ma = set.child("numMACoeff"); ma && reader.number(ma, "numMACoeff") != 0) {
    reader.fail("numMACoeff", "the models have moving-average terms", "only autoregressive models are rendered");
  }
  for (const pugi::xml_node model : set.children("model")) {
    if (file.models.size() == kMostModels) reader.fail("modelSet", fmt::format("more than {} models", kMostModels));
    file.models.push_back(reader.model(model, fmt::format("model[{}]", file.models.size() + 1)));
    if (file.models.back().a.size() != file.models.front().a.size()) {
      reader.fail(
          fmt::format("model[{}].ARlsf", file.models.size()),
          fmt::format("has {} values, the first model {}", file.models.back().a.size(), file.models.front().a.size()));
    }
  }
  if (file.models.size() < 3) reader.fail("model", fmt::format("{} models; 3 are the least", file.models.size()));
  for (const pugi::xml_node tri : set.children("tri")) {
    const std::string where = fmt::format("tri[{}]", file.triangles.size() + 1);
    if (file.triangles.size() == kMostTriangles) reader.fail(where, fmt::format("more than {}", kMostTriangles));
    const std::vector<double> corners = reader.values(tri, where, 3);
    if (corners.size() != 3) reader.fail(where, fmt::format("{} corners, not 3", corners.size()));
    std::array<std::uint32_t, 3> triangle{};
    for (std::size_t i = 0; i < 3; ++i) {
      const double corner = corners[i];
      if (!(corner >= 1 && corner <= static_cast<double>(file.models.size()) && corner == std::floor(corner))) {
        reader.fail(fmt::format("{}.value[{}]", where, i + 1),
                    fmt::format("{} is no model; they count from 1 to {}", corner, file.models.size()));
      }
      triangle[i] = static_cast<std::uint32_t>(corner) - 1;
    }
    file.triangles.push_back(triangle);
  }
  if (file.triangles.empty()) reader.fail("tri", "is missing: no triangles between the models");
  return file;
}

HattFile readHatt(const std::string& path) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), &std::fclose);
  constexpr std::size_t kMostBytes = 16u << 20;
  if (file == nullptr) throw Failure{kExitFile, path, "no such file, or it cannot be read", {}, "BAD_TEXTURE"};
  std::string text(kMostBytes + 1, '\0');
  text.resize(std::fread(text.data(), 1, text.size(), file.get()));
  if (text.size() > kMostBytes) throw Failure{kExitFile, path, "it is larger than 16 MiB", {}, "BAD_TEXTURE"};
  return parseHatt(text, path);
}

}  // namespace hapticctl
