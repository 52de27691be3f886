/** @file
 * What hapticctl prints: text, tables and JSON on standard output; failures on standard error. Colour only on a
 * terminal, and never when NO_COLOR is set (no-color.org). A reader that goes away (EPIPE) ends the command quietly.
 */
#pragma once

#include <fmt/format.h>

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace hapticctl {

struct Failure;

/** Thrown when the reader of standard output has gone: unwind (disarm what is armed) and say nothing. */
struct OutputClosed {};

/** Text from outside (names of files, error texts) as it may reach a terminal without steering it. */
[[nodiscard]] std::string printable(std::string_view text);

/** Appends to standard output's buffer. */
void put(std::string_view text);
template <class... Args>
void print(fmt::format_string<Args...> format, Args&&... args) {
  put(fmt::format(format, std::forward<Args>(args)...));
}
/** One JSON value on one line (streams) or indented, but for vectors (single answers). Not-a-number becomes null. */
void putJson(const nlohmann::ordered_json& value, bool one_line = false);
/**
 * Writes the buffer. Throws OutputClosed, or Failure when the disk is full, or when a signal asks the command to end
 * and for a second its reader takes nothing.
 */
void flush();
/** Throws OutputClosed where nobody reads standard output any more: for who waits and has nothing to write. */
void expectReader();
/** A line on standard error, at once, printable. */
void note(std::string_view line);
/** Prints the failure on standard error; as one JSON line if `json`. */
void report(const Failure& failure, bool json);

enum class Style { kPlain, kBold, kDim, kGood, kBad, kWarn };
/** The text in that style where standard output takes colour, else the text. */
[[nodiscard]] std::string styled(Style style, std::string_view text);
[[nodiscard]] bool colourful();

/** Columns that line up. A numeric column stands to the right. */
class Table {
 public:
  struct Column {
    std::string title;
    bool number = false;
    int spare = 0;  ///< Above 0: left out where there is no room for all, the greatest first.
  };
  explicit Table(std::vector<Column> columns) : columns_(std::move(columns)) {}
  /** Missing cells are empty; `style` paints the whole row. */
  void row(std::vector<std::string> cells, Style style = Style::kPlain);
  [[nodiscard]] bool empty() const { return rows_.empty(); }
  /** As wide as it is, or, on a terminal, no wider than that if spare columns can be left out. */
  [[nodiscard]] std::string text() const;
  /** The same for so many columns of a terminal. */
  [[nodiscard]] std::string text(std::size_t room) const;

 private:
  std::vector<Column> columns_;
  std::vector<std::pair<std::vector<std::string>, Style>> rows_;
};

/** "name   value" lines that line up; a line without a value is a heading. */
[[nodiscard]] std::string fields(const std::vector<std::pair<std::string, std::string>>& lines);

}  // namespace hapticctl
