#include "tools/hapticctl/output/output.h"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <nlohmann/json.hpp>
#include <numeric>

#include "tools/hapticctl/failure.h"
#include "tools/hapticctl/output/terminal.h"

namespace hapticctl {
namespace {

std::string buffer;

/** Columns that a UTF-8 text takes: one per code point, good enough for names. */
std::size_t columnsOf(std::string_view text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

constexpr std::size_t kPiece = 4096;  // Of which a pipe that has room takes all.

constexpr int kLook_ms = 50, kPatience_ms = 1000;

/** For one piece, within so long; signals make that shorter. */
bool hasRoom(int fd, int most_ms) {
  pollfd out{fd, POLLOUT, 0};
  for (int left_ms = most_ms; left_ms > 0; left_ms -= kLook_ms) {
    if (const int n = ::poll(&out, 1, kLook_ms); n > 0 || (n < 0 && errno != EINTR)) return true;
  }
  return false;
}

/** For one piece. False: the command was asked to end, and its reader has taken nothing for a while. */
bool awaitRoom() {
  while (!Interrupt::asked()) {
    if (hasRoom(STDOUT_FILENO, kLook_ms)) return true;
  }
  return hasRoom(STDOUT_FILENO, kPatience_ms);
}

/** On standard error, as it is. */
void writeLine(std::string_view line) {
  const std::string text = std::string(line) + "\n";
  if (Interrupt::asked() && !hasRoom(STDERR_FILENO, kPatience_ms)) return;  // It may be the pipe that nobody reads.
  if (::write(STDERR_FILENO, text.data(), text.size()) < 0) return;         // Nobody to tell.
}

std::string onOneLine(const nlohmann::ordered_json& value) {
  return value.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

/** Lists of plain values, vectors most of all, stay on one line. */
void indent(std::string& out, const nlohmann::ordered_json& value, std::size_t depth) {
  const bool list = value.is_array();
  if (!value.is_structured() || value.empty() ||
      (list &&
       std::none_of(value.begin(), value.end(), [](const nlohmann::ordered_json& v) { return v.is_structured(); }))) {
    out += onOneLine(value);
    return;
  }
  const std::string margin(2 * depth, ' ');
  out += list ? '[' : '{';
  const char* gap = "\n";
  for (const auto& [key, entry] : value.items()) {
    out += gap + margin + "  ";
    if (!list) out += onOneLine(key) + ": ";
    indent(out, entry, depth + 1);
    gap = ",\n";
  }
  out += "\n" + margin + (list ? ']' : '}');
}

}  // namespace

std::string printable(std::string_view text) {
  std::string out;
  unsigned char before = 0;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    const bool c1 = before == 0xc2 && byte >= 0x80 && byte < 0xa0;  // U+0080 to U+009F steer terminals, too.
    if (c1) out.pop_back();
    out += c1 || (byte < 0x20 && c != '\n' && c != '\t') || byte == 0x7f ? '?' : c;
    before = byte;
  }
  return out;
}

void put(std::string_view text) {
  buffer += text;
  if (buffer.size() > (1u << 16)) flush();
}

void putJson(const nlohmann::ordered_json& value, bool one_line) {
  std::string text;
  if (one_line) {
    text = onOneLine(value);
  } else {
    indent(text, value, 0);
  }
  put(text + "\n");
}

void flush() {
  std::string_view rest = buffer;
  while (!rest.empty()) {
    if (!awaitRoom()) {
      buffer.clear();
      throw Failure{kExitFile, "standard output", "its reader stands still", "what was to come is lost: begin again"};
    }
    const ssize_t n = ::write(STDOUT_FILENO, rest.data(), std::min(rest.size(), kPiece));
    if (n >= 0) {
      rest.remove_prefix(static_cast<std::size_t>(n));
    } else if (errno != EINTR) {
      const int error = errno;
      buffer.clear();
      if (error == EPIPE) throw OutputClosed{};
      throw Failure{kExitFile, "standard output", std::strerror(error), {}};
    }
  }
  buffer.clear();
}

void expectReader() {
  pollfd out{STDOUT_FILENO, 0, 0};
  if (::poll(&out, 1, 0) == 1 && (out.revents & (POLLERR | POLLHUP)) != 0) throw OutputClosed{};
}

void note(std::string_view line) { writeLine(printable(line)); }

void report(const Failure& failure, bool json) {
  if (json) {
    const nlohmann::ordered_json error = {
        {"error",
         {{"code", failure.code}, {"where", failure.where}, {"what", failure.what}, {"remedy", failure.remedy}}}};
    writeLine(error.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
    return;
  }
  std::string text = "hapticctl: ";
  const bool told = failure.where == "name" && failure.code == "NOT_FOUND";  // A parameter's; the rest says of what.
  if (!failure.where.empty() && !told) text += failure.where + ": ";
  if (failure.where.empty() && failure.exit == kExitFile) text += "'': ";  // An empty name, as of an unset variable.
  text += failure.what;
  if (!failure.remedy.empty()) {
    text += "\n  ";
    for (const char c : failure.remedy) {
      text += c;
      if (c == '\n') text += "  ";
    }
  }
  note(text);
}

bool colourful() {
  static const bool answer = [] {
    const char* no_color = std::getenv("NO_COLOR");
    const char* term = std::getenv("TERM");
    return isatty(STDOUT_FILENO) != 0 && (no_color == nullptr || *no_color == '\0') && term != nullptr &&
           std::strcmp(term, "dumb") != 0;
  }();
  return answer;
}

std::string styled(Style style, std::string_view text) {
  if (!colourful() || style == Style::kPlain) return std::string(text);
  const char* code = "";
  switch (style) {
    case Style::kPlain:
      break;
    case Style::kBold:
      code = "1";
      break;
    case Style::kDim:
      code = "2";
      break;
    case Style::kGood:
      code = "32";
      break;
    case Style::kBad:
      code = "1;31";
      break;
    case Style::kWarn:
      code = "33";
      break;
  }
  return fmt::format("\x1b[{}m{}\x1b[0m", code, text);
}

void Table::row(std::vector<std::string> cells, Style style) {
  for (std::string& cell : cells) cell = printable(cell);
  cells.resize(columns_.size());
  rows_.emplace_back(std::move(cells), style);
}

std::string Table::text() const {
  return text(stdoutIsTerminal() ? static_cast<std::size_t>(terminalSize().columns) : SIZE_MAX);
}

std::string Table::text(std::size_t room) const {
  constexpr std::size_t kGap = 2;
  std::vector<std::size_t> width;
  for (const Column& column : columns_) width.push_back(columnsOf(column.title));
  for (const auto& [cells, style] : rows_) {
    for (std::size_t i = 0; i < cells.size(); ++i) width[i] = std::max(width[i], columnsOf(cells[i]));
  }
  std::vector<bool> shown(columns_.size(), true);
  std::size_t whole = std::accumulate(width.begin(), width.end(), kGap * (width.size() - 1));
  while (whole > room) {
    std::size_t next = 0;
    int spare = 0;
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      if (shown[i] && columns_[i].spare > spare) spare = columns_[next = i].spare;
    }
    if (spare == 0) break;
    shown[next] = false;
    whole -= width[next] + kGap;
  }
  const auto line = [&](const auto& cellAt) {
    std::string out;
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      if (!shown[i]) continue;
      const std::string& cell = cellAt(i);
      const std::string pad(width[i] - columnsOf(cell), ' ');
      if (!out.empty()) out.append(kGap, ' ');
      out += columns_[i].number ? pad + cell : cell + pad;
    }
    out.erase(out.find_last_not_of(' ') + 1);
    return out;
  };
  std::string out =
      styled(Style::kBold, line([&](std::size_t i) -> const std::string& { return columns_[i].title; })) + "\n";
  for (const auto& [cells, style] : rows_) {
    out += styled(style, line([&, &row = cells](std::size_t i) -> const std::string& { return row[i]; })) + "\n";
  }
  return out;
}

std::string fields(const std::vector<std::pair<std::string, std::string>>& lines) {
  std::size_t width = 0;
  for (const auto& [name, value] : lines) width = std::max(width, value.empty() ? 0 : columnsOf(name));
  std::string out;
  for (const auto& [name, value] : lines) {
    if (value.empty()) {
      out += styled(Style::kBold, name) + "\n";
    } else {
      out += "  " + name + std::string(width - std::min(width, columnsOf(name)) + 2, ' ') + printable(value) + "\n";
    }
  }
  return out;
}

}  // namespace hapticctl
