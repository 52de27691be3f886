// A Config as TOML that reads back to the same.
#include "daemon/config/config_schema.h"

namespace hapticd {
namespace {

std::string quoted(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (byte < 0x20 || byte == 0x7f) {
      out += fmt::format("\\u{:04X}", byte);
    } else {
      out += c;
    }
  }
  return out + '"';
}

class Writer {
 public:
  std::string text_;

  void number(std::string_view key, double value, double, double) { line(key, fmt::format("{}", value)); }
  void integer(std::string_view key, std::uint32_t value, std::int64_t, std::int64_t) {
    line(key, fmt::format("{}", value));
  }
  void flag(std::string_view key, bool value) { line(key, value ? "true" : "false"); }
  void text(std::string_view key, const std::string& value) { line(key, quoted(value)); }
  void mode(std::string_view key, std::uint32_t value) { line(key, fmt::format("0o{:03o}", value)); }
  void level(std::string_view key, log::Level value) { line(key, quoted(log::toString(value))); }
  void texts(std::string_view key, const std::vector<std::string>& values) {
    list(key, values, [](const std::string& value) { return quoted(value); });
  }
  void integers(std::string_view key, const std::vector<std::uint32_t>& values, std::int64_t, std::int64_t) {
    list(key, values, [](std::uint32_t value) { return fmt::format("{}", value); });
  }
  void triple(std::string_view key, const std::vector<double>& values, double, double) {
    list(key, values, [](double value) { return fmt::format("{}", value); });
  }
  template <class Visit>
  void table(std::string_view key, Visit&& visit) {
    text_ += fmt::format("{}[{}]\n", text_.empty() ? "" : "\n", key);
    visit(*this);
  }
  template <class Element, class Visit>
  void tables(std::string_view key, const std::vector<Element>& elements, Visit&& visit) {
    for (const Element& element : elements) {
      text_ += fmt::format("\n[[{}]]\n", key);
      visit(*this, element);
    }
  }

 private:
  void line(std::string_view key, std::string_view value) { text_ += fmt::format("{} = {}\n", key, value); }
  template <class Element, class Write>
  void list(std::string_view key, const std::vector<Element>& values, Write&& write) {
    std::string all;
    for (const Element& value : values) all += (all.empty() ? "" : ", ") + write(value);
    line(key, "[" + all + "]");
  }
};

}  // namespace

std::string toToml(const Config& config) {
  Config whole = config;
  for (GroupConfig& group : whole.groups)
    if (group.rate_hz == 0) group.rate_hz = config.servo.rate_hz;  // 0 is only "not given"
  Writer writer;
  visitConfig(writer, std::as_const(whole));
  return writer.text_;
}

}  // namespace hapticd
